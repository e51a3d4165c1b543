"""Code in the documentation runs: doctests by themselves (``--doctest-glob``), here what is not written as one, and the quick start's commands."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
ELSEWHERE = {"simd.md"}
"""Pages whose programs are parts of a module, shown from it."""


def programs():
    for page in PAGES:
        for number, block in enumerate(
            re.findall(r"^```python\n(.*?)^```", page.read_text("utf-8"), re.DOTALL | re.MULTILINE)
        ):
            if ">>>" not in block and page.name not in ELSEWHERE:
                yield pytest.param(block, id=f"{page.stem}-{number}")


@pytest.mark.parametrize("program", list(programs()))
def test_programs_run(program, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(program, "block", "exec"), {"__name__": "block"})


def commands():
    """The quick start's commands, but for those that install, warm up for minutes or open a page."""
    lines = (ROOT / "docs" / "tutorial.md").read_text("utf-8").splitlines()
    return [line for line in lines if line.startswith("atlasphys ") and line.split()[1] not in ("warmup", "view")]


def test_commands_of_the_quick_start_run(tmp_path):
    assert len(commands()) >= 3
    environment = os.environ | {"PYTHONPATH": f"{ROOT / 'src'}"}
    for command in commands():
        arguments = [sys.executable, "-m", "atlasphys", *shlex.split(command)[1:]]
        done = subprocess.run(
            arguments, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300, check=False
        )
        assert done.returncode == 0, f"{command}: {done.stderr}"
    assert (tmp_path / "tower.h5").stat().st_size > 0
