"""Lists of pairs (a, b), a < b, ordered by a and then by b. All steps are linear in the number of pairs and rows."""

from atlasphys.engine.jit import kernel, routine


@routine
def running_total(starts):
    """Turn the number of entries of each row into the place of its first one."""
    total = 0
    for row in range(len(starts)):
        here = starts[row]
        starts[row] = total
        total += here


@kernel
def sort_pairs(pairs, starts, ends, scratch, result):
    """Write the pairs into ``result`` in order. ``starts`` and ``ends`` have a place for each row, ``scratch`` one for each pair.

    The pairs are a sparse matrix. Listing it column by column and then taking each entry to its row leaves every row in the order of the
    columns (F. G. Gustavson, "Two fast algorithms for sparse matrices", 1978).
    """
    n = len(starts)
    for row in range(n):
        starts[row] = ends[row] = 0
    for p in range(len(pairs)):
        starts[pairs[p, 0]] += 1
        ends[pairs[p, 1]] += 1
    running_total(starts)
    running_total(ends)
    for p in range(len(pairs)):
        b = pairs[p, 1]
        scratch[ends[b]] = pairs[p, 0]
        ends[b] += 1
    p = 0
    for b in range(n):
        while p < ends[b]:
            a = scratch[p]
            place = starts[a]
            starts[a] = place + 1
            result[place, 0], result[place, 1] = a, b
            p += 1


@kernel
def merge_pairs(old, fresh, changed, result):
    """Write the old pairs of which neither row is flagged in ``changed``, and the fresh ones, in order; return how many there are."""
    found, f = 0, 0
    for p in range(len(old)):
        a, b = old[p, 0], old[p, 1]
        if changed[a] or changed[b]:
            continue
        while f < len(fresh) and (fresh[f, 0] < a or (fresh[f, 0] == a and fresh[f, 1] < b)):
            result[found, 0], result[found, 1] = fresh[f, 0], fresh[f, 1]
            found += 1
            f += 1
        result[found, 0], result[found, 1] = a, b
        found += 1
    while f < len(fresh):
        result[found, 0], result[found, 1] = fresh[f, 0], fresh[f, 1]
        found += 1
        f += 1
    return found
