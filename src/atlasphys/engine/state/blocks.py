"""Which manifold each lane of a block of eight contacts holds: what ``islands/colour.py`` writes and the solver's bodies over lanes read."""

BODY_A, BODY_B, MOVES_A, MOVES_B, MANIFOLD, COUNT, ROLLS, BOUNCES = range(8)
"""Rows of a block's integers (8, 8): the two bodies' rows, whether impulses move them, the manifold's row, its number of points (0 in an idle
lane), and, in lane 0, whether some manifold of the block has rolling friction (solvers/rolling_block.py), and whether some one has restitution
(solvers/xpbd.py)."""

INTEGERS = 8
"""Number of these rows."""
