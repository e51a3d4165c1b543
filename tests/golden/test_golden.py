"""State hashes that must not change unless the physics is meant to.

After such a change write them anew, and say in the commit why: ``python -m tests.golden.test_golden``
"""

import json
from pathlib import Path

import pytest

import atlasphys as ap
from tests.world.scenes import heap, stack, steps

HASHES = Path(__file__).with_name("hashes.json")

BALLS = (ap.Sphere(radius=0.5), ap.Sphere(radius=0.3))

SCENES = {
    "tower of 5, single": lambda: stack(5),
    "tower of 5, double": lambda: stack(5, precision="double"),
    "tower of 5, Baumgarte, cold": lambda: stack(
        5, solver=ap.SequentialImpulse(position_correction="baumgarte", warm_starting=False)
    ),
    "heap of balls": lambda: heap(11, shapes=BALLS),
    "heap of everything": lambda: heap(12),
    "heap of everything, brute": lambda: heap(12, broadphase="brute"),
}
AT = (1, 10, 100)


def hashes(name):
    world = SCENES[name]()
    result = []
    for before, now in zip((0, *AT), AT, strict=False):
        result.append(steps(world, now - before))
    return result


@pytest.mark.parametrize("name", SCENES)
def test_golden_hashes(name):
    assert hashes(name) == json.loads(HASHES.read_text(encoding="utf-8"))[name]


if __name__ == "__main__":
    written = json.dumps({name: hashes(name) for name in SCENES}, indent=1)
    HASHES.write_text(written + "\n", encoding="utf-8")
