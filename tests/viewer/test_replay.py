"""Replay of recordings, and contacts in them."""

import h5py
import numpy as np
import pytest

import atlasphys as ap
from atlasphys.viewer.replay import Replay

DT = 1 / 60


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A falling tower with contacts, what its contacts were at each step, and where it was."""
    path = tmp_path_factory.mktemp("replay") / "tower.h5"
    scene = ap.load_scene("tower", height=3)
    world = scene.build()
    world.bodies["cube 2"].velocity = (1.5, 0, 0)
    contacts, velocities = [], []
    with ap.Recorder(path, world, scene, contacts=True) as recorder:
        for step in range(130):
            if step == 60:
                world.remove(world.bodies["cube 0"])
            if step == 70:
                world.add(ap.Sphere(radius=0.4), position=(6, 0.41, 0), name="late")
            world.step(DT)
            recorder.record()
            contacts.append((world.bodies.names, np.array(world.contacts)))
            velocities.append(dict(zip(world.bodies.names, world.bodies.velocity.copy(), strict=True)))
    return path, contacts, velocities


def test_recorded_contacts_are_those_of_the_world(recorded):
    path, expected, _ = recorded
    with ap.Recording(path) as recording:
        assert recording.has_contacts
        for step, (names, contacts) in enumerate(expected):
            read = recording.contacts(step)
            assert len(read) == len(contacts)
            for side in ("body_a", "body_b"):
                found = [recording.names[row] for row in read[side]]
                assert found == [names[row] for row in contacts[side]]
            for field in ("point", "normal", "depth", "normal_impulse", "friction_impulse"):
                np.testing.assert_allclose(read[field], contacts[field], rtol=1e-6, atol=1e-6)
        with pytest.raises(IndexError, match="130 steps"):
            recording.contacts(130)


def test_contacts_survive_a_writer_that_is_killed(tmp_path):
    """The file as it is after a commit in the middle of a chunk and more steps that did not reach it."""
    world = ap.load_scene("tower", height=2).build()
    recorder = ap.Recorder(tmp_path / "a.h5", world, contacts=True)
    for _ in range(73):
        world.step(DT)
        recorder.record()
    (tmp_path / "b.h5").write_bytes((tmp_path / "a.h5").read_bytes())
    recorder.close()
    with ap.Recording(tmp_path / "b.h5") as cut, ap.Recording(tmp_path / "a.h5") as whole:
        assert (len(cut), len(whole)) == (50, 73)
        np.testing.assert_array_equal(cut.contacts(49), whole.contacts(49))
        assert len(whole.contacts(72)) == 8


def test_a_recording_without_contacts_has_none(tmp_path):
    world = ap.load_scene("tower", height=2).build()
    with ap.Recorder(tmp_path / "a.h5", world) as recorder:
        world.step(DT)
        recorder.record()
    with ap.Recording(tmp_path / "a.h5") as recording:
        assert not recording.has_contacts
        assert len(recording.contacts(0)) == 0
    with h5py.File(tmp_path / "a.h5") as file:
        assert "contacts" not in file


def test_read_poses_agrees_with_poses(recorded):
    with ap.Recording(recorded[0]) as recording:
        window = recording.read_poses(40, 75)
        for k in range(35):
            np.testing.assert_array_equal(window[k, :, 0:3], recording.poses(40 + k).positions)
        with pytest.raises(IndexError, match="130 steps"):
            recording.read_poses(100, 131)


def test_replay_shows_what_was_recorded(recorded):
    path, contacts, velocities = recorded
    replay = Replay(path)
    replay.contacts_wanted = True
    for step in (0, 1, 49, 50, 59, 60, 75, 129):
        replay.seek(step)
        frame = replay.frame()
        with ap.Recording(path) as recording:
            np.testing.assert_array_equal(frame.position, recording.poses(step).positions)
        assert frame.steps == step
        assert len(frame.contacts) == len(contacts[step][1])
        if step > 1:
            for row, entry in enumerate(frame.table.entries):
                if entry.name in velocities[step] and entry.name in velocities[step - 1]:
                    np.testing.assert_allclose(frame.velocity[row], velocities[step][entry.name], atol=0.12)
        gone = [entry.name for entry, p in zip(frame.table.entries, frame.position, strict=True) if np.isnan(p[0])]
        assert gone == (["late"] if step < 60 else ["cube 0", "late"] if step < 70 else ["cube 0"])
    replay.close()


def test_playing_follows_the_clock_loops_and_pauses(recorded):
    replay = Replay(recorded[0])
    replay.advance(1.0)
    assert replay.now == 0
    replay.start()
    replay.advance(0.5)
    assert replay.now == pytest.approx(30, abs=1)
    replay.set_speed(2.0)
    replay.advance(0.5)
    assert replay.now == pytest.approx(90, abs=1)
    replay.advance(0.5)
    assert replay.now < 30  # from the beginning again
    replay.loop = False
    replay.advance(100.0)
    assert (replay.now, replay.running) == (129, False)
    replay.start()
    assert replay.now == 0
    replay.step(-5)
    assert (replay.now, replay.running) == (0, False)
    replay.seek(10**9)
    assert replay.now == 129
    replay.seek_time(1.0)
    assert replay.frame().time == pytest.approx(1.0)
    with pytest.raises(ap.InvalidArgumentError, match="speed"):
        replay.set_speed(0)
    replay.close()


def test_bad_recordings_are_refused(tmp_path):
    (tmp_path / "text.h5").write_text("no recording")
    with pytest.raises(ap.RecordingError, match="not an HDF5 file"):
        Replay(tmp_path / "text.h5")
    with pytest.raises(ap.RecordingError, match="cannot be read"):
        Replay(tmp_path / "missing.h5")
    with ap.Recorder(tmp_path / "empty.h5", ap.World()):
        pass
    with pytest.raises(ap.RecordingError, match="no step"):
        Replay(tmp_path / "empty.h5")
