"""``atlasphys explain``: what a stage did in one step of a scene, event by event."""

from __future__ import annotations

import json as json_format
import sys
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from atlasphys.cli.run import parameters_of, positive
from atlasphys.errors import InvalidArgumentError

if TYPE_CHECKING:
    from atlasphys.explainer import Story
    from atlasphys.world.world import World


def explain(
    stage: str,
    scene: str,
    /,
    *,
    pair: str | None = None,
    step: int | None = None,
    dt: float | None = None,
    preset: str | None = None,
    solver: str | None = None,
    set: Annotated[list[str] | None, Parameter(negative=())] = None,
    json: Annotated[bool, Parameter(negative=())] = False,
    view: Annotated[bool, Parameter(negative=())] = False,
    port: int | None = None,
    open: bool = True,
) -> int:
    """Tell what a stage of the engine did in one step of a scene, for one pair of bodies.

    Parameters
    ----------
    stage
        broadphase, gjk, epa, sat, clip, manifold, solver, or all.
    scene
        Name of a scene of the library (see `atlasphys scenes`), or a scene file.
    pair
        Two bodies, by name or row, with a comma between. Default: those of the deepest contact.
    step
        Number of the step, from 1 on. Default: the first in which the pair (or any two bodies that may) touch.
    dt
        Time step [s]. Default: the scene's.
    preset
        Named choice of algorithms, such as classic.
    solver
        Name of the solver.
    set
        NAME=VALUE: a parameter of a scene of the library. May be given several times.
    json
        Print the events as one JSON object on standard output instead of the story.
    view
        Show the story on a page in the browser, the explorer, and go through it step by step. Ctrl-C ends it.
    port
        With --view: port of the page on this machine; 0: any that is free. Default: 8080, or the next free one.
    open
        With --view: open the page in the browser.
    """
    from atlasphys.explainer import STAGES
    from atlasphys.scene.load import load_scene

    if stage not in (*STAGES, "all"):
        raise InvalidArgumentError(f"the stage must be one of {', '.join(STAGES)}, or all (got {stage!r})")
    if view and json:
        raise InvalidArgumentError("--view shows the story on a page and --json prints it: give one of the two")
    if port is not None and not view:
        raise InvalidArgumentError("--port is the port of the page of --view: give both")
    loaded = load_scene(scene, **parameters_of(set or []))
    h = loaded.dt if dt is None else positive("--dt", dt)
    last = max(1, round(loaded.seconds / h))
    if step is not None and not 1 <= step <= last:
        raise InvalidArgumentError(
            f"--step must be from 1 to {last}, the last step of {loaded.name} ({loaded.seconds:g} s at {h:.4g} s) (got {step})"
        )
    settings = {name: value for name, value in {"preset": preset, "solver": solver}.items() if value is not None}
    world = loaded.build(**settings)
    rows = None if pair is None else _pair(world, pair)
    story, remark = _explained(world, rows, h, step, last)
    stages = STAGES if stage == "all" else (stage,)
    if view:
        return _shown(story, stages[0], f"{loaded.name}: {remark}" if remark else "", port, open)
    if json:
        print(json_format.dumps({"scene": loaded.name, "remark": remark} | story.data(*stages), ensure_ascii=False))
    else:
        print(
            "\n\n".join(
                [" ".join(filter(None, [story.heading(), remark])), *(str(story.stage(name)) for name in stages)]
            )
        )
    sys.stdout.flush()
    return 0


def _shown(story: Story, stage: str, remark: str, port: int | None, in_browser: bool) -> int:
    """The explorer, until Ctrl-C."""
    from atlasphys.cli.view import until_interrupted
    from atlasphys.viewer.explorer.explorer import Explorer
    from atlasphys.viewer.explorer.page import Page

    page = Page(Explorer(story, stage, remark), port=port)
    return until_interrupted(page, f"explorer of {stage}, {' and '.join(story.pair)},", in_browser)


def _pair(world: World, words: str) -> tuple[int, int]:
    """Rows of two bodies from ``A,B``."""
    from atlasphys.explainer.story import rows_of

    names = [word.strip() for word in words.split(",")]
    if len(names) != 2 or not all(names):
        raise InvalidArgumentError(f"--pair takes two bodies with a comma between, by name or row (got {words!r})")
    known = world.bodies.names
    return rows_of(world, [int(name) if name not in known and name.isdecimal() else name for name in names])


def _explained(world: World, pair: tuple[int, int] | None, h: float, step: int | None, last: int) -> tuple[Story, str]:
    """The story of a step; where none is asked for, of the first in which the pair touches, and what to say if there is none."""
    from atlasphys.explainer import explain as watch

    if step is None:
        found = _first_contact(world, pair, h, last)
        step, remark = (
            (found, "")
            if found
            else (last, f"They do not touch in any of the {last} steps of the scene; this is the last.")
        )
        if not found and pair is None:
            remark = f"No two bodies touch in any of the {last} steps of the scene; this is the last."
    else:
        remark = ""
    if step > world.steps + 1:
        world.run(seconds=h * (step - 1 - world.steps), dt=h)
    with watch(world, pair=pair) as story:
        world.step(h)
    return story, remark


def _first_contact(world: World, pair: tuple[int, int] | None, h: float, last: int) -> int:
    """Number of the first step in which the pair touches; 0 if it does not. The world is left before that step, or before the last one.

    Without a pair: of any two bodies but planes, or, if there are none, of any two.
    """
    from atlasphys.engine.shapes.plane import Plane

    bounded = [not isinstance(body.shape, Plane) for body in world.bodies]
    first = 0
    begin = world.snapshot()
    for number in range(1, last + 1):
        before = world.snapshot()
        world.step(h)
        contacts = world.contacts
        touching = {(int(a), int(b)) for a, b in zip(contacts.body_a, contacts.body_b, strict=True)}
        if (pair in touching) if pair is not None else any(bounded[a] and bounded[b] for a, b in touching):
            world.restore(before)
            return number
        first = first or (number if touching and pair is None else 0)
    world.restore(begin)
    return first
