"""The book as a whole: every displayed formula is named and checked."""

import importlib
import re
from pathlib import Path

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
