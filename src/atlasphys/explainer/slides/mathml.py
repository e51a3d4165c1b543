"""Formulas as MathML, which browsers show by themselves: no script, no fonts, no network.

A formula is written as one reads it, ``formula("w = s_A(d) − s_B(−d) =", vector)``: letters with a subscript after ``_``, numbers, operators, and
values between the words.
"""

from __future__ import annotations

import re
from html import escape
from typing import Any

import numpy as np

from atlasphys.explainer.events import number

TOKEN = re.compile(r"([^\W\d_]+)(?:_(\w+))?|(\d+(?:\.\d+)?)|(\S)")
OPERATORS = {"-": "−", "*": "·"}


class Markup(str):
    """MathML that is written already."""


def formula(*parts: Any) -> str:
    """A formula in a line: words are read as mathematics, numbers and vectors are written with four digits."""
    return f"<math>{''.join(_part(part) for part in parts)}</math>"


def display(*parts: Any) -> str:
    """A formula on a line of its own."""
    return f'<div style="margin:0.45em 0 0.45em 1em;overflow-x:auto">{formula(*parts)}</div>'


def norm(part: Any) -> Markup:
    """|…|"""
    return Markup(f'<mo stretchy="false">|</mo>{_part(part)}<mo stretchy="false">|</mo>')


def fraction(above: Any, below: Any) -> Markup:
    """A fraction."""
    return Markup(f"<mfrac><mrow>{_part(above)}</mrow><mrow>{_part(below)}</mrow></mfrac>")


def _part(part: Any) -> str:
    if isinstance(part, Markup):
        return str(part)
    if isinstance(part, str):
        return "".join(_token(*match.groups()) for match in TOKEN.finditer(part))
    if np.ndim(part) == 0:
        return _number(float(part))
    inside = "<mo>,</mo>".join(_number(round(float(x), 4) + 0.0) for x in part)
    return f'<mrow><mo stretchy="false">(</mo>{inside}<mo stretchy="false">)</mo></mrow>'


def _token(letters: str | None, below: str | None, digits: str | None, operator: str | None) -> str:
    if digits is not None:
        return f"<mn>{digits}</mn>"
    if operator is not None:
        stretchy = ' stretchy="false"' if operator in "()|[]" else ""
        return f"<mo{stretchy}>{escape(OPERATORS.get(operator, operator))}</mo>"
    assert letters is not None
    if below is None:
        return f"<mi>{letters}</mi>"
    index = f"<mn>{below}</mn>" if below.isdecimal() else f"<mi>{below}</mi>"
    return f"<msub><mi>{letters}</mi>{index}</msub>"


def _number(value: float) -> str:
    """A number as in a story; a large or small one with a power of ten."""
    digits, _, power = number(value).partition("e")
    sign, digits = ('<mo form="prefix">−</mo>', digits[1:]) if digits.startswith("-") else ("", digits)
    if not power:
        return f"{sign}<mn>{digits}</mn>"
    exponent = str(int(power)).replace("-", "−")
    return f"{sign}<mn>{digits}</mn><mo>·</mo><msup><mn>10</mn><mn>{exponent}</mn></msup>"
