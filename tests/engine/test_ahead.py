"""Compiling ahead leaves the kernels of the second half of a step in the cache."""

import os
import subprocess
import sys

import pytest

from atlasphys.engine import ahead


@pytest.mark.full
def test_the_second_half_is_in_the_cache_afterwards(tmp_path):
    environment = os.environ | {"ATLASPHYS_CACHE_DIR": str(tmp_path)}
    subprocess.run([sys.executable, "-m", "atlasphys.engine.ahead", "single"], check=True, env=environment)
    question = "from atlasphys.engine.ahead import *; print(is_compiled(build_manifolds), is_compiled(solve))"
    answer = subprocess.run(
        [sys.executable, "-c", question], check=True, env=environment, capture_output=True, text=True
    )
    assert answer.stdout.split() == ["True", "True"]


def test_nothing_is_started_where_all_is_compiled(monkeypatch):
    ahead.compile_second_half("single")
    monkeypatch.setattr(subprocess, "Popen", lambda *_, **__: pytest.fail("a child was started"))
    ahead.start("single")
