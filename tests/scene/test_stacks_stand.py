"""The stacks of the library stand for ten seconds at the default settings."""

import numpy as np
import pytest

import atlasphys as ap


@pytest.mark.parametrize(("name", "sideways", "sunk"), [("tower", 0.002, 0.025), ("pyramid", 0.03, 0.04)])
def test_stands_for_ten_seconds(name, sideways, sunk):
    scene = ap.load_scene(name)
    world = scene.build()
    start = world.bodies.position.copy()
    world.run(seconds=10, dt=scene.dt)
    moved = np.abs(world.bodies.position - start)
    assert moved[:, [0, 2]].max() < sideways
    assert moved[:, 1].max() < sunk
    assert world.energy().kinetic < 1
    assert world.contacts.depth.max() < 0.01
