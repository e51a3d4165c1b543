"""Small scenes that the tests share. All numbers come from seeded generators, rounded so that no CPU's last bit matters."""

import numpy as np

import atlasphys as ap

SHAPES = (
    ap.Sphere(radius=0.5),
    ap.Sphere(radius=0.25),
    ap.Box(size=(1, 1, 1)),
    ap.Box(size=(1.5, 0.4, 0.6)),
    ap.Capsule(radius=0.25, length=0.75),
    ap.Cylinder(radius=0.5, length=0.75),
    ap.Cone(radius=0.5, height=1.0),
    ap.tetrahedron(radius=0.75),
    ap.octahedron(radius=0.5),
    ap.pyramid(sides=5, radius=0.5, height=0.75),
)


def stack(height=4, **settings):
    """A tower of unit boxes on a plane, already in contact."""
    world = ap.World(**settings)
    world.add(ap.Plane(normal=(0, 1, 0)), name="ground")
    for i in range(height):
        world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.5 + i, 0), name=f"box {i}")
    return world


def heap(seed, count=20, shapes=SHAPES, spread=1.5, **settings):
    """Bodies of mixed shapes thrown together, deep overlaps included, over a plane; one of them static, one kinematic."""
    rng = np.random.default_rng(seed)
    world = ap.World(**settings)
    world.add(ap.Plane(normal=(0, 1, 0)), friction=round(float(rng.uniform(0, 1)), 3))
    for i in range(count):
        kind = {3: "static", 7: "kinematic"}.get(i, "dynamic")
        moving = kind != "static"
        world.add(
            shapes[int(rng.integers(len(shapes)))],
            kind=kind,
            position=np.round(rng.uniform((-spread, 0, -spread), (spread, 2 * spread, spread)), 3),
            orientation=np.round(rng.normal(size=4), 3) + (0.001, 0, 0, 0),
            velocity=np.round(rng.normal(size=3), 3) if moving else (0, 0, 0),
            angular_velocity=np.round(rng.normal(size=3), 3) if moving else (0, 0, 0),
            density=round(float(10 ** rng.uniform(1, 4)), 1),
            friction=round(float(rng.uniform(0, 1)), 3),
            restitution=round(float(rng.uniform(0, 1)), 3),
            rolling_friction=round(float(rng.uniform(0, 0.02)), 4) if i % 3 == 0 else 0.0,
            torsional_friction=round(float(rng.uniform(0, 0.1)), 4) if i % 4 == 0 else 0.0,
            linear_damping=0.1 if i % 5 == 0 else 0.0,
            locks=("rx", "z") if i % 7 == 5 else None,
        )
    return world


def steps(world, count, dt=1 / 60):
    """Take ``count`` steps and return the state's hash."""
    for _ in range(count):
        world.step(dt)
    return world.state_hash()
