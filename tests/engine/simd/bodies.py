"""Two realistic kernel bodies with their drivers, for tests and benchmarks, and the second one in scalar code."""

import math

import numpy as np

from atlasphys.engine.jit import kernel
from atlasphys.engine.simd import gather, load, maximum, minimum, scatter, select, simd_kernel, store

# Fields of a contact block.
NORMAL, ARM_A, ARM_B, TANGENT, NORMAL_MASS, MASS_1, MASS_2, BIAS, FRICTION, IMPULSE, IMPULSE_1, IMPULSE_2 = (
    0, 3, 6, 9, 12, 13, 14, 15, 16, 17, 18, 19,
)  # fmt: skip
FIELDS = 20


@simd_kernel
def restitution_impulse(block, speed, inverse_mass, restitution, accumulated, change):
    """Change of the accumulated normal impulse of a contact, never letting the total pull [N·s]."""
    v, old = load(speed, block), load(accumulated, block)
    bounce = select(v < -1.0, load(restitution, block), 0.0)
    wanted = old - (1.0 + bounce) * v / load(inverse_mass, block)
    store(change, block, maximum(wanted, 0.0) - old)


@kernel
def restitution_impulses(speed, inverse_mass, restitution, accumulated, change):
    for block in range(speed.shape[0]):
        restitution_impulse(block, speed, inverse_mass, restitution, accumulated, change)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def add_scaled(a, b, s):
    return a[0] + b[0] * s, a[1] + b[1] * s, a[2] + b[2] * s


def times(m, v):
    """Symmetric matrix xx yy zz xy xz yz times a vector."""
    return (
        m[0] * v[0] + m[3] * v[1] + m[4] * v[2],
        m[3] * v[0] + m[1] * v[1] + m[5] * v[2],
        m[4] * v[0] + m[5] * v[1] + m[2] * v[2],
    )


@simd_kernel
def contact(block, contacts, bodies, motions, constants, relax):
    """One sweep over eight contact points: the normal impulse, then friction within the cone's box, applied at once."""

    def vector(field):
        return tuple(load(contacts, block, field + k) for k in range(3))

    def number(field):
        return load(contacts, block, field)

    row_a, row_b = load(bodies, block, 0), load(bodies, block, 1)
    a, b = gather(motions, row_a), gather(motions, row_b)
    (inverse_a, *inertia_a, moves_a), (inverse_b, *inertia_b, moves_b) = (
        gather(constants, row_a),
        gather(constants, row_b),
    )
    va, wa, vb, wb = a[0:3], a[3:6], b[0:3], b[3:6]
    arm_a, arm_b, normal, tangent = vector(ARM_A), vector(ARM_B), vector(NORMAL), vector(TANGENT)

    def speed(axis):
        at_a, at_b = cross(wa, arm_a), cross(wb, arm_b)
        return dot(tuple(vb[k] + at_b[k] - va[k] - at_a[k] for k in range(3)), axis)

    def apply(axis, impulse):
        return (
            add_scaled(va, axis, -inverse_a * impulse),
            add_scaled(wa, times(inertia_a, cross(arm_a, axis)), -impulse),
            add_scaled(vb, axis, inverse_b * impulse),
            add_scaled(wb, times(inertia_b, cross(arm_b, axis)), impulse),
        )

    old = number(IMPULSE)
    bias = select(relax, 0.0, number(BIAS))
    pressed = maximum(old - number(NORMAL_MASS) * (speed(normal) + bias), 0.0)
    store(contacts, block, IMPULSE, pressed)
    va, wa, vb, wb = apply(normal, pressed - old)

    most = number(FRICTION) * pressed
    for axis, mass, field in ((tangent, MASS_1, IMPULSE_1), (cross(normal, tangent), MASS_2, IMPULSE_2)):
        old = number(field)
        rubbed = maximum(minimum(old - number(mass) * speed(axis), most), -most)
        store(contacts, block, field, rubbed)
        va, wa, vb, wb = apply(axis, rubbed - old)

    scatter(motions, row_a, (*va, *wa, *a[6:]), where=moves_a > 0)
    scatter(motions, row_b, (*vb, *wb, *b[6:]), where=moves_b > 0)


@kernel
def solve_contacts(contacts, bodies, motions, constants, relax, sweeps):
    for _ in range(sweeps):
        for block in range(contacts.shape[0]):
            contact(block, contacts, bodies, motions, constants, relax)


@kernel
def solve_contacts_scalar(contacts, bodies, motions, constants, relax, sweeps):
    """The same arithmetic, contact by contact."""
    zero = contacts.dtype.type(0)
    for _ in range(sweeps):
        for block in range(contacts.shape[0]):
            for lane in range(8):
                c = contacts[block]
                a, b = bodies[block, 0, lane], bodies[block, 1, lane]
                # fmt: off
                ma, mb = motions[a], motions[b]
                ka, kb = constants[a], constants[b]
                ka0, ka1, ka2, ka3, ka4, ka5, ka6, ka7 = ka[0], ka[1], ka[2], ka[3], ka[4], ka[5], ka[6], ka[7]
                kb0, kb1, kb2, kb3, kb4, kb5, kb6, kb7 = kb[0], kb[1], kb[2], kb[3], kb[4], kb[5], kb[6], kb[7]
                vax, vay, vaz, wax, way, waz = ma[0], ma[1], ma[2], ma[3], ma[4], ma[5]
                vbx, vby, vbz, wbx, wby, wbz = mb[0], mb[1], mb[2], mb[3], mb[4], mb[5]
                rax, ray, raz = c[3, lane], c[4, lane], c[5, lane]
                rbx, rby, rbz = c[6, lane], c[7, lane], c[8, lane]
                nx, ny, nz = c[0, lane], c[1, lane], c[2, lane]
                tx, ty, tz = c[9, lane], c[10, lane], c[11, lane]
                most = zero
                for step in range(3):
                    if step == 0:
                        x, y, z = nx, ny, nz
                    elif step == 1:
                        x, y, z = tx, ty, tz
                    else:
                        x, y, z = ny * tz - nz * ty, nz * tx - nx * tz, nx * ty - ny * tx
                    ux = vbx + (wby * rbz - wbz * rby) - vax - (way * raz - waz * ray)
                    uy = vby + (wbz * rbx - wbx * rbz) - vay - (waz * rax - wax * raz)
                    uz = vbz + (wbx * rby - wby * rbx) - vaz - (wax * ray - way * rax)
                    speed = ux * x + uy * y + uz * z
                    old = c[17 + step, lane]
                    if step == 0:
                        bias = zero if relax else c[15, lane]
                        new = old - c[12, lane] * (speed + bias)
                        new = new if new > zero else zero
                        most = c[16, lane] * new
                    else:
                        new = old - c[12 + step, lane] * speed
                        new = new if new < most else most
                        new = new if new > -most else -most
                    c[17 + step, lane] = new
                    p = new - old
                    vax, vay, vaz = vax + x * (-ka0 * p), vay + y * (-ka0 * p), vaz + z * (-ka0 * p)
                    vbx, vby, vbz = vbx + x * (kb0 * p), vby + y * (kb0 * p), vbz + z * (kb0 * p)
                    qx, qy, qz = ray * z - raz * y, raz * x - rax * z, rax * y - ray * x
                    wax, way, waz = (
                        wax + (ka1 * qx + ka4 * qy + ka5 * qz) * -p,
                        way + (ka4 * qx + ka2 * qy + ka6 * qz) * -p,
                        waz + (ka5 * qx + ka6 * qy + ka3 * qz) * -p,
                    )
                    qx, qy, qz = rby * z - rbz * y, rbz * x - rbx * z, rbx * y - rby * x
                    wbx, wby, wbz = (
                        wbx + (kb1 * qx + kb4 * qy + kb5 * qz) * p,
                        wby + (kb4 * qx + kb2 * qy + kb6 * qz) * p,
                        wbz + (kb5 * qx + kb6 * qy + kb3 * qz) * p,
                    )
                if ka7 > zero:
                    ma[0], ma[1], ma[2], ma[3], ma[4], ma[5] = vax, vay, vaz, wax, way, waz
                if kb7 > zero:
                    mb[0], mb[1], mb[2], mb[3], mb[4], mb[5] = vbx, vby, vbz, wbx, wby, wbz
                # fmt: on


def contact_problem(blocks, real, seed=0):
    """Random contacts: within a block no body is twice, and one row in eight is static."""
    rng = np.random.default_rng(seed)
    count = max(4 * blocks, 32)
    motions = rng.normal(size=(count, 16)).astype(real)
    constants = np.zeros((count, 8), real)
    constants[:, 0] = rng.uniform(0.5, 2, count)
    constants[:, 1:4] = rng.uniform(3, 6, (count, 3))
    constants[:, 4:7] = rng.uniform(-1, 1, (count, 3))
    constants[:, 7] = 1
    constants[::8] = 0
    bodies = np.stack([rng.permutation(count)[:16].reshape(2, 8) for _ in range(blocks)]).astype(np.int32)
    contacts = rng.uniform(-0.5, 0.5, (blocks, FIELDS, 8)).astype(real)
    normal = rng.normal(size=(blocks, 3, 8))
    tangent = np.cross(normal, rng.normal(size=(blocks, 3, 8)), axis=1)
    contacts[:, NORMAL : NORMAL + 3] = normal / np.sqrt((normal * normal).sum(1, keepdims=True))
    contacts[:, TANGENT : TANGENT + 3] = tangent / np.sqrt((tangent * tangent).sum(1, keepdims=True))
    contacts[:, NORMAL_MASS:BIAS] = rng.uniform(0.1, 0.3, (blocks, 3, 8))
    contacts[:, FRICTION:] = rng.uniform(0, math.sqrt(0.5), (blocks, 4, 8))
    return contacts, bodies, motions, constants
