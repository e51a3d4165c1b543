"""What a recording holds. HDF5 (so other programs can read it), version 1:

- attributes of the root: ``format`` and ``version``, and ``atlasphys``, the version that wrote it;
- ``scene``: the scene as JSON text, in the schema of scene files;
- ``bodies``: (b,) a body each, as JSON text in that schema, as it was when it was first recorded;
- ``time``: (s,) simulated time of each recorded step [s];
- ``poses``: (s, b, 7) position [m] and orientation (w, x, y, z), in double precision; NaN where a body was not there.

- ``joints``: (j,) a joint each, as JSON text in that schema, as it was when it was first recorded; ``a`` and ``b`` are rows of ``bodies``;
- ``joint_state``: (s, j) what each was doing at each step, out of ``NOT_THERE``, ``IDLE`` and ``ACTS``.

The last two are absent from recordings of earlier versions of AtlasPhys. And, if contacts were asked for:

- ``contact_end``: (s,) how many contact points were recorded up to and including each step;
- ``contacts``: (k, 13) the contact points one after another, in single precision, with the columns of ``CONTACT_COLUMNS``.
"""

FORMAT = "atlasphys recording"
VERSION = 1

CHUNK_STEPS, CHUNK_BODIES = 50, 64
"""Steps and bodies stored together. Reading one step of all bodies unpacks 50; reading one body unpacks 64."""

NOT_THERE, IDLE, ACTS = range(3)
"""What a joint is doing: it is not in the world; it is disabled or broken; it acts."""

CONTACT_COLUMNS = {
    "body_a": 1, "body_b": 1, "point": 3, "normal": 3, "depth": 1, "normal_impulse": 1, "friction_impulse": 3,
}  # fmt: skip
"""Fields of ``World.contacts`` in the order of their columns, and how many columns each has. Bodies are rows of ``bodies``."""
