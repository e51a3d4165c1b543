"""Recordings: what is read is what was recorded, whatever happened to the writer; what is no recording is refused."""

import io
import os
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

import atlasphys as ap
from atlasphys.record import write
from atlasphys.record.journal import JournaledFile
from tests.record.test_journal import LoggedFile, images_of
from tests.record.worlds import expected_position, put, small_world


def record(path, steps, world=None):
    world = world or small_world()
    with ap.Recorder(path, world) as recorder:
        for step in range(steps):
            put(world, step)
            recorder.record()
    return world


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("recordings") / "balls.h5"
    record(path, 123)
    return path


def test_every_step_is_read_back_exactly(recorded):
    world = small_world()
    with ap.Recording(recorded) as recording:
        assert len(recording) == 123
        for step in range(123):
            put(world, step)
            positions, orientations = recording.poses(step)
            assert np.array_equal(positions, world.bodies.position)
            assert np.array_equal(orientations, world.bodies.orientation)
        assert np.array_equal(recording.times, np.arange(123) / 60)
        assert np.array_equal(recording.poses(-1).positions, recording.poses(122).positions)
        assert np.array_equal(recording.poses(-123).positions, recording.poses(0).positions)


def test_a_body_is_read_over_all_steps(recorded):
    with ap.Recording(recorded) as recording:
        times, positions, orientations = recording.body("ball 1")
        assert np.array_equal(times, recording.times)
        assert np.array_equal(positions, [expected_position(step, 1) for step in range(123)])
        assert orientations.shape == (123, 4)
        assert np.array_equal(recording.body(1).positions, positions)
        with pytest.raises(KeyError, match="did you mean 'ball 1'"):
            recording.body("bal 1")
        with pytest.raises(IndexError):
            recording.body(3)


@pytest.mark.parametrize("step", [123, -124, 10**30])
def test_a_step_out_of_range_is_refused_with_the_count(recorded, step):
    with ap.Recording(recorded) as recording, pytest.raises(IndexError, match="123 steps"):
        recording.poses(step)


@pytest.mark.parametrize("step", [1.0, "1", None, True, slice(2)])
def test_a_step_that_is_no_integer_is_refused(recorded, step):
    with ap.Recording(recorded) as recording, pytest.raises(TypeError, match="integer"):
        recording.poses(step)


def test_one_step_is_read_without_the_rest(tmp_path):
    """A recording of 40 chunks, all but the wanted one spoilt: the wanted step reads, the others are refused."""
    path = tmp_path / "long.h5"
    record(path, 2000)
    with h5py.File(path) as file:
        poses = file["poses"].id
        chunks = [poses.get_chunk_info(index) for index in range(poses.get_num_chunks())]
    data = bytearray(path.read_bytes())
    for chunk in chunks:
        if chunk.chunk_offset[0] != 1000:
            data[chunk.byte_offset : chunk.byte_offset + chunk.size] = bytes(chunk.size)
    path.write_bytes(data)
    with ap.Recording(path) as recording:
        assert recording.poses(1049).positions[2].tolist() == list(expected_position(1049, 2))
        with pytest.raises(ap.RecordingError, match="is damaged"):
            recording.poses(1050)


def test_the_scene_is_inside(tmp_path):
    scene = ap.load_scene("tower", height=2)
    world = scene.build()
    with ap.Recorder(tmp_path / "a.h5", world, scene) as recorder:
        recorder.record()
    with ap.Recording(tmp_path / "a.h5") as recording:
        assert recording.scene == scene
        assert recording.names == ["ground", "cube 0", "cube 1"]
        rebuilt = recording.scene.build()
        assert np.array_equal(recording.poses(0).positions, rebuilt.bodies.position)


def test_bodies_come_and_go(tmp_path):
    world = small_world(2)
    with ap.Recorder(tmp_path / "a.h5", world) as recorder:
        for step in range(180):
            if step == 60:
                world.remove(world.bodies["ball 0"])
            if step == 70:
                for extra in range(100):
                    world.add(ap.Box(size=(1, 1, 1)), name=f"box {extra}")
            put(world, step)
            recorder.record()
    with ap.Recording(tmp_path / "a.h5") as recording:
        assert len(recording.names) == 102
        assert recording.bodies[-1]["shape"] == {"type": "box", "size": [1.0, 1.0, 1.0]}
        gone, stayed, came = (recording.body(name).positions for name in ("ball 0", "ball 1", "box 7"))
        assert np.isnan(gone[60:]).all()
        assert np.array_equal(gone[59], expected_position(59, 0))
        assert np.array_equal(stayed[59], expected_position(59, 1))
        assert np.array_equal(stayed[60], expected_position(60, 0))
        assert np.isnan(came[:70]).all()
        assert np.array_equal(came[179], expected_position(179, 8))
        assert np.isnan(recording.poses(65).positions[0]).all()


def test_a_world_without_bodies_is_recorded(tmp_path):
    with ap.Recorder(tmp_path / "a.h5", ap.World()) as recorder:
        recorder.record()
    with ap.Recording(tmp_path / "a.h5") as recording:
        assert len(recording) == 1
        assert recording.poses(0).positions.shape == (0, 3)


def test_it_can_be_read_while_it_is_written(tmp_path):
    world = small_world()
    with ap.Recorder(tmp_path / "a.h5", world) as recorder:
        for step in range(120):
            put(world, step)
            recorder.record()
            with ap.Recording(tmp_path / "a.h5") as recording:
                assert len(recording) == (step + 1) // 50 * 50


def test_steps_reach_the_file_after_a_while_even_if_few(tmp_path, monkeypatch):
    monkeypatch.setattr(write, "LONGEST_WAIT", 0.0)
    world = small_world()
    with ap.Recorder(tmp_path / "a.h5", world) as recorder:
        for step in range(70):
            put(world, step)
            recorder.record()
            with ap.Recording(tmp_path / "a.h5") as recording:
                assert len(recording) == step + 1
                assert np.array_equal(recording.poses(step).positions, world.bodies.position)


def test_death_between_any_two_writes_leaves_a_readable_recording(tmp_path, monkeypatch):
    """Every state through which the file passes, half-done writes included, is a recording of whole steps."""
    log = LoggedFile()

    def logged(file):
        log.write(file.read())
        file.close()
        return JournaledFile(log)

    monkeypatch.setattr(write, "JournaledFile", logged)
    world = small_world(1)
    stored = []
    recorder = ap.Recorder(tmp_path / "a.h5", world)
    for step in range(3500):  # enough to make HDF5 split a node of its index: 64 chunks
        put(world, step)
        recorder.record()
        if step % 50 == 49:
            stored.append(len(log.changes))
    recorder._commit()
    assert recorder._stored == 3500

    path = tmp_path / "b.h5"
    seen = set()
    images = list(images_of(log.changes))
    for number, image in enumerate(images[3:]):  # the first three are of the empty recording being put in place
        if number % 4 and number < len(images) - 200:  # a quarter of all, and all of the last ones
            continue
        path.write_bytes(image)
        with ap.Recording(path) as recording:
            count = len(recording)
            assert count % 50 == 0
            seen.add(count)
            for step in {0, count // 2, count - 1} if count else ():
                assert recording.poses(step).positions[0].tolist() == list(expected_position(step, 0))
    assert {3400, 3450, 3500} <= seen


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_kill_9_at_100_random_moments_leaves_a_readable_recording(tmp_path):
    script = Path(__file__).with_name("kill_writers.py")
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(script.parents[2]), *sys.path])}
    result = subprocess.run(
        [sys.executable, str(script), str(tmp_path), "100"],
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert result.returncode == 0, result.stderr
    intact, steps = map(int, result.stdout.split())
    assert intact == 100
    assert steps > 1000


def test_a_full_disk_ends_the_recording_and_keeps_what_was_stored(tmp_path, monkeypatch):
    class FullDisk(io.FileIO):
        room = 200_000

        def write(self, data):
            if self.tell() + len(data) > self.room:
                raise OSError(28, "No space left on device")
            return super().write(data)

    monkeypatch.setattr(
        write, "JournaledFile", lambda file: JournaledFile(FullDisk(file.name, "r+b")) if not file.close() else None
    )
    world = small_world()
    recorder = ap.Recorder(tmp_path / "a.h5", world)
    message = r"a\.h5: cannot be written any more: .*No space left.*; the first \d+ steps are kept"
    with pytest.raises(ap.RecordingError, match=message):
        for step in range(5000):
            put(world, step)
            recorder.record()
    kept = recorder._stored
    assert kept >= 50
    with pytest.raises(ap.RecordingError, match="closed"):
        recorder.record()
    recorder.close()
    with ap.Recording(tmp_path / "a.h5") as recording:
        assert len(recording) == kept
        assert recording.poses(-1).positions[0].tolist() == list(expected_position(kept - 1, 0))


def test_an_existing_file_is_replaced_and_no_other_is_left(tmp_path):
    record(tmp_path / "a.h5", 1)
    record(tmp_path / "a.h5", 2)
    with ap.Recording(tmp_path / "a.h5") as recording:
        assert len(recording) == 2
    assert os.listdir(tmp_path) == ["a.h5"]


@pytest.mark.parametrize("path", ["missing/a.h5", ".", "", "a\0b", "/dev/null", "x" * 300])
def test_a_path_that_cannot_be_written_is_refused(tmp_path, monkeypatch, path):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ap.RecordingError, match="cannot be written"):
        ap.Recorder(path, small_world())
    assert os.listdir(tmp_path) == []


def spoil(path, change):
    with h5py.File(path, "r+") as file:
        change(file)


def remove(name):
    return lambda file: file.__delitem__(name)


def set_attribute(name, value):
    return lambda file: file.attrs.__setitem__(name, value)


def shorten(name):
    return lambda file: file[name].resize(3, axis=0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (set_attribute("version", 2), r"is of version 2 \(written by AtlasPhys .*\); this AtlasPhys reads version 1"),
        (set_attribute("format", "other"), "no recording of AtlasPhys"),
        (remove("poses"), "poses is missing"),
        (remove("time"), "time is missing"),
        (remove("bodies"), "bodies is missing"),
        (remove("scene"), "scene is missing"),
        (shorten("time"), "is damaged"),
        (shorten("poses"), "is damaged"),
        (shorten("bodies"), "is damaged|wrong"),
    ],
)
def test_a_file_that_is_not_as_it_should_be_is_refused(tmp_path, change, message):
    path = tmp_path / "a.h5"
    record(path, 60, small_world(5))
    spoil(path, change)
    with pytest.raises(ap.RecordingError, match=message) as error:
        ap.Recording(path)
    assert str(path) in str(error.value)


def test_other_files_are_refused(tmp_path, recorded):
    path = tmp_path / "a.h5"
    for content, message in (
        (b"", "not an HDF5 file"),
        (b"hello" * 100, "not an HDF5 file"),
        (recorded.read_bytes()[:-100], "cut short"),
        (recorded.read_bytes()[:3000], "cut short"),
    ):
        path.write_bytes(content)
        with pytest.raises(ap.RecordingError, match=message):
            ap.Recording(path)
    with h5py.File(path, "w"):
        pass
    with pytest.raises(ap.RecordingError, match="no recording of AtlasPhys"):
        ap.Recording(path)
    for name in ("missing.h5", ".", "a\0b"):
        with pytest.raises(ap.RecordingError, match="cannot be read"):
            ap.Recording(tmp_path / name)


def test_a_damaged_byte_among_the_poses_is_noticed(tmp_path, recorded):
    """The poses carry a checksum. (Damage to HDF5's own index can crash HDF5 itself.)"""
    original = recorded.read_bytes()
    with h5py.File(recorded) as file:
        chunk = file["poses"].id.get_chunk_info(0)
    path = tmp_path / "a.h5"
    for place in np.random.default_rng(1).integers(0, chunk.size, 50):
        data = bytearray(original)
        data[chunk.byte_offset + place] ^= 0x55
        path.write_bytes(data)
        with ap.Recording(path) as recording, pytest.raises(ap.RecordingError, match="is damaged"):
            recording.poses(0)


def test_reading_a_closed_recording_is_refused(recorded):
    recording = ap.Recording(recorded)
    recording.close()
    with pytest.raises(ap.RecordingError, match="is closed"):
        recording.poses(0)


def test_the_file_is_plain_hdf5(recorded):
    with h5py.File(recorded) as file:
        poses = file["poses"]
        assert (poses.shape, poses.chunks, poses.compression, poses.shuffle) == ((123, 3, 7), (50, 64, 7), "gzip", True)


def test_a_recording_replaces_recordings_but_no_other_file(tmp_path):
    world = ap.World()
    scene = tmp_path / "scene.toml"
    scene.write_text("version = 1\n")
    with pytest.raises(ap.RecordingError, match="is no recording; it is not replaced"):
        ap.Recorder(scene, world)
    assert scene.read_text() == "version = 1\n"
    for _ in range(2):
        with ap.Recorder(tmp_path / "a.h5", world):
            pass
    assert len(ap.Recording(tmp_path / "a.h5")) == 0


def swinging_world():
    """Three balls in a row; the first two hang from the world by a ball joint and a rod."""
    world = small_world()
    balls = list(world.bodies)
    world.join(ap.Ball(None, balls[0], anchor=(0, 1, 0)), name="top")
    world.join(ap.Distance(balls[0], balls[1], length=2))
    return world, balls


def test_joints_and_what_they_do_are_recorded(tmp_path):
    path = tmp_path / "a.h5"
    world, balls = swinging_world()
    top, rod = world.joints
    steps = [
        lambda: None,
        lambda: setattr(rod, "enabled", False),
        lambda: world.join(ap.Hinge(balls[1], balls[2], anchor=(0, 0, 0), axis=(0, 0, 1), limits=(-1, 1))),
        lambda: world.remove(top),
        lambda: world.remove(balls[2]),
    ]
    with ap.Recorder(path, world) as recorder:
        for step in steps:
            step()
            for _ in range(60):  # more than are written together
                recorder.record()
    with ap.Recording(path) as recording:
        assert [(joint["type"], joint.get("a"), joint["b"]) for joint in recording.joints] == [
            ("ball", None, 0), ("distance", 0, 1), ("hinge", 1, 2)
        ]  # fmt: skip
        assert (recording.joints[0]["name"], recording.joints[1]["length"]) == ("top", 2)
        states = [recording.joint_states(60 * k + 59).tolist() for k in range(5)]
        assert states == [[2, 2, 0], [2, 1, 0], [2, 1, 2], [0, 1, 2], [0, 1, 0]]
        assert states == [recording.joint_states(60 * k).tolist() for k in range(5)]
        with pytest.raises(IndexError):
            recording.joint_states(300)


def test_recordings_of_earlier_versions_have_no_joints(tmp_path):
    path = tmp_path / "a.h5"
    record(path, 60)
    spoil(path, remove("joints"))
    spoil(path, remove("joint_state"))
    with ap.Recording(path) as recording:
        assert recording.joints == ()
        assert recording.joint_states(3).tolist() == []
        assert recording.poses(3).positions.shape == (3, 3)


def test_damaged_joints_are_refused(tmp_path):
    path = tmp_path / "a.h5"
    world, _ = swinging_world()
    record(path, 3, world)
    spoil(path, lambda file: file["joint_state"].resize(1, axis=1))
    with ap.Recording(path) as recording, pytest.raises(ap.RecordingError, match="states of 1 joints"):
        recording.joint_states(0)

    def other_body(file):
        file["joints"][0] = '{"type": "ball", "b": 7}'

    spoil(path, other_body)
    with ap.Recording(path) as recording, pytest.raises(ap.RecordingError, match="bodies that are not there"):
        recording.joints  # noqa: B018
