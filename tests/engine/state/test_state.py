"""Tables, derived columns and the promises of a step that fails."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import atlasphys as ap
from atlasphys.engine.constants import tolerances
from atlasphys.engine.state.arrays import CACHE_LINE, aligned_copy, aligned_zeros, copy_rows, with_capacity
from atlasphys.engine.state.bodies import empty_bodies
from atlasphys.engine.state.pose import refresh
from tests.world.scenes import heap, stack, steps


@pytest.mark.parametrize("dtype", [np.int8, np.float32, np.float64, np.int64])
@pytest.mark.parametrize("shape", [(0,), (1,), (7,), (5, 3), (16, 16), (2, 4, 3), (1 << 16, 3)])
def test_arrays_lie_on_cache_lines(dtype, shape):
    array = aligned_zeros(shape, dtype)
    assert array.shape == shape
    assert array.dtype == dtype
    assert not array.any()
    assert array.flags.c_contiguous
    assert array.ctypes.data % CACHE_LINE == 0 or array.size == 0
    assert array.flags.writeable
    copy = aligned_copy(array)
    assert copy.ctypes.data % CACHE_LINE == 0 or array.size == 0


def test_growth_and_copies_keep_rows():
    table = empty_bodies(3, np.float32)
    table.position[:] = np.arange(9).reshape(3, 3)
    grown, copied = with_capacity(table, 8), copy_rows(table)
    table.position[:] = -1
    assert grown.position[:3].tolist() == copied.position.tolist() == np.arange(9).reshape(3, 3).tolist()
    assert not grown.position[3:].any()
    assert all(len(array) == 8 for array in grown)
    assert with_capacity(grown, 2).position.tolist() == [[0, 1, 2], [3, 4, 5]]
    assert with_capacity(grown, 3, 1).position.tolist() == [[0, 1, 2], [0, 0, 0], [0, 0, 0]]
    grown.position[:] = -0.0
    assert np.signbit(with_capacity(grown, 9, 8).position[:8]).all()


def test_all_state_arrays_stay_aligned():
    world = heap(0)
    steps(world, 3)
    other = ap.World()
    other.restore(world.snapshot())
    for state in (world._state, other._state):
        for table in (state.bodies, state.colliders, state.manifolds, state.next_manifolds, state.contacts):
            for array in table:
                assert array.ctypes.data % CACHE_LINE == 0


def test_tolerances_scale_with_the_length_unit():
    assert tolerances(4.0) == tuple(4 * value for value in tolerances(1.0))


QUATERNIONS = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1)
LOCKS = st.sets(st.sampled_from(["x", "y", "z", "rx", "ry", "rz"]))


@given(q=QUATERNIONS, locks=LOCKS, precision=st.sampled_from(["single", "double"]))
def test_derived_columns(q, locks, precision):
    world = ap.World(precision=precision)
    body = world.add(
        ap.Cone(radius=0.5, height=2), orientation=q, position=(1, 2, 3), mass=2, inertia=(1, 2, 2.5), locks=locks
    )
    bodies = world._state.bodies
    refresh(bodies, 0, 1)
    w, x, y, z = np.array(q) / np.linalg.norm(q)
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    tolerance = 1e-5 if precision == "single" else 1e-12
    np.testing.assert_allclose(bodies.geometry[0, :9].reshape(3, 3), rotation, atol=tolerance)
    np.testing.assert_allclose(body.center_of_mass, (1, 2, 3) + rotation @ (0, -0.5, 0), atol=tolerance)
    # The inverse of the inertia restricted to the free axes.
    inverse = np.zeros((3, 3))
    free = [k for k, name in enumerate(("rx", "ry", "rz")) if name not in locks]
    tensor = rotation @ np.diag([1, 2, 2.5]) @ rotation.T
    inverse[np.ix_(free, free)] = np.linalg.inv(tensor[np.ix_(free, free)]) if free else 0
    xx, yy, zz, xy, xz, yz = bodies.inverse_mass[0, :6]
    np.testing.assert_allclose([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], inverse, atol=tolerance)
    assert bodies.inverse_mass[0, 6] == 0.5
    assert bodies.inverse_mass[0, 8:11].tolist() == [0 if name in locks else 0.5 for name in "xyz"]


@pytest.mark.parametrize("stage", ["find_pairs", "collide", "update_manifolds", "advance"])
@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, MemoryError])
def test_a_step_that_fails_anywhere_changes_nothing(monkeypatch, stage, error):
    from atlasphys.engine import step as step_module

    world, twin = stack(3, preset="classic"), stack(3, preset="classic")
    for each in (world, twin):
        steps(each, 5)
        each.bodies.velocity[2] = (0.5, 0, 0)
        each.bodies[1].apply_force((10, 0, 0))
    before = world.state_hash()

    def failing(original):
        def fail(*arguments):
            original(*arguments)
            raise error

        return fail

    with monkeypatch.context() as patch:
        if stage == "advance":
            solver = step_module.SOLVERS["sequential_impulse"]
            patch.setitem(step_module.SOLVERS, "sequential_impulse", solver._replace(advance=failing(solver.advance)))
        elif stage == "find_pairs":
            patch.setitem(step_module.BROADPHASES, "sweep", failing(step_module.BROADPHASES["sweep"]))
        else:
            patch.setattr(step_module, stage, failing(getattr(step_module, stage)))
        with pytest.raises(error):
            world.step(1 / 60)
    assert world.state_hash() == before
    assert steps(world, 10) == steps(twin, 10)


def test_shapes_are_shared_and_unused_ones_dropped():
    world = ap.World()
    kept = world.add(ap.Box(size=(1, 2, 3)), position=(0, 5, 0))
    for _ in range(5):
        world.add(ap.Sphere(radius=1))
    assert len(world._state.table) == 2
    for i in range(300):
        world.remove(world.add(ap.Sphere(radius=0.1 + 0.01 * i)))
    assert len(world._state.table) < 100
    assert kept.shape == ap.Box(size=(1, 2, 3))
    assert world.bodies[3].shape == ap.Sphere(radius=1)
    steps(world, 2)
