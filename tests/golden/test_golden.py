"""State hashes that must not change unless the physics is meant to.

After such a change write them anew, and say in the commit why: ``python -m tests.golden.test_golden``
"""

import json
import os
import subprocess
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import atlasphys as ap
from atlasphys.validate.cases.conservation import implosion
from tests.world.scenes import SHAPES, heap, stack, steps

HASHES = Path(__file__).with_name("hashes.json")

BALLS = (ap.Sphere(radius=0.5), ap.Sphere(radius=0.3))

classic_stack, classic_heap = partial(stack, preset="classic"), partial(heap, preset="classic")

STAGED = {
    "tower of 5, single": lambda: classic_stack(5),
    "tower of 5, double": lambda: classic_stack(5, precision="double"),
    "tower of 5, Baumgarte, cold": lambda: classic_stack(
        5, solver=ap.SequentialImpulse(position_correction="baumgarte", warm_starting=False)
    ),
    "heap of balls": lambda: classic_heap(11, shapes=BALLS),
    "heap of everything": lambda: classic_heap(12),
    "heap of everything, brute": lambda: classic_heap(12, broadphase="brute"),
    "avbd: tower of 5": lambda: stack(5, preset="avbd"),
    "avbd: heap of everything, double": lambda: heap(12, preset="avbd", precision="double"),
    "avbd: implosion": lambda: implosion(partial(ap.World, preset="avbd"), 0.5, 0.5, 28),
    "xpbd: tower of 5, single": lambda: stack(5, preset="xpbd"),
    "xpbd: tower of 5, double": lambda: stack(5, preset="xpbd", precision="double"),
    "xpbd: heap of everything": lambda: settled_heap(5, 27, SHAPES, preset="xpbd"),
    "xpbd: heap of everything, rolling and locked": lambda: heap(13, spread=4.0, preset="xpbd"),
}
AT = (1, 10, 100)


def settled_heap(seed, count, shapes, **settings):
    """Bodies dropped on a plane in layers, without overlap."""
    rng = np.random.default_rng(seed)
    world = ap.World(**settings)
    world.add(ap.Plane(normal=(0, 1, 0)))
    for i in range(count):
        layer, place = divmod(i, 9)
        world.add(
            shapes[i % len(shapes)],
            position=np.round(
                (1.3 * (place % 3) - 1.3, 0.8 + 1.4 * layer, 1.3 * (place // 3) - 1.3) + rng.uniform(-0.1, 0.1, 3), 3
            ),
            orientation=np.round(rng.uniform(-1, 1, 4), 3),
            restitution=0.3 if i % 4 == 0 else 0.0,
            rolling_friction=0.01 if i % 5 == 0 else 0.0,
        )
    return world


def sleepers(**settings):
    """A small pyramid of boxes that falls asleep before a ball from far above hits it."""
    world = ap.World(**settings)
    world.add(ap.Plane(normal=(0, 1, 0)))
    for level in range(3):
        for i in range(3 - level):
            world.add(ap.Box(size=(1, 1, 1)), position=(1.05 * i + 0.525 * level, 0.5 + level, 0))
    world.add(ap.Sphere(radius=0.4), position=(1.2, 30, 0.1), density=3000)
    return world


DEFAULT = {
    "default: tower of 10": partial(stack, 10),
    "default: heap of boxes and balls": partial(settled_heap, 3, 36, (ap.Box(size=(1, 0.7, 0.8)), *BALLS)),
    "default: heap of everything": partial(settled_heap, 4, 36, SHAPES),
    "default: implosion, double": lambda **settings: implosion(
        partial(ap.World, precision="double", **settings), 0.5, 0.5, 28
    ),
    "default: sleepers and a ball": sleepers,
}
DEFAULT_AT = (1, 20, 220)
BEFORE_IMPACT = 130
"""Steps after which the pyramid of ``sleepers`` sleeps and the ball has not come yet."""


def hashes(name):
    world, at = (STAGED[name](), AT) if name in STAGED else (DEFAULT[name](), DEFAULT_AT)
    return [steps(world, now - before) for before, now in zip((0, *at), at, strict=False)]


def golden(name):
    return json.loads(HASHES.read_text(encoding="utf-8"))[name]


@pytest.mark.parametrize("name", [*STAGED, *DEFAULT])
def test_golden_hashes(name):
    assert hashes(name) == golden(name)


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("name", DEFAULT)
def test_steps_in_one_call_give_the_same(name, threads):
    world = DEFAULT[name](threads=threads)
    world.run(seconds=DEFAULT_AT[-1] / 60, dt=1 / 60)
    assert world.state_hash() == golden(name)[-1]


def test_the_sleepers_sleep_and_are_woken():
    world = sleepers()
    asleep = []
    for count in (BEFORE_IMPACT, DEFAULT_AT[-1] - BEFORE_IMPACT):
        steps(world, count)
        asleep.append([body.asleep for body in world.bodies if body.shape == ap.Box(size=(1, 1, 1))])
    assert all(asleep[0])
    assert not any(asleep[1])


def test_a_plain_cpu_gives_the_same_bits(tmp_path):
    """Compiled anew without the wide vectors and fused instructions of this machine."""
    if os.uname().machine != "x86_64":
        pytest.skip("the generic target is that of x86-64")
    code = "from tests.golden.test_golden import *; print(json.dumps({name: hashes(name) for name in DEFAULT}))"
    plain = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": "", "ATLASPHYS_CACHE_DIR": str(tmp_path)}
    answer = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)} | plain,
        capture_output=True,
        text=True,
        check=True,
    )
    assert json.loads(answer.stdout) == {name: golden(name) for name in DEFAULT}


if __name__ == "__main__":
    written = json.dumps({name: hashes(name) for name in (*STAGED, *DEFAULT)}, indent=1)
    HASHES.write_text(written + "\n", encoding="utf-8")
