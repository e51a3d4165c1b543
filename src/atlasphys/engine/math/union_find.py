"""Union–find: disjoint sets as a forest, in which each element names its parent and a root itself."""

from atlasphys.engine.jit import routine


@routine
def find_root(parent, i):
    """The representative of i's set; halves the path on the way."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@routine
def unite(parent, i, j):
    """Make one set of those of i and j. Its representative is the lower of the two."""
    i, j = find_root(parent, i), find_root(parent, j)
    parent[max(i, j)] = min(i, j)
