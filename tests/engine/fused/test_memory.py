"""How much memory a body takes in the engine: a count of arrays, not of pages."""

import numpy as np

from atlasphys.bench.peers.atlasphys import AtlasPhys
from atlasphys.bench.scenes import make


def arrays_of(thing, seen):
    """All arrays that an object of the engine has, by the memory that is behind them."""
    if isinstance(thing, np.ndarray):
        while isinstance(thing.base, np.ndarray):
            thing = thing.base
        seen[thing.ctypes.data] = thing.nbytes
    elif isinstance(thing, tuple):
        for part in thing:
            arrays_of(part, seen)
    elif type(thing).__module__.startswith("atlasphys.engine"):
        for part in getattr(thing, "__dict__", {}).values():
            arrays_of(part, seen)
    return seen


def test_a_pile_of_five_thousand_boxes_takes_less_than_six_kilobytes_a_body():
    """In tables of manifolds, rows that have never been taken take no memory."""
    scene = make("boxes_5000_walls")
    engine = AtlasPhys(scene, 1, None)
    engine.run(round(scene.settle * 60))
    state = engine._world._state
    sizes, tables = arrays_of(state, {}), arrays_of((state.manifolds, state.next_manifolds), {})
    rows = 2 * state.manifold_count * sum(column[:1].nbytes for column in state.manifolds)
    assert tables.items() <= sizes.items()
    assert rows > 1000 * len(scene.bodies)
    assert sum(sizes.values()) - sum(tables.values()) + rows < 6000 * len(scene.bodies)
