"""Traces that must not change unless the algorithms are meant to.

After such a change write them anew, and say in the commit why: ``python -m tests.explainer.test_golden_traces``
"""

import json
from pathlib import Path

import pytest

from tests.explainer.pairs import story_of

TRACES = Path(__file__).with_name("traces.json")
PAIRS = ("separate", "touching", "turned", "deep")


def traced(kind):
    """All events of a step of a pair; without the lines of the source."""
    return without_lines(json.loads(json.dumps(story_of(kind, preset="classic", precision="double").data())))


def without_lines(data):
    if isinstance(data, dict):
        return {key: without_lines(value) for key, value in data.items() if not key.startswith("source")}
    return [without_lines(entry) for entry in data] if isinstance(data, list) else data


def assert_same(now, then, path=""):
    if isinstance(then, dict):
        assert now.keys() == then.keys(), path
        for key, value in then.items():
            assert_same(now[key], value, f"{path}.{key}")
    elif isinstance(then, list):
        assert len(now) == len(then), path
        for i, value in enumerate(then):
            assert_same(now[i], value, f"{path}[{i}]")
    elif isinstance(then, float):
        assert now == pytest.approx(then, rel=1e-9, abs=1e-12), path
    else:
        assert now == then, path


@pytest.mark.parametrize("kind", PAIRS)
def test_traces_are_as_they_were(kind):
    assert_same(traced(kind), json.loads(TRACES.read_text(encoding="utf-8"))[kind])


if __name__ == "__main__":
    TRACES.write_text(json.dumps({kind: traced(kind) for kind in PAIRS}, indent=0) + "\n", encoding="utf-8")
