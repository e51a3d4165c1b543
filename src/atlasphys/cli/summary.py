"""The table at the end of a run."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.table import Table

from atlasphys.cli.simulation import AT_REST, FELL, IN_PLACE


def print_summary(summary: dict[str, Any]) -> None:
    """Print the summary of a run, as ``summarize`` gives it, as a table."""
    table = Table(box=None, show_header=False, pad_edge=False)
    table.add_column(style="bold", no_wrap=True)
    table.add_column(overflow="fold")
    for name, text in _rows(summary):
        table.add_row(name, text)
    Console(highlight=False).print(table, markup=False)


def _rows(summary: dict[str, Any]) -> list[tuple[str, str]]:
    ended = " (stopped by Ctrl-C)" if summary["interrupted"] else " (stopped by an error)" if summary["error"] else ""
    rows = [("simulated", f"{summary['seconds']:.6g} s in {summary['steps']} steps of {summary['dt']:.4g} s{ended}")]
    if summary["speed"] is not None:
        rows.append(
            ("speed", f"{summary['speed']:.3g} × real time, {summary['wall_seconds']:.3g} s after the first step")
        )
    rows.append(("bodies", f"{summary['bodies']}, with {summary['contacts']} contact points at the end"))
    if "state_hash" in summary:
        rows += _what_stood(summary)
        rows += [(f"{name} energy", _energy(summary["energy"][name])) for name in ("kinetic", "potential")]
    if deepest := summary["deepest_contact"]:
        a, b = deepest["bodies"]
        rows.append(("deepest contact", f"{1e3 * deepest['depth']:.3g} mm, {a} and {b}, at {deepest['time']:.3g} s"))
    if stages := summary["stage_milliseconds"]:
        total = sum(stages.values())
        shares = ", ".join(f"{stage} {time:.3g}" for stage, time in stages.items() if time > 0)
        rows.append(("time per step", f"{total:.3g} ms: {shares}"))
    if "recording" in summary:
        rows.append(("recording", f"{summary['recording']['path']}, {summary['recording']['steps']} steps"))
    if "state_hash" in summary:
        rows.append(("state hash", summary["state_hash"]))
    return rows


def _what_stood(summary: dict[str, Any]) -> list[tuple[str, str]]:
    count, unit, farthest = summary["dynamic_bodies"], summary["length_unit"], summary["farthest"]
    if not count:
        return []
    moved = f"; {farthest['body']} moved most, by {farthest['distance']:.3g} m"
    names = ", ".join(summary["fallen"]) + (", …" if summary["fell"] > len(summary["fallen"]) else "")
    fell = f": {names}" if names else ""
    return [
        ("in place", f"{summary['in_place']} of {count}, within {IN_PLACE * unit:g} m of where they began{moved}"),
        ("fell", f"{summary['fell']} of {count}, by more than {FELL * unit:g} m{fell}"),
        ("at rest", f"{summary['at_rest']} of {count}, slower than {AT_REST * unit:g} m/s and {AT_REST:g} rad/s"),
    ]


def _energy(value: dict[str, float]) -> str:
    return f"{value['start']:.6g} J at the start, {value['end']:.6g} J at the end"
