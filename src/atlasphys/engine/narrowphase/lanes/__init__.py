"""The narrow phase over eight pairs at once: one file for each kind of pair, ``plane.py`` for all pairs with a plane.

Each body has the signature ``body(pairs, geometry, place, margin, contact, tags) -> bool``:

- ``pairs`` (2, 8) int32: rows of the bodies of the first and the second shape, in the order of their kinds (``shapes/table.py``). Idle lanes
  repeat a real pair.
- ``geometry`` (n, 16): columns 0 to 8 are a body's rotation matrix, row by row. A shape's centre is its body's centre of mass.
- ``place`` (16, 8): fields 0 to 2 lead from the centre of the first to that of the second [m], in world axes; 4 to 7 are the size of the first
  shape, 8 to 11 that of the second, as ``Shapes.size``. With a plane: 0 to 2 its outward unit normal, 3 the height of the first shape's centre
  above it [m], 4 to 7 the size of the first.
- ``margin``: gap under which points are given [m].
- ``contact`` (24, 8), written: fields 0 to 2 are the unit normal from the first to the second shape; for point k, 4 + 4 k to 6 + 4 k its position
  as seen from the centre of the first, midway between the two surfaces, and 7 + 4 k its depth [m]. Unused points are zero. Where a lane has no
  points, its normal means nothing.
- ``tags`` (8, 8) int32, written: 0 to 3 the feature of each point, 4 the number of points.

The answer is whether any lane has points. Normals, depths and points mean what they do in the scalar routines of ``narrowphase/pairs``, which
differ in three ways: they give a box all corners of the contact polygon, two edges side by side two points, and boxes that are apart corner to
corner a point, though neither lies over the other.
"""
