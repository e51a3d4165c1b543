"""Rows of manifolds are given to pairs with contact points and given back, whatever happens to the world; and nobody sees which."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import atlasphys as ap
from atlasphys.engine.state.manifolds import live_rows
from atlasphys.engine.state.work import FREE, PAIRS, ROWS, TAKEN

DT = 1 / 60
BOX, BALL, CYLINDER = ap.Box(size=(1, 1, 1)), ap.Sphere(radius=0.5), ap.Cylinder(radius=0.5, length=1)
PLACE = st.tuples(*[st.floats(-1.2, 1.2)] * 3)
CHANGES = st.one_of(
    st.tuples(st.just("add"), st.sampled_from([BOX, BALL, CYLINDER]), PLACE),
    st.tuples(st.just("remove"), st.integers(0, 30)),
    st.tuples(st.just("move"), st.integers(0, 30), PLACE),
    st.tuples(st.just("friction"), st.integers(0, 30), st.floats(0, 1)),
    st.tuples(st.just("steps"), st.sampled_from([1, 3, 45])),
    st.tuples(st.just("diverge"), st.integers(0, 30)),
    st.tuples(st.just("threads"), st.sampled_from([1, 2])),
    st.tuples(st.just("solver"), st.sampled_from(["soft_step", "xpbd", "sequential_impulse"])),
)


def change(world: ap.World, what, *values) -> None:
    """Do to a world what a user may do; ``bodies[0]`` is the ground."""
    if what == "add":
        x, y, z = values[1]
        world.add(values[0], position=(x, y + 2, z))
    elif what == "steps":
        world.run(seconds=values[0] * DT, dt=DT)
    elif what == "solver":
        world.threads, world.solver = 1, values[0]
    elif what == "threads":
        if world.solver == "soft_step":
            world.threads = values[0]
    elif len(world.bodies) > 1:
        body = world.bodies[1 + values[0] % (len(world.bodies) - 1)]
        if what == "remove":
            world.remove(body)
        elif what == "move":
            x, y, z = values[1]
            body.position = (x, y + 2, z)
        elif what == "friction":
            body.friction = values[1]
        elif what == "diverge":
            body.velocity = (0, 0, 0)
            world._state.bodies.force[:, 0], world._state.forced = np.inf, True
            with pytest.raises(ap.DivergenceError):
                world.step(DT)
            world._state.bodies.force[:] = 0


def check_rows(world: ap.World) -> None:
    """Each row is that of one pair with points in the present table, or free, or the one that nobody has."""
    state = world._state
    if state.workspace is None:
        return
    work, table = state.workspace.work, state.manifolds
    assert len(table.a) == len(state.next_manifolds.a) == len(work.free) == len(work.ended)
    rows, free = int(work.status[ROWS]), work.free[: work.status[FREE]]
    row = work.row[: work.status[PAIRS]]
    live = row[table.count[row] > 0]
    assert work.status[TAKEN] == 0
    assert sorted([0, *free, *live]) == list(range(rows))
    assert not table.count[[0, *free]].any()
    assert not state.next_manifolds.count[[0, *free]].any()
    pairs = work.pairs[: work.status[PAIRS]][table.count[row] > 0]
    np.testing.assert_array_equal(np.stack([table.a[live], table.b[live]], axis=1), pairs)
    np.testing.assert_array_equal(live_rows(table, state.manifold_count), live)  # pairs are ordered


@pytest.mark.parametrize("steps", range(28, 36))
def test_the_first_contact_of_a_world_finds_room_in_either_table(steps):
    world = ap.World()
    world.add(ap.Plane())
    world.add(BOX, position=(0, 0.5 + 0.5 * 9.81 * (steps * DT) ** 2, 0))
    for _ in range(8):
        world.run(seconds=5 * DT, dt=DT)
        check_rows(world)
    assert len(world.contacts) == 4


def seen(world: ap.World):
    """What a user sees of contacts, and the digest of all that decides how the world goes on."""
    return world.contacts.tobytes(), [repr(event) for event in world.events], world.state_hash()


@pytest.mark.parametrize(
    "settings_of", [{}, {"broadphase": "sweep"}, {"solver": ap.SoftStep(contact_recycling=False)}, {"solver": "xpbd"}]
)
def test_a_world_goes_on_as_one_that_knows_nothing_of_rows(settings_of):
    """The other one is restored from its own snapshot again and again, and so has new rows each time."""

    @settings(max_examples=20, deadline=None)
    @given(st.lists(CHANGES, min_size=6, max_size=20))
    def goes_on(changes):
        worlds = [ap.World(**settings_of) for _ in range(2)]
        for world in worlds:
            world.add(ap.Plane())
            for k in range(6):
                world.add((BOX, BALL)[k % 2], position=(0.9 * (k % 3), 0.5 + 0.98 * (k // 3), 0))
        for what in changes:
            change(worlds[0], *what)
            check_rows(worlds[0])
            worlds[1].restore(worlds[1].snapshot())
            change(worlds[1], *what)
            assert seen(worlds[0]) == seen(worlds[1])

    goes_on()


def test_rows_are_taken_again():
    """A ball that hops from box to box has had many contacts, and its world but few rows."""
    world = ap.World(gravity=(0, 0, 0))
    for k in range(40):
        world.add(BOX, position=(3 * k, 0, 0), kind="static")
    ball = world.add(BALL)
    for k in range(40):
        ball.position, ball.velocity = (3 * k, 0.99, 0), (0, 0, 0)
        world.step(DT)
        assert len(world.contacts) == 1
        check_rows(world)
    assert world._state.manifold_count <= 3


def test_a_snapshot_holds_no_more_than_the_contacts():
    world = ap.World()
    world.add(ap.Plane())
    for k in range(50):
        world.add(BALL, position=(1.05 * (k % 8), 0.5, 1.05 * (k // 8)))
    world.run(seconds=0.2, dt=DT)
    assert len(world._state.copy().manifolds.a) == len(world.contacts) == 50
    assert world._state.workspace.work.status[PAIRS] > 100
