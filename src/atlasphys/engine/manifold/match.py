"""Matching of a pair's new contact points with last step's, so that impulses carry over (warm starting).

A point is last step's point if the same features of the two shapes meet there; failing that, if it lies close to it as seen
from either body. Position is needed because feature ids flicker where faces align, as they do in every stack of boxes.
"""

from atlasphys.engine.jit import routine
from atlasphys.engine.math import vec

FEATURE_REACH = 100
"""Square of the multiple of the matching distance within which equal features count as the same contact."""


@routine
def match_points(
    i, count, feature, local_a, local_b, j, old_count, old_feature, old_local_a, old_local_b, distance, origin
):  # fmt: skip
    """For each of the ``count`` points of new manifold i, find the point of old manifold j that it goes on from.

    ``origin[k]`` becomes that point's number, or −1. Each old point serves at most one new one.
    """
    used = 0
    limit = distance * distance
    for pass_number in range(2):
        for k in range(count):
            if pass_number == 0:
                origin[k] = -1
            elif origin[k] >= 0:
                continue
            best = type(distance)(FEATURE_REACH) * limit if pass_number == 0 else limit
            a, b = vec.load_at(local_a, i, k), vec.load_at(local_b, i, k)
            for q in range(old_count):
                if used & (1 << q) or (pass_number == 0 and feature[i, k] != old_feature[j, q]):
                    continue
                squared = min(
                    vec.length_squared(vec.sub(a, vec.load_at(old_local_a, j, q))),
                    vec.length_squared(vec.sub(b, vec.load_at(old_local_b, j, q))),
                )
                if squared <= best:
                    origin[k], best = q, squared
            if origin[k] >= 0:
                used |= 1 << origin[k]
