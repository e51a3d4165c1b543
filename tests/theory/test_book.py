"""The book as a whole: every displayed formula is named and checked, and the documentation builds."""

import importlib
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CHAPTERS = sorted((ROOT / "docs" / "theory").glob("*.md"))


def test_every_formula_is_checked():
    displayed: set[str] = set()
    for chapter in CHAPTERS:
        fences = re.findall(r"^\$\$(.*)$", chapter.read_text(encoding="utf-8"), re.MULTILINE)
        labels = [fence.strip()[1:-1] for fence in fences[1::2]]
        assert len(fences) % 2 == 0, chapter.name
        assert all(label.startswith(chapter.stem + "-") for label in labels), f"{chapter.name}: a formula without label"
        assert not displayed & set(labels)
        displayed |= set(labels)
    checked: set[str] = set()
    for path in sorted(Path(__file__).parent.glob("test_*.py")):
        module = importlib.import_module(f"tests.theory.{path.stem}")
        for member in vars(module).values():
            checked |= set(getattr(member, "formulas", ()))
    assert len(displayed) > 80
    assert displayed == checked


def test_the_documentation_builds_without_a_warning(tmp_path):
    for name in ("sphinx", "furo", "myst_parser", "math_core"):
        pytest.importorskip(name, reason="the documentation needs: pip install 'atlasphys[docs]'")
    command = [sys.executable, "-m", "sphinx", "-W", "-n", "-q", "-d", tmp_path / "trees", "docs", tmp_path / "site"]
    built = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300, check=False)
    assert built.returncode == 0, built.stderr
    page = (tmp_path / "site" / "theory" / "friction.html").read_text(encoding="utf-8")
    assert page.count("<math") > 40
    for site in (tmp_path / "site").rglob("*.html"):
        # Links may leave the site; what a page loads may not.
        loads = re.findall(
            r'<(?:script|img|iframe)[^>]*src="(?:https?:)?//|<link[^>]*stylesheet[^>]*href="https?:',
            site.read_text("utf-8"),
        )
        assert not loads, site
