"""The story of one step: what each stage did, read when it is asked for."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from html import escape
from importlib import import_module
from typing import TYPE_CHECKING, Any

from atlasphys.errors import InvalidArgumentError
from atlasphys.explainer import broadphase, solver
from atlasphys.explainer.broadphase import BroadphaseTrace
from atlasphys.explainer.clip import ClipTrace
from atlasphys.explainer.epa import EpaTrace
from atlasphys.explainer.events import Trace, plain_values
from atlasphys.explainer.gjk import GjkTrace
from atlasphys.explainer.manifold import ManifoldTrace
from atlasphys.explainer.moment import Moment
from atlasphys.explainer.narrowphase import Narrowphase
from atlasphys.explainer.sat import SatTrace
from atlasphys.explainer.solver import SolverTrace
from atlasphys.world.body import Body
from atlasphys.world.snapshot import Snapshot
from atlasphys.world.watch import SeenStep, watched
from atlasphys.world.world import World

if TYPE_CHECKING:
    from atlasphys.explainer.slides import Slides

STAGES = ("broadphase", "gjk", "epa", "sat", "clip", "manifold", "solver")
"""What can be explained, in the order of the step."""


class Story:
    """What happened in a step, stage by stage, for one pair of bodies. :func:`explain` makes it.

    Each stage is read when it is first asked for. ``str`` tells all of them, ``str(story.gjk)`` one; ``story.gjk.steps[3].simplex`` is an array.
    A notebook shows the story with a figure for each step, or ``story.slides("gjk")`` alone; ``story.view()`` opens the explorer.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._start: Snapshot | None = None
        self._moment: Moment | None = None

    @property
    def moment(self) -> Moment:
        """The step and the pair.

        Raises:
            InvalidArgumentError: no step has been taken yet.
        """
        self._check()
        assert self._moment is not None
        return self._moment

    def _check(self) -> None:
        if self._moment is None:
            raise InvalidArgumentError("no step was taken inside the block of explain(): call world.step(dt) there")

    @property
    def pair(self) -> tuple[str, str]:
        """Names of the two bodies, in the order of their rows."""
        return self.moment.name(self.moment.a), self.moment.name(self.moment.b)

    @property
    def step(self) -> int:
        """Number of the step, from 1 on."""
        return self.moment.step

    @cached_property
    def _narrowphase(self) -> Narrowphase:
        return Narrowphase(self.moment)

    @cached_property
    def broadphase(self) -> BroadphaseTrace:
        """Whether the two may touch at all."""
        return broadphase.read(self.moment)

    @cached_property
    def gjk(self) -> GjkTrace:
        """The search for the distance of the two shapes' cores."""
        return self._narrowphase.gjk()

    @cached_property
    def epa(self) -> EpaTrace:
        """The search for the depth of cores that overlap."""
        return self._narrowphase.epa()

    @cached_property
    def sat(self) -> SatTrace:
        """The separating axis test of polyhedra."""
        return self._narrowphase.sat()

    @cached_property
    def clip(self) -> ClipTrace:
        """Contact points by clipping the features that face each other."""
        return self._narrowphase.clip()

    @cached_property
    def manifold(self) -> ManifoldTrace:
        """The points that are kept, and the impulses that they go on from."""
        return self._narrowphase.manifold()

    @cached_property
    def solver(self) -> SolverTrace:
        """The impulses of the pair's contact points, sweep by sweep where the solver notes them."""
        return solver.read(self.moment)

    def stage(self, name: str) -> Trace:
        """The trace of a stage, by its name in ``STAGES``.

        Raises:
            InvalidArgumentError: there is no such stage.
        """
        if name not in STAGES:
            raise InvalidArgumentError(f"stage must be one of {', '.join(STAGES)} (got {name!r})")
        trace: Trace = getattr(self, name)
        return trace

    def slides(self, stage: str) -> Slides:
        """The trace of a stage as slides: one thing that happened each, in words and formulas (``text``, HTML with MathML), with the line of the
        engine (``source``) and a figure. A notebook shows them.

        Raises:
            InvalidArgumentError: there is no such stage.
        """
        slides: Slides = import_module("atlasphys.explainer.slides").slides_of(self, stage)
        return slides

    def world_before(self) -> World:
        """A world of its own, as it was before the step: a step of ``story.moment.h`` seconds is this one again, to the bit."""
        self._check()
        assert self._start is not None
        world = copy.deepcopy(self._world)
        world.restore(self._start)
        return world

    def view(self, stage: str = "gjk", *, port: int = 0, height: int = 760) -> Any:
        """Show the story in the explorer, a page on which each stage is gone through step by step, and the shapes can be dragged: in the notebook
        where there is one, else at the address that is printed.

        Args:
            stage: the stage to begin with, of ``STAGES``.
            port: port of the page on this machine. Default: any that is free.
            height: height of the frame in a notebook [pixels].

        Returns:
            The page; its ``url`` is the address, ``close()`` ends it.

        Raises:
            MissingExtraError: viser is not installed.
            InvalidArgumentError: there is no such stage, no step was taken, or the port is in use.
        """
        # By name, for the viewer stands above the explainer.
        show = import_module("atlasphys.viewer.notebook").show_story
        return show(self, stage, port=port, height=height)

    def data(self, *stages: str) -> dict[str, Any]:
        """The step, the pair, what became of it, and the events of some stages (default: all) as plain values, fit for JSON."""
        moment, contact = self.moment, self.moment.contact
        return {
            "step": moment.step,
            "time": moment.before.time,
            "dt": moment.h,
            "pair": list(self.pair),
            "settings": {
                name: getattr(moment.pipeline, name) for name in ("broadphase", "narrowphase", "solver")
            },
            "contact": None if contact is None else plain_values(contact),
        } | {name: self.stage(name).data() for name in stages or STAGES}  # fmt: skip

    def heading(self) -> str:
        """Step, pair and what became of it, in a line."""
        moment = self.moment
        contact = moment.contact
        a, b = self.pair
        begins = f"Step {moment.step}, from {moment.before.time:.4g} s: {a} and {b}"
        if contact is None:
            return f"{begins} have no contact."
        points = f"{len(contact.depth)} contact point" + ("s" if len(contact.depth) > 1 else "")
        return f"{begins} have {points}, the deepest {1e3 * contact.depth.max():.4g} mm deep."

    def __str__(self) -> str:
        return "\n\n".join([self.heading(), *(str(self.stage(name)) for name in STAGES)])

    def __repr__(self) -> str:
        if self._moment is None:
            return "<Story: no step taken yet>"
        return f"<Story: step {self.step}, {' and '.join(self.pair)}>"

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        """What IPython shows in a terminal."""
        printer.text(str(self) if self._moment else repr(self))

    def _repr_html_(self) -> str | None:
        """What notebooks show: all stages, to be unfolded, with a figure for each step."""
        if self._moment is None:
            return None
        folded = "".join(
            f"<details><summary><b>{name}</b></summary>{self.slides(name)._repr_html_()}</details>" for name in STAGES
        )
        return f"<p>{escape(self.heading())}</p>{folded}"


@contextmanager
def explain(world: World, pair: tuple[object, object] | None = None) -> Iterator[Story]:
    """Watch the steps that are taken inside the block, and tell how the last of them went.

    The steps themselves are those of any other time, to the bit: what the story tells is found out afterwards, by the engine's own code run as
    plain Python on a copy of the state before the step. That takes up to a few seconds; the steps take a copy of the state longer.

    Args:
        world: the world.
        pair: two bodies: handles, names or rows. Default: those of the deepest contact after the step, or, without one, the nearest two.

    Raises:
        InvalidArgumentError: not a world; or the pair is not two different bodies of it.

    >>> import atlasphys as ap
    >>> world = ap.World()
    >>> left = world.add(ap.Box(size=(1, 1, 1)), name="left")
    >>> right = world.add(ap.Sphere(radius=0.5), position=(1.2, 0, 0), name="right")
    >>> with ap.explain(world, pair=(left, right)) as story:
    ...     world.step(1 / 60)
    >>> story.gjk.verdict, round(story.gjk.distance, 4)  # of the box and the sphere's centre
    ('separated', 0.7)
    """
    if not isinstance(world, World):
        raise InvalidArgumentError(f"explain takes a world (got {world!r})")
    rows = None if pair is None else rows_of(world, pair)
    if rows is None and len(world.bodies) < 2:
        raise InvalidArgumentError(f"explain needs a pair of bodies; the world has {len(world.bodies)}")
    story = Story(world)

    def watch(seen: SeenStep) -> None:
        names = [name or f"body {row}" for row, name in enumerate(world.bodies.names)]
        story.__dict__.clear()
        story._world, story._start, story._moment = world, seen.start, Moment(seen, names, rows)

    with watched(world, watch):
        yield story


def rows_of(world: World, pair: object) -> tuple[int, int]:
    """Rows of two bodies that are given by handles, names or rows."""
    if not isinstance(pair, tuple | list) or len(pair) != 2:
        raise InvalidArgumentError(f"pair must be two bodies: handles, names or rows (got {pair!r})")
    a, b = (_row_of(world, body) for body in pair)
    if a == b:
        raise InvalidArgumentError(
            f"pair must be two different bodies (got {world.bodies[a].name or f'body {a}'} twice)"
        )
    return min(a, b), max(a, b)


def _row_of(world: World, body: object) -> int:
    if isinstance(body, Body):
        if body.world is not world:
            raise InvalidArgumentError(f"{body!r} belongs to another world")
        return body.row
    if isinstance(body, str):
        if body in world.bodies.names:
            return world.bodies.names.index(body)
        raise InvalidArgumentError(f"no body is named {body!r}; there are {_some(world)}")
    if isinstance(body, int) and not isinstance(body, bool) and 0 <= body < len(world.bodies):
        return body
    raise InvalidArgumentError(
        f"a body is given by its handle, its name or its row from 0 to {len(world.bodies) - 1} (got {body!r})"
    )


def _some(world: World) -> str:
    names = [repr(name) for name in world.bodies.names if name is not None]
    if not names:
        return "no names, but rows"
    return ", ".join(names[:8]) + (f" and {len(names) - 8} more" if len(names) > 8 else "")
