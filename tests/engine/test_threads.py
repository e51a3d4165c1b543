"""Worlds on several threads: the same bits, whatever happens around them."""

import copy
import os
import pickle
import subprocess
import sys
import threading

import numpy as np
import pytest

import atlasphys as ap
from atlasphys.engine import threads
from atlasphys.engine.run import run
from atlasphys.engine.solvers.soft_step import SoftStep
from atlasphys.engine.state.manifolds import live_rows
from atlasphys.engine.step import DivergedError, Pipeline
from atlasphys.engine.team import PATIENCE, SHARED

FOREVER = 1_000_000


def advance(world, steps, number, sleeping=False):
    run(world._state, Pipeline("tree", "auto", "soft_step", SoftStep(), number, sleeping), 1 / 60, steps)


def pile(count, shapes, precision="single", side=9):
    """A heap that falls together on a plane."""
    world, rng = ap.World(precision=precision), np.random.default_rng(1)
    world.add(ap.Plane())
    for k in range(count):
        x, z, y = k % side, k // side % side, k // side**2
        x, z = (np.array([x, z]) + rng.uniform(-0.1, 0.1, 2) - side / 2).round(9) * 1.02
        world.add(shapes[k % len(shapes)], position=(x, 0.55 + 1.02 * y, z), mass=1)
    return world


def implosion(count):
    """Bodies of all kinds that meet at high speed, some of which bounce, roll or may not turn."""
    world, rng = ap.World(gravity=(0, 0, 0)), np.random.default_rng(2)
    shapes = [ap.Box(size=(1, 0.6, 0.8)), ap.Sphere(radius=0.5), ap.Capsule(radius=0.3, length=0.6)]
    for k in range(count):
        x = rng.normal(size=3).round(9) * 6
        world.add(
            shapes[k % 3], position=x, velocity=-3 * x, angular_velocity=rng.normal(size=3).round(9), mass=1 + k % 2,
            restitution=0.5 if k % 5 == 0 else 0.0, rolling_friction=0.02 if k % 7 == 0 else 0.0,
            locks=("rx", "rz") if k % 11 == 0 else None,
        )  # fmt: skip
    return world


def loaded_plate(count):
    """One body with more contacts than there are colours."""
    world = ap.World()
    world.add(ap.Plane())
    world.add(ap.Box(size=(40, 0.5, 40)), position=(0, 0.25, 0), mass=1000)
    for k in range(count):
        world.add(ap.Box(size=(0.8, 0.8, 0.8)), position=(1.2 * (k % 30) - 18, 0.91, 1.2 * (k // 30) - 18), mass=1)
    return world


BOX, SPHERE = ap.Box(size=(1, 1, 1)), ap.Sphere(radius=0.5)
SCENES = {
    "boxes": lambda: pile(1000, [BOX]),
    "mixed": lambda: pile(1000, [BOX, SPHERE, ap.Box(size=(0.6, 0.9, 0.8)), ap.Capsule(radius=0.3, length=0.4)]),
    "hulls": lambda: pile(800, [BOX, ap.Cylinder(radius=0.4, length=0.8)]),
    "double": lambda: pile(800, [BOX, SPHERE], "double"),
    "violent": lambda: implosion(600),
    "plate": lambda: loaded_plate(600),
}


def bits(world):
    """All that a step leaves behind."""
    state = world._state
    arrays = [a[: state.count] for a in (state.bodies.position, state.bodies.orientation, state.bodies.motion)]
    arrays += [a[live_rows(state.manifolds, state.manifold_count)] for a in state.manifolds]
    return [np.ascontiguousarray(a).tobytes() for a in (*arrays, state.began, state.ended)]


@pytest.fixture
def patient(monkeypatch):
    """Teams of any number of threads, all of which take part in everything that is shared."""
    teams = {number: [] for number in (2, 3, 8)}
    for number, home in teams.items():
        team = threads.Team(number, home)
        team.sync[PATIENCE] = FOREVER
        home.append(team)
    monkeypatch.setattr(threads, "_idle", teams)
    yield {number: home[0].sync for number, home in teams.items()}
    for home in teams.values():
        home[0].close()


@pytest.mark.parametrize("name", SCENES)
def test_any_number_of_threads_gives_the_same_bits(name, patient):
    wanted = SCENES[name]()
    advance(wanted, 60, 1)
    advance(wanted, 60, 1)
    for number, sync in patient.items():
        if number == 8 and name != "boxes":
            continue  # more threads than CPUs: one scene is enough
        world = SCENES[name]()
        advance(world, 60, number)
        advance(world, 60, number)
        assert bits(world) == bits(wanted), f"{number} threads"
        assert sync[SHARED] > 120


def test_sleep_is_the_same_on_several_threads(patient):
    worlds = [pile(600, [BOX, SPHERE]) for _ in range(2)]
    for world, number in zip(worlds, (1, 2), strict=True):
        advance(world, 400, number, sleeping=True)
    assert bits(worlds[0]) == bits(worlds[1])
    assert np.array_equal(worlds[0]._state.bodies.island, worlds[1]._state.bodies.island)


def test_a_step_that_diverges_is_undone_on_several_threads(patient):
    world, other = pile(500, [BOX]), pile(500, [BOX])
    advance(world, 30, 2)
    before = bits(world)[:3]
    world._state.bodies.force[250, 0] = np.inf
    world._state.forced = True
    with pytest.raises(DivergedError):
        advance(world, 1, 2)
    assert bits(world)[:3] == before
    advance(other, 60, 2)
    world._state.bodies.force[250, 0] = 0
    advance(world, 30, 2)  # and the team still works
    assert bits(world)[:3] == bits(other)[:3]


def test_worlds_may_step_in_several_python_threads():
    wanted = pile(500, [BOX])
    advance(wanted, 60, 1)
    worlds = [pile(500, [BOX]) for _ in range(3)]
    stepping = [threading.Thread(target=advance, args=(world, 60, 2)) for world in worlds]
    for thread in stepping:
        thread.start()
    for thread in stepping:
        thread.join()
    assert all(bits(world) == bits(wanted) for world in worlds)


@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda world: pickle.loads(pickle.dumps(world))])
def test_worlds_can_be_copied_after_use(duplicate):
    world = pile(500, [BOX])
    advance(world, 10, 2)
    twin = duplicate(world)
    advance(world, 20, 2)
    advance(twin, 20, 2)
    assert bits(world)[:3] == bits(twin)[:3]


FORK = """
import os, sys
sys.path.insert(0, {tests!r})
from engine.test_threads import BOX, advance, bits, pile
import hashlib
world = pile(500, [BOX])
advance(world, 20, 2)
child = os.fork()
advance(world, 40, 2)
digest = hashlib.sha256(b"".join(bits(world))).hexdigest()
if child:
    assert os.waitpid(child, 0)[1] == 0
print(digest, flush=True)
"""


def run_script(text, **environment):
    tests = os.path.dirname(os.path.dirname(__file__))
    return subprocess.run(
        [sys.executable, "-W", "ignore::DeprecationWarning", "-c", text.format(tests=tests)],
        env={**os.environ, **environment}, capture_output=True, text=True, timeout=100, check=True,
    )  # fmt: skip


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_a_forked_process_makes_threads_of_its_own():
    digests = run_script(FORK).stdout.split()
    assert len(digests) == 2
    assert digests[0] == digests[1]


UNCOMPILED = """
import sys
sys.path.insert(0, {tests!r})
from engine.test_threads import SPHERE, advance, pile
for number in (1, 2):
    world = pile(3, [SPHERE])
    advance(world, 2, number)
    print(world.bodies.position.tolist())
"""


def test_without_compiling_a_team_is_one_thread():
    one, two = run_script(UNCOMPILED, NUMBA_DISABLE_JIT="1").stdout.splitlines()
    assert one == two
