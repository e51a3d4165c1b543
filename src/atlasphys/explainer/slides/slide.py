"""A slide: one thing that happened, in words, with its figure and the line of the engine that did it."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from functools import cache
from html import escape
from pathlib import Path

from atlasphys.explainer.slides.figure import Marks

PACKAGE = Path(__file__).parents[2]
"""The folder of the package, from which sources are named."""

AROUND = 3
"""Lines of source shown before and after the one that is meant."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Chart:
    """Curves that run along: what is known at this slide."""

    title: str
    across: tuple[float, ...]
    curves: dict[str, tuple[float, ...]]


@dataclass(frozen=True, kw_only=True, eq=False)
class Slide:
    """One thing that happened."""

    title: str
    text: str
    """HTML with MathML."""
    source: str = ""
    """Where the engine noted it, ``"engine/narrowphase/gjk.py:228"``: just after the line that did it."""
    needle: str = ""
    """What stands in the line that did it, if that is not the last one before."""
    shapes: Marks = ()
    """What is drawn with the two shapes, beside themselves. Points are along the world's axes, from A's origin."""
    beside: Marks = ()
    """What is drawn beside them."""
    caption: str = ""
    """What that is."""
    faces_viewer: bool = False
    """Whether that lies in the x-y plane and is to be seen straight on."""
    opacity: float = 0.55
    """Of the two shapes."""
    charts: tuple[Chart, ...] = ()


def paragraph(*parts: str) -> str:
    """A paragraph of HTML."""
    return f'<p style="margin:0.4em 0">{" ".join(parts)}</p>'


def coloured(text: str, colour: tuple[int, int, int]) -> str:
    """Words in the colour of what they name."""
    return f'<b style="color:rgb{colour}">{escape(text)}</b>'


def line_that_did_it(source: str, needle: str = "") -> tuple[str, int]:
    """File and line of what was noted at a place: the last line before the note, or the last in which something stands."""
    file, _, number = source.partition(":")
    noted = notes(file)
    lines = source_lines(file)
    here = int(number)
    while here > 1 and (here in noted or not lines[here - 1].strip() or needle not in lines[here - 1]):
        here -= 1
    return file, here


def excerpt(source: str, needle: str = "") -> str:
    """The lines of the engine about what was noted at a place, without the notes, the line that did it marked, as HTML."""
    file, here = line_that_did_it(source, needle)
    lines, noted = source_lines(file), notes(file)
    code = [k for k in range(1, len(lines) + 1) if k not in noted]
    middle = code.index(here)
    shown = code[max(0, middle - AROUND) : middle + AROUND + 1]
    indent = min((len(lines[k - 1]) - len(lines[k - 1].lstrip()) for k in shown if lines[k - 1].strip()), default=0)
    rows = []
    for k in shown:
        mark = "background:#ffe9a8;" if k == here else ""
        rows.append(
            f'<div style="{mark}white-space:pre"><span style="color:#98a0aa">{k:4d}</span>  {escape(lines[k - 1][indent:])}</div>'
        )
    return (
        f'<div style="font-size:0.85em;color:#69727d;margin-top:0.6em">src/atlasphys/{escape(file)}, line {here}</div>'
        '<div style="font-family:monospace;font-size:0.78em;line-height:1.4;overflow-x:auto;border:1px solid #d8dde3;'
        f'border-radius:4px;padding:0.3em;background:#fafbfc;color:#22262b">{"".join(rows)}</div>'
    )


@cache
def notes(file: str) -> frozenset[int]:
    """The lines of a file that only take notes."""
    lines = source_lines(file)
    found: set[int] = set()
    for node in ast.walk(ast.parse("\n".join(lines))):
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TRACED":
            found |= set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return frozenset(found)


@cache
def source_lines(file: str) -> list[str]:
    """The lines of a file of the package."""
    return (PACKAGE / file).read_text(encoding="utf-8").splitlines()
