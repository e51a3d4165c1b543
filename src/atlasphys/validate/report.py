"""What a validation says: a table on the terminal, and a report in Markdown."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from atlasphys.validate.case import Case
from atlasphys.validate.contenders import Contender
from atlasphys.validate.runner import Outcome, errors_by_dt, judged, observed_order


class Grid:
    """Outcomes as a table: a row for each error of each case, a column for each contender."""

    def __init__(self, outcomes: Sequence[Outcome]) -> None:
        self.outcomes = outcomes
        self.cases: list[Case] = list({outcome.case.number: outcome.case for outcome in outcomes}.values())
        self.contenders: list[Contender] = list({o.contender.name: o.contender for o in outcomes}.values())
        self.cells = {(outcome.case.number, outcome.contender.name): outcome for outcome in judged(outcomes)}

    def names(self, case: Case) -> list[str]:
        """The errors of a case: those with a tolerance, then those that are only reported."""
        found = list(case.tolerances)
        for contender in self.contenders:
            outcome = self.cells.get((case.number, contender.name))
            found += [
                name for name in (outcome.result.errors if outcome and outcome.result else ()) if name not in found
            ]
        return found

    def orders(self, case: Case, name: str, contender: Contender) -> float | None:
        """The observed order of an error, of those that have an expected one."""
        if name not in case.orders:
            return None
        return observed_order(errors_by_dt(self.outcomes, case.number, contender.name, name))


def print_table(outcomes: Sequence[Outcome]) -> None:
    """Print a line for each case, whether it is passed and its greatest error as a share of the tolerance; below it each error that has one."""
    grid = Grid(outcomes)
    table = Table(header_style="bold", box=SIMPLE_HEAD, pad_edge=False, show_edge=False, padding=(0, 1, 0, 0))
    table.add_column("case and errors", overflow="fold")
    table.add_column("limit", justify="right", no_wrap=True)
    for contender in grid.contenders:
        table.add_column(contender.name.replace(":", "\n"), justify="right", no_wrap=True)
    for case in grid.cases:
        table.add_row(
            f"{case.number} {case.name}", "", *(_verdict(grid, case, c) for c in grid.contenders), style="bold"
        )
        for name, limit in case.tolerances.items():
            cells = [_cell(grid, case, name, contender) for contender in grid.contenders]
            table.add_row(escape(f"  {name}"), _number(limit), *cells)
            if name in case.orders:
                orders = (grid.orders(case, name, contender) for contender in grid.contenders)
                shown = ("" if order is None else f"{order:.1f}" for order in orders)
                table.add_row("    order", f"{case.orders[name]:g}", *shown, style="dim")
    console = Console(highlight=False)
    console.print(table)
    console.print("✓ passed, ✗ failed: the greatest error as a share of its tolerance; – not offered\n")
    for line in summary(outcomes):
        console.print(line, markup=False)


def _verdict(grid: Grid, case: Case, contender: Contender) -> str:
    outcome = grid.cells.get((case.number, contender.name))
    if outcome is None or outcome.status == "not offered":
        return "" if outcome is None else "–"
    if outcome.result is None:
        return "[red]error[/red]"
    share = _share(outcome.result.score)
    return f"[green]✓ {share}[/green]" if outcome.result.passed else f"[red]✗ {share}[/red]"


def _cell(grid: Grid, case: Case, name: str, contender: Contender) -> str:
    outcome = grid.cells.get((case.number, contender.name))
    if outcome is None or outcome.result is None or name not in outcome.result.errors:
        return ""
    text = _number(outcome.result.errors[name])
    return f"[red]{text}[/red]" if name in outcome.result.failures else text


def summary(outcomes: Sequence[Outcome]) -> list[str]:
    """A line for each contender: what it passed, failed and does not offer; then why."""
    grid = Grid(outcomes)
    lines, reasons = [], []
    for contender in grid.contenders:
        mine = [outcome for outcome in grid.cells.values() if outcome.contender.name == contender.name]
        by = {
            status: [o for o in mine if o.status == status] for status in ("passed", "failed", "error", "not offered")
        }
        words = [f"{len(by['passed'])} passed"]
        words += [
            f"{status}: {', '.join(str(o.case.number) for o in by[status])}" for status in list(by)[1:] if by[status]
        ]
        lines.append(f"{contender.title}: {'; '.join(words)}")
        reasons += [
            f"{contender.title}, case {o.case.number}: {o.reason}" for o in mine if o.reason and not o.case.not_offered
        ]
    reasons += [f"case {case.number}, {case.name}: {case.not_offered}" for case in grid.cases if case.not_offered]
    return lines + reasons


def markdown(outcomes: Sequence[Outcome]) -> str:
    """The table in Markdown; bold is beyond the tolerance, – is not offered; and what each contender passed."""
    grid = Grid(outcomes)
    lines = [
        "| # | case | error | tolerance | " + " | ".join(contender.title for contender in grid.contenders) + " |",
        "|---|---|---|---|" + "---|" * len(grid.contenders),
    ]
    for case in grid.cases:
        for name in grid.names(case) or [""]:
            cells = [_markdown_cell(grid, case, name, contender) for contender in grid.contenders]
            limit = _number(case.tolerances[name]) if name in case.tolerances else ("reported" if name else "–")
            lines.append(f"| {case.number} | {case.name} | {name or '–'} | {limit} | {' | '.join(cells)} |")
    lines += ["", *(f"- {line}" for line in summary(outcomes))]
    if any(contender.is_peer for contender in grid.contenders):
        lines += ["", *shares(grid)]
    return "\n".join(lines) + "\n"


def _markdown_cell(grid: Grid, case: Case, name: str, contender: Contender) -> str:
    outcome = grid.cells.get((case.number, contender.name))
    if outcome is None or outcome.result is None:
        return "–" if outcome is None or outcome.status == "not offered" else "**error**"
    if name not in outcome.result.errors:
        return "–"
    text = _number(outcome.result.errors[name])
    order = grid.orders(case, name, contender)
    suffix = f" (order {order:.1f})" if order is not None else ""
    return (f"**{text}**" if name in outcome.result.failures else text) + suffix


def shares(grid: Grid) -> list[str]:
    """Per case, each contender's greatest error as a share of its tolerance, and who errs least."""
    lines = [
        "| # | case | " + " | ".join(contender.title for contender in grid.contenders) + " | least |",
        "|---|---|" + "---|" * (len(grid.contenders) + 1),
    ]
    for case in grid.cases:
        scores = {}
        for contender in grid.contenders:
            outcome = grid.cells.get((case.number, contender.name))
            if outcome and outcome.result:
                scores[contender.title] = outcome.result.score
        if len(scores) < 2:
            continue
        least = min(scores.values())
        best = ", ".join(title for title, score in scores.items() if score <= least)
        cells = [_number(scores.get(contender.title)) for contender in grid.contenders]
        lines.append(f"| {case.number} | {case.name} | {' | '.join(cells)} | {best} |")
    return ["Greatest error of each case as a share of its tolerance (1: just passed):", "", *lines]


def write_report(folder: Path, outcomes: Sequence[Outcome], pictures: Sequence[tuple[str, Path]]) -> Path:
    """Write ``report.md`` with the table and the pictures."""
    from atlasphys import __version__

    text = [f"# Validation of AtlasPhys {__version__}", ""]
    text += [
        "Errors at each case's own dt, or at the least one that was run; relative to the reference unless the name gives a unit.",
        "**Bold**: beyond the tolerance. –: not offered. The order is that at which the error falls with dt.",
        "",
        markdown(outcomes),
    ]
    for title, picture in pictures:
        text += [f"## {title}", "", f"![{title}]({picture.name})", ""]
    path = folder / "report.md"
    path.write_text("\n".join(text), encoding="utf-8")
    return path


def _share(score: float) -> str:
    """A score in percent, or in multiples where it is large."""
    if 0 < score < 0.01:
        return "<1 %"
    if math.isinf(score):
        return "∞"
    return f"{100 * score:.0f} %" if score < 10 else f"{score:.0f}×" if score < 1000 else f"{score:.0e}×"


def _number(value: float | None) -> str:
    if value is None:
        return "–"
    if not math.isfinite(value):
        return "∞" if value > 0 else "not a number"
    return f"{value:.2g}"
