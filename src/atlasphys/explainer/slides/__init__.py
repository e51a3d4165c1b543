"""Stories as slides: one thing that happened each, in words and formulas, with a figure and the line of the engine."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from typing import TYPE_CHECKING, Any, overload

from atlasphys.explainer.slides import broadphase, clip, epa, gjk, manifold, sat, solver
from atlasphys.explainer.slides.gjk import CAPTION, difference_marks
from atlasphys.explainer.slides.slide import Slide, excerpt, line_that_did_it, paragraph
from atlasphys.explainer.slides.solids import Pair
from atlasphys.explainer.slides.svg import figure

if TYPE_CHECKING:
    from atlasphys.explainer.story import Story

__all__ = ["Slide", "Slides", "slides_of"]


class Slides(Sequence[Slide]):
    """The slides of a stage. A notebook shows them, with their figures.

    Attributes:
        stage: name of the stage.
        heading: step, pair, and what became of it.
        remark: what to know beforehand, such as that the step itself took another routine for this pair.
        pair: the two shapes.
    """

    def __init__(self, stage: str, heading: str, remark: str, pair: Pair, slides: list[Slide]) -> None:
        self.stage, self.heading, self.remark, self.pair = stage, heading, remark, pair
        self._slides = tuple(slides)

    def __len__(self) -> int:
        return len(self._slides)

    @overload
    def __getitem__(self, index: int) -> Slide: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Slide, ...]: ...
    def __getitem__(self, index: int | slice) -> Slide | tuple[Slide, ...]:
        return self._slides[index]

    def __iter__(self) -> Iterator[Slide]:
        return iter(self._slides)

    def __repr__(self) -> str:
        return f"<Slides: {self.stage}, {len(self)} of them>"

    def _repr_html_(self) -> str:
        """What notebooks show."""
        parts = [f"<p><b>{escape(self.heading)}</b></p>"]
        if self.remark:
            parts.append(f'<p style="color:#69727d">{escape(self.remark)}</p>')
        for i, slide in enumerate(self, 1):
            parts.append(f'<h4 style="margin:1em 0 0.3em">{i}. {escape(slide.title)}</h4>')
            parts.append(f'<div style="display:flex;flex-wrap:wrap;gap:14px"><div>{figure(self.pair, slide)}</div>')
            file, line = line_that_did_it(slide.source, slide.needle) if slide.source else ("", 0)
            source = f'<div style="font-size:0.85em;color:#69727d">{escape(file)}, line {line}</div>' if file else ""
            parts.append(f'<div style="flex:1;min-width:260px;max-width:34em">{slide.text}{source}</div></div>')
        return "".join(parts)


MAKERS: dict[str, Any] = {
    "gjk": gjk.slides,
    "epa": epa.slides,
    "sat": sat.slides,
    "clip": clip.slides,
    "manifold": manifold.slides,
    "solver": solver.slides,
    "broadphase": broadphase.slides,
}


def slides_of(story: Story, stage: str) -> Slides:
    """The slides of a stage of a story; where the stage does not apply, one that says what happened instead.

    Raises:
        InvalidArgumentError: there is no such stage.
    """
    trace = story.stage(stage)
    pair = Pair(story.moment)
    found = [instead(pair, trace.instead)] if trace.instead else MAKERS[stage](pair, trace)
    return Slides(stage, story.heading(), trace.remark, pair, found)


def instead(pair: Pair, why: str) -> Slide:
    """A stage that does not apply: what happened instead, and the shapes."""
    is_bounded = pair.difference is not None
    return Slide(
        title="This stage has nothing to do",
        text=paragraph(f"<b>{escape(why)}</b>"),
        beside=difference_marks(pair) if is_bounded else (),
        caption=CAPTION if is_bounded else "",
    )


def page_text(slide: Slide) -> str:
    """The words of a slide with the lines of the engine."""
    return slide.text + (excerpt(slide.source, slide.needle) if slide.source else "")
