"""Explanations: what each stage did in a step, event by event, from notes of the engine's own code. ``explain`` is where to begin."""

from atlasphys.explainer.story import STAGES, Story, explain

__all__ = ["STAGES", "Story", "explain"]
