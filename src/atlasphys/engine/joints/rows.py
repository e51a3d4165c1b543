"""Rows of a constraint: Jacobians, their rates, effective masses, impulses. Over lanes, or over plain numbers.

A row is four vectors. With the velocities v and ω of the two bodies, the coordinate C that it belongs to changes at the rate

    Ċ = J v = push_b · v_b + turn_b · ω_b − push_a · v_a − turn_a · ω_a,

and an impulse λ of the row gives b the impulse push_b λ and the angular impulse turn_b λ, and a the opposite of push_a λ and turn_a λ. The effective
mass of two rows i and j is K_ij = J_i M⁻¹ J_jᵀ; Δλ = −K⁻¹ J v stops what moves along them.

Entries of a row that are the Python integers 0 and 1 cost nothing: products with them are left out while a body is traced.
"""

from __future__ import annotations

from typing import Any, NamedTuple

NONE = (0, 0, 0)
"""No push, or no turn."""


class Row(NamedTuple):
    """A row of a Jacobian."""

    push_a: Any
    turn_a: Any
    push_b: Any
    turn_b: Any


def times(x: Any, y: Any) -> Any:
    """x y."""
    for one, other in ((x, y), (y, x)):
        if type(one) is int and one in (0, 1):
            return other if one else 0
    return x * y


def plus(x: Any, y: Any) -> Any:
    """x + y."""
    if type(x) is int and x == 0:
        return y
    return x if type(y) is int and y == 0 else x + y


def minus(x: Any, y: Any) -> Any:
    """x − y."""
    if type(y) is int and y == 0:
        return x
    return -y if type(x) is int and x == 0 else x - y


def dot(u: Any, v: Any) -> Any:
    """u · v."""
    return plus(plus(times(u[0], v[0]), times(u[1], v[1])), times(u[2], v[2]))


def cross(u: Any, v: Any) -> Any:
    """u × v."""
    return (
        minus(times(u[1], v[2]), times(u[2], v[1])),
        minus(times(u[2], v[0]), times(u[0], v[2])),
        minus(times(u[0], v[1]), times(u[1], v[0])),
    )


def sym_mul(s: Any, v: Any) -> Any:
    """S v for a symmetric S: xx yy zz xy xz yz."""
    return dot((s[0], s[3], s[4]), v), dot((s[3], s[1], s[5]), v), dot((s[4], s[5], s[2]), v)


def weighted(m: Any, u: Any) -> Any:
    """diag(m) u."""
    return times(m[0], u[0]), times(m[1], u[1]), times(m[2], u[2])


def rate(row: Row, v_a: Any, w_a: Any, v_b: Any, w_b: Any) -> Any:
    """J v."""
    gained = plus(dot(row.push_b, v_b), dot(row.turn_b, w_b))
    return minus(gained, plus(dot(row.push_a, v_a), dot(row.turn_a, w_a)))


def masses(rows: list[Row], m_a: Any, inertia_a: Any, m_b: Any, inertia_b: Any) -> list[list[Any]]:
    """K = J M⁻¹ Jᵀ of one to three rows: its upper triangle, ``K[i][j − i]``. ``m_a``, ``m_b`` are inverse masses along the world's axes, the
    inertias inverse ones, symmetric."""
    moved = [effects(row, m_a, inertia_a, m_b, inertia_b) for row in rows]
    return [[product(row, other) for other in moved[i:]] for i, row in enumerate(rows)]


def effects(row: Row, m_a: Any, inertia_a: Any, m_b: Any, inertia_b: Any) -> Row:
    """M⁻¹ Jᵀ."""
    return Row(
        weighted(m_a, row.push_a),
        sym_mul(inertia_a, row.turn_a),
        weighted(m_b, row.push_b),
        sym_mul(inertia_b, row.turn_b),
    )


def product(row: Row, effect: Row) -> Any:
    """J M⁻¹ Jᵀ of a row and the effects of another."""
    a = plus(dot(row.push_a, effect.push_a), dot(row.turn_a, effect.turn_a))
    return plus(a, plus(dot(row.push_b, effect.push_b), dot(row.turn_b, effect.turn_b)))


def combined(rows: list[Row], impulses: list[Any]) -> Row:
    """Σ λ_i row_i: the impulses on the two bodies."""
    total = Row(*(tuple(times(x, impulses[0]) for x in side) for side in rows[0]))
    for row, impulse in zip(rows[1:], impulses[1:], strict=True):
        total = Row(
            *(
                tuple(plus(x, times(y, impulse)) for x, y in zip(before, side, strict=True))
                for before, side in zip(total, row, strict=True)
            )
        )
    return total


def pushed(
    push: Row, v_a: Any, w_a: Any, v_b: Any, w_b: Any, m_a: Any, inertia_a: Any, m_b: Any, inertia_b: Any
) -> Any:
    """Velocities after the impulses ``push``: v_a, ω_a, v_b, ω_b."""
    return (
        tuple(map(minus, v_a, weighted(m_a, push.push_a))),
        tuple(map(minus, w_a, sym_mul(inertia_a, push.turn_a))),
        tuple(map(plus, v_b, weighted(m_b, push.push_b))),
        tuple(map(plus, w_b, sym_mul(inertia_b, push.turn_b))),
    )
