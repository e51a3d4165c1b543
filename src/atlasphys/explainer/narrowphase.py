"""Runs the narrow phase of one pair once more, as plain Python that takes notes, and reads them stage by stage."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property

import numpy as np

from atlasphys.engine.narrowphase.dispatch import PairKernel
from atlasphys.engine.narrowphase.pairs.box_box import box_box
from atlasphys.engine.narrowphase.pairs.convex_convex import convex_convex
from atlasphys.engine.narrowphase.pairs.polyhedra import polyhedra
from atlasphys.engine.shapes.support import rounding
from atlasphys.engine.shapes.table import BOX, HULL
from atlasphys.engine.state.contacts import Contacts
from atlasphys.explainer import clip, epa, gjk, manifold, sat
from atlasphys.explainer.clip import ClipTrace
from atlasphys.explainer.epa import EpaTrace
from atlasphys.explainer.events import length
from atlasphys.explainer.gjk import GjkTrace
from atlasphys.explainer.manifold import ManifoldTrace
from atlasphys.explainer.moment import LANE_BODIES, Moment
from atlasphys.explainer.plain import Note, plain, recording
from atlasphys.explainer.sat import SatTrace


class Narrowphase:
    """What the narrow phase's routines do with a moment's pair."""

    def __init__(self, moment: Moment) -> None:
        self.moment = moment

    def collide(self, kernel: PairKernel) -> tuple[Contacts, list[Note]]:
        """Have a routine collide the pair: its contact points, and the notes of all that it did."""
        moment, state = self.moment, self.moment.before
        contacts, rows = moment.one_pair(), np.zeros(1, np.intp)
        with recording() as notes:
            plain(kernel)(rows, state.bodies, state.colliders, moment.shapes, state.tolerances.margin, contacts)
        return contacts, notes

    @cached_property
    def generic(self) -> tuple[Contacts, list[Note]]:
        """GJK, EPA and clipping."""
        return self.collide(convex_convex)

    @cached_property
    def own(self) -> tuple[Contacts, list[Note]]:
        """The routine that the world's settings give the pair."""
        return self.generic if self.moment.routine is convex_convex else self.collide(self.moment.routine)

    @property
    def shape_names(self) -> tuple[str, str]:
        """The two shapes as the narrow phase takes them, in words."""
        first, second = (
            f"{self.moment.name(row)} ({self.moment.shape_name(row)})" for row in self.moment.first_and_second
        )
        return first, second

    @property
    def radii(self) -> tuple[float, float]:
        """Radii about the cores of the two [m]."""
        rows = (self.moment.before.colliders.shape[row] for row in self.moment.first_and_second)
        first, second = (float(plain(rounding)(self.moment.shapes, row)) for row in rows)
        return first, second

    def who(self, algorithm: Callable[..., object], name: str) -> str:
        """What to say if the step did not give the pair to an algorithm."""
        moment = self.moment
        said = []
        if moment.contact is not None and not moment.contact.collided:
            said.append(
                "The step itself did not collide this pair: its contact points moved on with the two bodies (recycled), or both sleep."
            )
        if moment.routine is not algorithm:
            by = f"{moment.routine.__name__} (narrowphase={moment.pipeline.narrowphase!r})"
            said.append(f"The routine for this pair is {by}; this is what {name} makes of it.")
        if moment.by_lanes:
            said.append(
                f"The step runs that routine for eight pairs at a time ({LANE_BODIES}); what follows is the same for one pair."
            )
        return " ".join(said)

    def gjk(self) -> GjkTrace:
        """The trace of GJK."""
        if self.moment.has_plane:
            return GjkTrace(instead=self.no_plane("GJK"))
        found = gjk.read(self.generic[1], self.shape_names, self.radii)
        return replace(found, remark=self.who(convex_convex, "GJK"))

    def epa(self) -> EpaTrace:
        """The trace of EPA, or why it was not needed."""
        if self.moment.has_plane:
            return EpaTrace(instead=self.no_plane("EPA"))
        searched = self.gjk()
        if searched.verdict == "separated":
            cores = "cores" if any(self.radii) else "shapes"
            return EpaTrace(
                remark=searched.remark,
                instead=f"EPA has nothing to do: GJK found the {cores} {length(searched.distance)} apart.",
                radii=self.radii,
            )
        return replace(epa.read(self.generic[1], self.radii), remark=self.who(convex_convex, "EPA"))

    def sat(self) -> SatTrace:
        """The trace of the separating axis test, or why there is none."""
        kinds = self.moment.kinds
        a, b = self.shape_names
        if not set(kinds) <= {BOX, HULL}:
            return SatTrace(
                instead=f"The separating axis test is for two polyhedra, boxes or hulls; here are {a} and {b}."
            )
        kernel = box_box if set(kinds) == {BOX} else polyhedra
        notes = self.own[1] if self.moment.routine is kernel else self.collide(kernel)[1]
        return replace(
            sat.read(notes, self.moment, kernel is box_box), remark=self.who(kernel, "the separating axis test")
        )

    def clip(self) -> ClipTrace:
        """The trace of clipping, or why nothing was clipped."""
        found = clip.read(self.own[1], self.shape_names, self.moment.routine.__name__)
        return replace(found, remark=self.who(self.moment.routine, ""))

    def manifold(self) -> ManifoldTrace:
        """What became of the contact points: reduced, matched, impulses carried over."""
        found = manifold.read(self.moment, self.own[0])
        remark = self.who(self.moment.routine, "")
        if self.moment.is_fused:
            remark += (
                " The step matches points for eight pairs at a time (engine/manifold/renew.py), by the distance as seen from either body, with a "
                "tenth of it where the features are the same; told here is the way for one pair, by features first."
            )
        return replace(found, remark=remark.strip())

    def no_plane(self, name: str) -> str:
        """Why an algorithm for bounded shapes does not apply."""
        a, b = self.shape_names
        return f"{name} is for two bounded shapes; of {a} and {b} one is a plane, whose distance from a shape follows from the shape's deepest point."
