"""Following a scene, and drawing what was seen."""

import pytest

import atlasphys as ap
from atlasphys.validate.compare import COLUMNS, SAMPLES, Track, follow, plot
from atlasphys.validate.contenders import solvers


def track(name, steps, scene="tower", **parameters):
    contender = solvers(name)[0]
    found = Track(contender, 1 / 60)
    said = []
    world = ap.load_scene(scene, **parameters).build(sleeping=False, **contender.settings)
    follow(world, found, steps, said.append)
    assert len(said) == found.steps
    return found, world


def test_a_track_holds_what_the_world_says():
    found, world = track("classic", 60, height=3)
    row = found.row()
    assert (row["contender"], row["steps"], row["bodies"], row["contacts"]) == ("classic", 60, 4, 12)
    assert row["seconds"] == pytest.approx(1.0)
    assert row["step_milliseconds"] > 0
    assert row["last_kinetic"] == world.energy().kinetic
    assert row["last_complementarity"] == world.residuals().complementarity.max()
    assert row["worst_drift"] >= row["last_drift"] >= 0
    assert row["sweeps"] == len(found.sweeps) == 11
    assert found.sweeps[-1] == row["last_sweep"] <= row["first_sweep"]
    assert world.steps == 60
    assert not world.trace_solver
    assert all(len(found.columns[name]) == len(found.times) == 60 for name in COLUMNS)


def test_long_runs_are_sampled():
    found, _ = track("default", 2 * SAMPLES + 1, scene="two_boxes")
    assert SAMPLES // 2 < len(found.times) <= SAMPLES
    assert found.times[-1] == pytest.approx((2 * SAMPLES + 1) / 60)


def test_divergence_ends_a_track():
    found, world = Track(solvers("default")[0], 1 / 60), ap.World()
    world.add(ap.Sphere(radius=0.5), position=(0, 1e9, 0), velocity=(0, 1e9, 0), name="fast")
    step = world.step

    def diverges(dt):
        if found.steps == 3:
            raise ap.DivergenceError("fast is not finite", ("fast",))
        step(dt)

    object.__setattr__(world, "step", diverges)
    follow(world, found, 10, lambda text: None)
    assert (found.error, found.steps) == ("fast is not finite", 3)
    assert found.row()["error"] == "fast is not finite"


def test_picture(tmp_path):
    pytest.importorskip("matplotlib")
    tracks = [track(name, 20, height=3)[0] for name in ("default", "classic:iterations=2")]
    assert plot(tmp_path / "c.png", tracks, "tower").read_bytes().startswith(b"\x89PNG")
