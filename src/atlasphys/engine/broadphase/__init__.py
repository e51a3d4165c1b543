"""Stage 1, broad phase: which pairs of colliders have overlapping bounds. ``BROADPHASES`` is the table of choices."""

from atlasphys.engine.broadphase import brute, sweep, tree

BROADPHASES = {"brute": brute.find_pairs, "sweep": sweep.find_pairs, "tree": tree.find_pairs}
"""Name → function that finds all pairs that may touch. Every choice gives the same pairs in the same order."""
