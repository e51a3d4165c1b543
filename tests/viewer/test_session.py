"""The model below the window: what commands do to the world, without a browser."""

import threading
import time

import numpy as np
import pytest

import atlasphys as ap
from atlasphys.viewer.history import INTERVAL
from atlasphys.viewer.meter import Beat
from atlasphys.viewer.session import EDITABLE, Session
from atlasphys.viewer.simulation import Simulation

DT = 1 / 60


@pytest.fixture(scope="module", autouse=True)
def _compiled_kernels():
    """So that no wall time below is the compiler's."""
    for make in (tower, falling_ball):
        make().step()


def tower(height=3):
    return Session.from_scene(ap.load_scene("tower", height=height))


def falling_ball(**settings):
    world = ap.World(**settings)
    world.add(ap.Plane())
    world.add(ap.Sphere(radius=0.5), position=(0, 50, 0), name="ball")
    return Session(world, title="ball", dt=DT)


def identity_of(session, name):
    return int(session.world.bodies.id[session.world.bodies[name].row])


def test_time_runs_in_whole_steps_whatever_the_frame_rate():
    """The same wall time in many or few pieces takes the same steps, to the bit."""
    hashes = set()
    for pieces in (1, 3, 60, 100):
        session = falling_ball()
        session.start()
        for _ in range(pieces):
            session.advance(0.5001 / pieces, budget=10)
        assert session.world.steps == 30
        hashes.add(session.world.state_hash())
    assert len(hashes) == 1


def test_a_stopped_session_does_not_move():
    session = falling_ball()
    before = session.world.state_hash()
    session.advance(10.0)
    assert session.world.state_hash() == before
    session.start()
    session.advance(0.1, budget=10)
    session.stop()
    steps = session.world.steps
    session.advance(10.0)
    assert session.world.steps == steps == 6


def test_the_speed_factor_scales_time_not_the_step():
    session = falling_ball()
    session.set_speed(0.5)
    session.start()
    session.advance(1.001, budget=10)
    assert session.world.steps == 30
    assert session.world.time == pytest.approx(0.5)
    for bad in (0, -1, 1e9, float("nan")):
        with pytest.raises(ap.InvalidArgumentError, match="speed"):
            session.set_speed(bad)
    assert session.speed == 0.5


def test_time_that_the_world_is_too_slow_for_is_dropped():
    session = tower()
    session.start()
    session.advance(1e6, budget=0.02)
    assert 1 <= session.world.steps < 1e5
    steps = session.world.steps
    session.advance(0.0, budget=10)
    assert session.world.steps - steps <= 1


@pytest.mark.parametrize("solver", ["soft_step", "sequential_impulse"])
def test_stepping_back_gives_every_state_again_to_the_bit(solver):
    session = tower()
    session.configure(solver=solver)
    hashes = []
    for k in range(3 * INTERVAL + 2):
        hashes.append(session.world.state_hash())
        if k == 7:
            session.configure(gravity=(1, -5, 0))
            session.edit(identity_of(session, "cube 1"), {"velocity": (0, 2, 0)})
            hashes[-1] = session.world.state_hash()
        session.step()
    while hashes:
        session.step_back()
        assert session.world.state_hash() == hashes.pop()
    assert session.world.steps == 0
    with pytest.raises(ap.InvalidArgumentError, match="beginning"):
        session.step_back()


def test_stepping_back_over_an_added_body_takes_it_away():
    session = tower()
    session.step(3)
    session.add({"shape": {"type": "sphere", "radius": 0.3}, "position": (0, 9, 0)})
    session.step()
    assert len(session.frame().table) == 5
    session.step_back()
    assert len(session.frame().table) == 5
    session.step_back()
    assert len(session.frame().table) == len(session.world.bodies) == 4


def test_stepping_back_while_a_body_was_dragged_is_exact():
    session = falling_ball()
    session.step(2)
    session.grab(identity_of(session, "ball"), session.world.bodies["ball"].position)
    session.drag((3, 50, 0))
    hashes = []
    for _ in range(15):
        hashes.append(session.world.state_hash())
        session.step()
    for expected in reversed(hashes):
        session.step_back()
        assert session.world.state_hash() == expected


def test_reset_returns_to_the_beginning_and_keeps_settings():
    session = tower()
    begin, positions = session.world.state_hash(), session.world.bodies.position.copy()
    session.step(20)
    session.reset()
    assert session.world.state_hash() == begin
    session.step(20)
    session.configure(solver="sequential_impulse", gravity=(0, -3, 0), dt=0.01)
    session.reset()
    np.testing.assert_array_equal(session.world.bodies.position, positions)
    assert session.world.steps == 0
    assert (session.world.solver, session.dt) == ("sequential_impulse", 0.01)
    assert session.world.gravity.tolist() == [0, -3, 0]
    assert not session.running


def test_what_is_added_before_the_first_step_belongs_to_the_beginning():
    session = tower()
    session.add({"shape": {"type": "box", "size": (1, 1, 1)}, "position": (5, 1, 0)})
    session.step(3)
    session.add({"shape": {"type": "box", "size": (1, 1, 1)}, "position": (8, 1, 0)})
    assert len(session.world.bodies) == 6
    session.reset()
    assert len(session.world.bodies) == len(session.frame().table) == 5


def test_a_diverging_step_stops_time_and_names_the_bodies():
    world = ap.World()
    world.add(ap.Plane(), name="ground")
    world.add(ap.Sphere(radius=0.5), mass=1e36, position=(0, 0.4, 0), velocity=(0, -1e4, 0), name="star")
    session = Session(world, dt=1e-4)
    session.start()
    session.advance(1.0, budget=1)
    assert not session.running
    assert "star" in session.frame().error
    steps = session.world.steps
    session.advance(1.0)
    assert session.world.steps == steps
    session.edit(identity_of(session, "star"), {"velocity": (0, 0, 0)})
    session.start()
    assert session.frame().error == ""


@pytest.mark.parametrize(
    ("shape", "kind"),
    [
        ({"type": "box", "size": (1, 2, 3)}, "Box"),
        ({"type": "sphere", "radius": 0.5}, "Sphere"),
        ({"type": "capsule", "radius": 0.5, "length": 1.0}, "Capsule"),
        ({"type": "cylinder", "radius": 0.5, "length": 1.0}, "Cylinder"),
        ({"type": "cone", "radius": 0.5, "height": 1.0}, "Cone"),
        ({"type": "tetrahedron", "radius": 0.5}, "ConvexHull"),
        ({"type": "pyramid", "sides": 5, "radius": 0.5, "height": 1.0}, "ConvexHull"),
        ({"type": "octahedron", "radius": 0.5}, "ConvexHull"),
        ({"type": "plane", "normal": (1, 0, 0), "offset": -9.0}, "Plane"),
    ],
)
def test_every_shape_can_be_added(shape, kind):
    session = Session.empty()
    identity = session.add({"shape": shape, "color": "#336699", "friction": 0.7})
    body = session.body(identity)
    assert type(body.shape).__name__ == kind
    assert body.friction == pytest.approx(0.7)
    session.step(2)
    assert session.frame().table.row(identity) == 1


def test_bad_values_are_refused_with_all_reasons_and_nothing_is_added():
    session = Session.empty()
    with pytest.raises(ap.InvalidArgumentError) as caught:
        session.add({"shape": {"type": "box", "size": (1, -1, 1)}, "friction": -1.0, "mass": 0.0})
    text = str(caught.value)
    assert "size" in text
    assert "friction" in text
    assert "mass" in text
    assert "bodies[0]" not in text
    with pytest.raises(ap.InvalidArgumentError, match="mass and density"):
        session.add({"shape": {"type": "sphere", "radius": 1.0}, "mass": 1.0, "density": 1.0})
    assert len(session.world.bodies) == 1


def test_delete_duplicate_clear():
    session = tower()
    cube = identity_of(session, "cube 0")
    copy = session.duplicate(cube)
    assert session.body(copy).shape == session.body(cube).shape
    assert session.body(copy).name is None
    session.step(2)
    session.remove(cube)
    assert session.frame().table.row(cube) is None
    with pytest.raises(ap.InvalidArgumentError, match="no longer there"):
        session.remove(cube)
    session.clear()
    assert [body.name for body in session.world.bodies] == ["ground"]
    session.step()


def test_properties_are_edited_all_or_none():
    session = tower()
    cube = identity_of(session, "cube 1")
    session.edit(cube, {"position": (1, 4, 0), "friction": 0.1})
    assert session.body(cube).position.tolist() == [1, 4, 0]
    with pytest.raises(ap.InvalidArgumentError, match="restitution"):
        session.edit(cube, {"position": (7, 7, 7), "restitution": 2.0})
    assert session.body(cube).position.tolist() == [1, 4, 0]
    with pytest.raises(ap.InvalidArgumentError, match="mass"):
        session.edit(cube, {"mass": 3.0})
    assert all(hasattr(ap.Body, name) for name in EDITABLE)


def test_settings_change_between_steps_and_bad_ones_are_refused():
    session = tower()
    session.step()
    for solver in ("sequential_impulse", "soft_step"):
        session.configure(solver=solver, narrowphase="gjk_epa", broadphase="sweep")
        session.step()
        assert session.settings()["solver"] == solver
    assert session.settings()["sleeping"] is True
    session.configure_solver(substeps=7)
    assert session.world.substeps == 7
    for bad in ({"dt": 0.0}, {"solver": "magic"}, {"threads": 0}, {"precision": "double"}):
        with pytest.raises(ap.InvalidArgumentError):
            session.configure(**bad)
    with pytest.raises(ap.InvalidArgumentError, match="substeps"):
        session.configure_solver(substeps=0)


def test_scenes_are_loaded_unloaded_saved(tmp_path):
    session = tower()
    session.step(5)
    session.load("pyramid", base=3)
    assert session.title == "pyramid"
    assert session.world.steps == 0
    with pytest.raises(ap.SceneError, match="pyramid"):
        session.load("pyramidd")
    assert session.title == "pyramid"
    session.step(10)
    path = tmp_path / "saved.toml"
    session.save(path)
    with pytest.raises(ap.SceneError, match="already"):
        session.save(path)
    session.save(path, replace=True)
    positions = session.world.bodies.position.copy()
    session.unload()
    assert len(session.world.bodies) == 1
    session.load_text(path.read_text(), "saved.toml")
    np.testing.assert_array_equal(session.world.bodies.position, positions)
    session.load(path)
    np.testing.assert_array_equal(session.world.bodies.position, positions)


def test_a_dragged_body_comes_to_the_pointer_and_can_be_thrown():
    session = falling_ball()
    ball = session.world.bodies["ball"]
    session.grab(identity_of(session, "ball"), ball.position + (0.5, 0, 0))
    session.drag((3, 52, 1))
    session.step(120)
    assert np.linalg.norm(session.grab_held.point - (3, 52, 1)) < 0.05
    for k in range(30):
        session.drag((3 + 0.1 * k, 52, 1))
        session.step()
    session.let_go()
    assert ball.velocity[0] > 3
    height = ball.position[1]
    session.step(30)
    assert ball.position[1] < height
    session.grab(identity_of(session, "ball"), ball.position)
    session.remove(identity_of(session, "ball"))
    session.step()


def test_a_static_body_cannot_be_grabbed():
    session = tower()
    session.grab(identity_of(session, "ground"), (0, 0, 0))
    session.drag((1, 1, 1))
    assert session.grab_held is None


def test_a_frame_tells_what_the_world_is():
    session = tower()
    session.contacts_wanted = session.totals_wanted = True
    session.step(3)
    frame, world = session.frame(), session.world
    np.testing.assert_array_equal(frame.position, world.bodies.position)
    assert frame.contact_count == len(frame.contacts) == len(world.contacts) > 0
    assert sum(frame.energy) == world.energy().total
    assert frame.title == "tower"
    assert [entry.name for entry in frame.table.entries] == world.bodies.names
    assert set(frame.stages) == set(world.profile)
    session.step()
    assert frame.time < session.frame().time
    assert session.frame().table is frame.table


def test_acceleration_is_that_of_the_last_step():
    session = falling_ball()
    session.step(2)
    row = session.world.bodies["ball"].row
    np.testing.assert_allclose(session.frame().acceleration[row], (0, -9.81, 0), rtol=1e-3)
    session.edit(identity_of(session, "ball"), {"velocity": (100, 0, 0)})
    np.testing.assert_allclose(session.frame().acceleration[row], 0)


def test_the_thread_executes_commands_between_steps_and_publishes_frames():
    simulation = Simulation(tower())
    try:
        first = simulation.frame
        simulation.do(Session.start).result(timeout=60)
        frame = simulation.wait_for_news(first, 10.0)
        deadline = time.monotonic() + 60
        while frame.steps < 5 and time.monotonic() < deadline:
            frame = simulation.wait_for_news(frame, 1.0)
        assert frame.running
        assert frame.steps >= 5
        simulation.do(Session.stop).result(timeout=10)
        stopped = simulation.do(lambda session: session.world.steps).result(timeout=10)
        time.sleep(0.1)
        assert simulation.do(lambda session: session.world.steps).result(timeout=10) == stopped
        with pytest.raises(ap.SceneError):
            simulation.do(lambda session: session.load("nothing")).result(timeout=10)
        assert simulation.do(lambda session: threading.current_thread().name).result(timeout=10) == "simulation"
    finally:
        simulation.end()
    with pytest.raises(RuntimeError, match="ended"):
        simulation.do(Session.start).result(timeout=1)


def test_many_threads_may_queue_commands():
    simulation = Simulation(Session.empty())
    try:
        simulation.do(Session.start).result(timeout=60)

        def add(k):
            for j in range(5):
                entry = {"shape": {"type": "sphere", "radius": 0.4}, "position": (3 * k, 1 + j, 0)}
                simulation.do(lambda session, entry=entry: session.add(entry)).result(timeout=60)

        threads = [threading.Thread(target=add, args=(k,)) for k in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert simulation.do(lambda session: len(session.world.bodies)).result(timeout=10) == 21
        assert simulation.do(lambda session: session.error).result(timeout=10) == ""
    finally:
        simulation.end()


def test_a_beat_keeps_to_multiples_of_its_period():
    """However late each tick is noticed, so many come in a second; what would have been in a longer pause is left out."""
    beat, now, ticks = Beat(0.1), 50.0, []
    delays = np.random.default_rng(1).uniform(0, 0.09, 100)
    for delay in delays:
        now += beat.wait(now) + delay
        assert beat.wait(now) == 0
        beat.tick(now)
        ticks.append(now)
    assert abs((ticks[-1] - ticks[0]) - 9.9) < 0.1
    now += 5.0
    beat.tick(now)
    assert beat.wait(now) == pytest.approx(0.1)


def test_the_kinetic_energy_of_a_body_holds_its_rotation():
    world = ap.World(gravity=(0, 0, 0))
    turn = np.array([1.0, 2.0, 3.0, 4.0]) / np.sqrt(30)
    world.add(ap.Cone(radius=1, height=2), orientation=turn, velocity=(1, 2, 3), angular_velocity=(3, 2, 1))
    world.add(ap.Box(size=(1, 2, 3)), position=(9, 9, 9), mass=2, angular_velocity=(0, 3, 1), name="box")
    session, total = Session(world), 0.0
    for identity in world.bodies.id.tolist():
        session.body_wanted = identity
        told, energy = session.frame().kinetic
        assert told == identity
        total += energy
    assert total == pytest.approx(world.energy().kinetic, rel=1e-6)
    session.remove(identity)
    assert session.frame().kinetic is None
