"""What the explorer shows, without a window: a story, which slide of it, and where the shapes have been moved."""

from __future__ import annotations

import numpy as np

from atlasphys.engine.shapes.table import PLANE
from atlasphys.errors import InvalidArgumentError
from atlasphys.explainer import STAGES, Story, explain
from atlasphys.explainer.slides import Slide
from atlasphys.explainer.slides.solids import Floats, Pair


class Explorer:
    """Goes through the slides of a story. Shapes can be moved: the engine then takes the same step anew.

    Args:
        story: of a step.
        stage: the stage to begin with.
        remark: a line to be shown with the story's heading.

    Raises:
        InvalidArgumentError: there is no such stage, or the story has no step yet.
    """

    def __init__(self, story: Story, stage: str = "gjk", remark: str = "") -> None:
        if stage not in STAGES:
            raise InvalidArgumentError(f"stage must be one of {', '.join(STAGES)} (got {stage!r})")
        self.remark = remark
        self.rows = story.moment.first_and_second
        """Rows of the bodies of A and B."""
        self.index = 0
        self.changes = 0
        """Grows whenever there is something else to be shown."""
        self.story = story
        self.stage = stage
        self._world = story.world_before()
        self._start = self._world.snapshot()
        self._moved: dict[int, tuple[Floats, Floats]] = {}
        self.slides = story.slides(stage)

    @property
    def slide(self) -> Slide:
        """The present slide."""
        return self.slides[self.index]

    @property
    def pair(self) -> Pair:
        """The two shapes."""
        return self.slides.pair

    @property
    def heading(self) -> str:
        """Step, pair and what became of it."""
        moved = " (at the places to which you have moved them)" if self._moved else ""
        return " ".join(filter(None, [self.story.heading() + moved, "" if self._moved else self.remark]))

    @property
    def is_at_end(self) -> bool:
        """Whether there is no next slide."""
        return self.index == len(self.slides) - 1

    def go(self, index: int) -> None:
        """To a slide; the first or the last, if there are not so many."""
        self.index = min(max(index, 0), len(self.slides) - 1)
        self.changes += 1

    def next(self) -> None:
        """One on."""
        self.go(self.index + 1)

    def previous(self) -> None:
        """One back."""
        self.go(self.index - 1)

    def restart(self) -> None:
        """To the first."""
        self.go(0)

    def show(self, stage: str) -> None:
        """Go to the beginning of another stage."""
        self.slides = self.story.slides(stage)
        self.stage = stage
        self.go(0)

    def can_move(self, which: int) -> bool:
        """Whether A (0) or B (1) can be put elsewhere: all but planes."""
        return self.pair.kinds[which] != PLANE

    def pose(self, which: int) -> tuple[Floats, Floats]:
        """Position and orientation of A (0) or B (1) before the step."""
        bodies = self.story.moment.before.bodies
        row = self.rows[which]
        return bodies.position[row].astype(np.float64), bodies.orientation[row].astype(np.float64)

    def move(self, poses: dict[int, tuple[Floats, Floats]]) -> None:
        """Put A (0) or B (1) elsewhere, and have the engine take the step from there. Who was at the end stays there, else at the same number.

        Raises:
            InvalidArgumentError, DivergenceError: the world refuses; nothing has changed then.
        """
        self._run({**self._moved, **poses})

    def put_back(self) -> None:
        """The shapes to where they were."""
        self._run({})

    def _run(self, moved: dict[int, tuple[Floats, Floats]]) -> None:
        world = self._world
        world.restore(self._start)
        for which, (position, orientation) in moved.items():
            body = world.bodies[self.rows[which]]
            body.position, body.orientation = position, orientation
        with explain(world, pair=self.rows) as story:
            world.step(self.story.moment.h)
        slides = story.slides(self.stage)
        at_end = self.is_at_end and self.index > 0
        self.story, self.slides, self._moved = story, slides, moved
        self.go(len(slides) - 1 if at_end else self.index)
