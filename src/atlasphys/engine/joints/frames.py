"""Frames of joints, worked out in double precision when a joint is made. Quaternions (w, x, y, z) and vectors are tuples of Python numbers.

Only + − × ÷ √: sines of the system's library differ in their last bits between systems.
"""

import math

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Pose = tuple[Vector, Quaternion]
"""Position and orientation."""

IDENTITY: Quaternion = (1.0, 0.0, 0.0, 0.0)

TO_Y: Quaternion = (0.5, 0.5, 0.5, 0.5)
TO_Z: Quaternion = (0.5, -0.5, -0.5, -0.5)
"""Turns that take x to y and to z; the other axes follow in their cyclic order."""


def multiply(p: Quaternion, q: Quaternion) -> Quaternion:
    """p q: first the turn q, then p."""
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


def conjugate(q: Quaternion) -> Quaternion:
    """The inverse of a unit quaternion."""
    return q[0], -q[1], -q[2], -q[3]


def unit(q: Quaternion) -> Quaternion:
    """q / |q|."""
    size = math.sqrt(sum(x * x for x in q))
    return q[0] / size, q[1] / size, q[2] / size, q[3] / size


def rotate(q: Quaternion, v: Vector) -> Vector:
    """q v q*."""
    _, x, y, z = multiply(multiply(q, (0.0, *v)), conjugate(q))
    return x, y, z


def cross(u: Vector, v: Vector) -> Vector:
    """u × v."""
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


def dot(u: Vector, v: Vector) -> float:
    """u · v."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def scaled(u: Vector, s: float) -> Vector:
    """s u."""
    return s * u[0], s * u[1], s * u[2]


def difference(u: Vector, v: Vector) -> Vector:
    """u − v."""
    return u[0] - v[0], u[1] - v[1], u[2] - v[2]


def normalised(u: Vector) -> Vector:
    """u / |u|, for any finite u but zero."""
    largest = max(map(abs, u))
    u = scaled(u, 1 / largest) if largest < 1e300 else (u[0] / largest, u[1] / largest, u[2] / largest)
    return scaled(u, 1 / math.sqrt(dot(u, u)))


def shortest_turn(n: Vector) -> Quaternion:
    """The turn through the least angle that takes the x axis to the unit vector n."""
    if n[0] < -1 + 1e-12:
        return 0.0, 0.0, 1.0, 0.0
    return unit((1 + n[0], 0.0, -n[2], n[1]))


def of_axes(x: Vector, y: Vector) -> Quaternion:
    """The turn that takes the axes x and y to two perpendicular unit vectors: first x to its place, then about it."""
    first = shortest_turn(x)
    now = rotate(first, (0.0, 1.0, 0.0))
    c, s = dot(now, y), dot(cross(now, y), x)
    # Half the angle, from its cosine and sine
    w, t = (1 + c, s) if c > 0 else (abs(s), math.copysign(1 - c, s))
    return multiply(unit((w, t * x[0], t * x[1], t * x[2])), first)


def turn(axis: Vector, angle: float) -> Quaternion:
    """The turn by an angle between −π and π about a unit vector."""
    x = 0.5 * angle
    sine = cosine = 0.0
    term = 1.0
    for k in range(40):  # the series of the exponential of i x
        part = term if k % 4 in (0, 1) else -term
        if k % 2:
            sine += part
        else:
            cosine += part
        term *= x / (k + 1)
    return unit((cosine, sine * axis[0], sine * axis[1], sine * axis[2]))


def to_body(pose: Pose | None, point: Vector) -> Vector:
    """A point of the world in the axes of a body; the same point if that is the world."""
    return point if pose is None else rotate(conjugate(pose[1]), difference(point, pose[0]))


def to_world(pose: Pose | None, point: Vector) -> Vector:
    """A point of a body in the world."""
    if pose is None:
        return point
    turned = rotate(pose[1], point)
    return pose[0][0] + turned[0], pose[0][1] + turned[1], pose[0][2] + turned[2]


def frame_to_body(pose: Pose | None, frame: Quaternion) -> Quaternion:
    """A frame of the world in the axes of a body."""
    return frame if pose is None else unit(multiply(conjugate(pose[1]), frame))


def frame_to_world(pose: Pose | None, frame: Quaternion) -> Quaternion:
    """A frame of a body in the world."""
    return frame if pose is None else unit(multiply(pose[1], frame))
