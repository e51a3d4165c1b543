"""The same input gives the same bits: again, by another broad phase, on another CPU, and in plain Python."""

import os
import subprocess
import sys

import numpy as np
import pytest

import atlasphys as ap
from tests.world.scenes import heap, stack, steps

PRECISIONS = ["single", "double"]


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_reruns_and_broad_phases_are_equal(precision, seed):
    worlds = [heap(seed, precision=precision, broadphase=name) for name in ("sweep", "tree", "brute")]
    for i in range(12):
        assert len({steps(world, 10) for world in worlds}) == 1
        for world in worlds:
            if i == 3:
                world.remove(world.bodies[4])
                world.remove(world.bodies[8])
            if i == 6:
                for k in range(20):
                    world.add(ap.Box(size=(0.5, 0.5, 0.5)), position=(0.1 * k, 5 + 0.3 * k, 0))
        if i == 9:  # changing over in mid-run makes no difference either
            for world, name in zip(worlds, ("brute", "sweep", "tree"), strict=True):
                world.broadphase = name


def test_what_a_world_did_before_leaves_no_trace_in_another():
    alone = steps(heap(4), 30)
    other, world = heap(5), heap(4)
    for _ in range(30):
        other.step(1 / 60)
        world.step(1 / 60)
    assert world.state_hash() == alone


def test_reading_changes_nothing():
    quiet, read = heap(6), heap(6)
    for _ in range(20):
        quiet.step(1 / 60)
        read.step(1 / 60)
        repr(read)
        read.contacts, read.events, read.profile, read.energy(), read.momentum(), read.angular_momentum()
        read.snapshot()
        for body in read.bodies:
            repr((body, body.center_of_mass, body.inertia))
        np.asarray(read.bodies.position)
    assert quiet.state_hash() == read.state_hash()


CODE = """
import numpy as np
np.seterr(all="ignore")
import atlasphys as ap
from tests.world.scenes import {build}
for settings in {settings}:
    world = {call}
    for _ in range({count}):
        world.step(1 / 60)
    print(world.state_hash())
"""


def in_a_subprocess(environment, **code):
    answer = subprocess.run(
        [sys.executable, "-c", CODE.format(**code)],
        env=os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)} | environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return answer.stdout.split()


@pytest.mark.full
def test_a_plain_cpu_gives_the_same_bits(tmp_path):
    """Compiled anew without the vector and fused instructions of this machine."""
    if os.uname().machine != "x86_64":
        pytest.skip("the generic target is that of x86-64")
    code = {"build": "heap", "settings": [{}], "call": "heap(7, **settings)", "count": 60}
    generic = in_a_subprocess(
        {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": "", "ATLASPHYS_CACHE_DIR": str(tmp_path)}, **code
    )
    assert generic == [steps(heap(7), 60)]


def test_plain_python_gives_the_same_bits():
    """The kernels' source means the same when it is not compiled."""
    code = {
        "build": "stack",
        "settings": [{"precision": name} for name in PRECISIONS],
        "call": "stack(2, **settings)",
        "count": 4,
    }
    plain = in_a_subprocess({"NUMBA_DISABLE_JIT": "1"}, **code)
    assert plain == [steps(stack(2, **settings), 4) for settings in code["settings"]]
