"""What is done with blocks of parts of each type, as addresses by which solvers call it.

So a type is compiled once a world has such parts, and the step, which every world needs, without them. ``arguments`` are the bodies' motion,
geometry, inverse masses and centres, and the working memory of the joints.

Each type is written out: a kernel that got its routine from a function that makes both would have another key in the kernel cache in each process.
"""

from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.joints.visit import keep_results, prepare, solve, start
from atlasphys.engine.simd import LANES
from atlasphys.engine.simd.address import address_call
from atlasphys.engine.state.joint_work import (
    ANY,
    APART,
    LIVE,
    MOVES_A,
    MOVES_B,
    PART,
    PREPARE,
    ROW_A,
    ROW_B,
    SOLVE,
    START,
    TIED_A,
    TIED_B,
)
from atlasphys.engine.state.joints import (
    AXIS,
    CONE,
    COUPLING,
    CROSS,
    DISTANCE,
    LINE,
    LOCK,
    POINT,
    PULLEY,
    ROTATION,
    TRANSLATION,
)


@routine
def place(block, center, work):
    """Note in a block which of its parts act and which bodies move in this step, and how far apart these are, in double precision."""
    integers, active = work.integers, work.active
    any_live = 0
    for lane in range(LANES):
        a, b = integers[block, ROW_A, lane], integers[block, ROW_B, lane]
        tied_a, tied_b, part = integers[block, TIED_A, lane], integers[block, TIED_B, lane], integers[block, PART, lane]
        moves_a, moves_b = tied_a and active[a] and work.moves[a], tied_b and active[b] and work.moves[b]
        integers[block, MOVES_A, lane], integers[block, MOVES_B, lane] = moves_a, moves_b
        live = moves_a or moves_b
        integers[block, LIVE, lane] = live
        any_live = any_live or live
        for k in range(3):
            start_a, start_b = work.base[part, k], work.base[part, 4 + k]
            if work.hung[part]:
                center_a = center[a, k] if tied_a else 0.0
                center_b = center[b, k] if tied_b else 0.0
                work.blocks[block, APART + k, lane] = center_a - start_a
                work.blocks[block, APART + 3 + k, lane] = center_b - start_b
            else:
                center_a = center[a, k] if tied_a else start_a
                center_b = center[b, k] if tied_b else start_b
                work.blocks[block, APART + k, lane] = center_b - center_a
    integers[block, ANY, 0] = any_live


@routine
def _tables(arguments, mode, first, stop):
    _, _, _, center, work = arguments
    for block in range(first, stop):
        if mode == PREPARE:
            place(block, center, work)
        if work.integers[block, ANY, 0]:
            if mode == PREPARE:
                prepare(block, work)
            else:
                keep_results(block, work)


@kernel
def tables_address(arguments):
    """Address of the code that prepares blocks and stores their results."""
    return address_call(_tables, arguments)[0]


@routine
def _rotation(arguments, mode, first, stop):
    motion, geometry, inverse_mass, _, work = arguments
    for block in range(first, stop):
        if work.integers[block, ANY, 0]:
            if mode == START:
                start(ROTATION, block, motion, geometry, inverse_mass, work)
            elif mode == SOLVE:
                solve(ROTATION, 0, block, motion, geometry, inverse_mass, work)
            else:
                solve(ROTATION, 1, block, motion, geometry, inverse_mass, work)


@kernel
def rotation_address(arguments):
    """Address of the code that visits blocks of rotation parts."""
    return address_call(_rotation, arguments)[0]


@routine
def _cone(arguments, mode, first, stop):
    motion, geometry, inverse_mass, _, work = arguments
    for block in range(first, stop):
        if work.integers[block, ANY, 0]:
            if mode == START:
                start(CONE, block, motion, geometry, inverse_mass, work)
            elif mode == SOLVE:
                solve(CONE, 0, block, motion, geometry, inverse_mass, work)
            else:
                solve(CONE, 1, block, motion, geometry, inverse_mass, work)


@kernel
def cone_address(arguments):
    """Address of the code that visits blocks of cone parts."""
    return address_call(_cone, arguments)[0]


@routine
def _cross(arguments, mode, first, stop):
    motion, geometry, inverse_mass, _, work = arguments
    for block in range(first, stop):
        if work.integers[block, ANY, 0]:
            if mode == START:
                start(CROSS, block, motion, geometry, inverse_mass, work)
            elif mode == SOLVE:
                solve(CROSS, 0, block, motion, geometry, inverse_mass, work)
            else:
                solve(CROSS, 1, block, motion, geometry, inverse_mass, work)


@kernel
def cross_address(arguments):
    """Address of the code that visits blocks of cross parts."""
    return address_call(_cross, arguments)[0]


@routine
def _coupling(arguments, mode, first, stop):
    motion, geometry, inverse_mass, _, work = arguments
    for block in range(first, stop):
        if work.integers[block, ANY, 0]:
            if mode == START:
                start(COUPLING, block, motion, geometry, inverse_mass, work)
            elif mode == SOLVE:
                solve(COUPLING, 0, block, motion, geometry, inverse_mass, work)
            else:
                solve(COUPLING, 1, block, motion, geometry, inverse_mass, work)


@kernel
def coupling_address(arguments):
    """Address of the code that visits blocks of coupling parts."""
    return address_call(_coupling, arguments)[0]


@routine
def _pulley(arguments, mode, first, stop):
    motion, geometry, inverse_mass, _, work = arguments
    for block in range(first, stop):
        if work.integers[block, ANY, 0]:
            if mode == START:
                start(PULLEY, block, motion, geometry, inverse_mass, work)
            elif mode == SOLVE:
                solve(PULLEY, 0, block, motion, geometry, inverse_mass, work)
            else:
                solve(PULLEY, 1, block, motion, geometry, inverse_mass, work)


@kernel
def pulley_address(arguments):
    """Address of the code that visits blocks of pulley parts."""
    return address_call(_pulley, arguments)[0]


@routine
def _translation(arguments, mode, first, stop):
    motion, geometry, inverse_mass, _, work = arguments
    for block in range(first, stop):
        if work.integers[block, ANY, 0]:
            if mode == START:
                start(TRANSLATION, block, motion, geometry, inverse_mass, work)
            elif mode == SOLVE:
                solve(TRANSLATION, 0, block, motion, geometry, inverse_mass, work)
            else:
                solve(TRANSLATION, 1, block, motion, geometry, inverse_mass, work)


@kernel
def translation_address(arguments):
    """Address of the code that visits blocks of translation parts."""
    return address_call(_translation, arguments)[0]


@routine
def _distance(arguments, mode, first, stop):
    motion, geometry, inverse_mass, _, work = arguments
    for block in range(first, stop):
        if work.integers[block, ANY, 0]:
            if mode == START:
                start(DISTANCE, block, motion, geometry, inverse_mass, work)
            elif mode == SOLVE:
                solve(DISTANCE, 0, block, motion, geometry, inverse_mass, work)
            else:
                solve(DISTANCE, 1, block, motion, geometry, inverse_mass, work)


@kernel
def distance_address(arguments):
    """Address of the code that visits blocks of distance parts."""
    return address_call(_distance, arguments)[0]


@routine
def _axis(arguments, mode, first, stop):
    motion, geometry, inverse_mass, _, work = arguments
    for block in range(first, stop):
        if work.integers[block, ANY, 0]:
            if mode == START:
                start(AXIS, block, motion, geometry, inverse_mass, work)
            elif mode == SOLVE:
                solve(AXIS, 0, block, motion, geometry, inverse_mass, work)
            else:
                solve(AXIS, 1, block, motion, geometry, inverse_mass, work)


@kernel
def axis_address(arguments):
    """Address of the code that visits blocks of axis parts."""
    return address_call(_axis, arguments)[0]


@routine
def _lock(arguments, mode, first, stop):
    motion, geometry, inverse_mass, _, work = arguments
    for block in range(first, stop):
        if work.integers[block, ANY, 0]:
            if mode == START:
                start(LOCK, block, motion, geometry, inverse_mass, work)
            elif mode == SOLVE:
                solve(LOCK, 0, block, motion, geometry, inverse_mass, work)
            else:
                solve(LOCK, 1, block, motion, geometry, inverse_mass, work)


@kernel
def lock_address(arguments):
    """Address of the code that visits blocks of lock parts."""
    return address_call(_lock, arguments)[0]


@routine
def _line(arguments, mode, first, stop):
    motion, geometry, inverse_mass, _, work = arguments
    for block in range(first, stop):
        if work.integers[block, ANY, 0]:
            if mode == START:
                start(LINE, block, motion, geometry, inverse_mass, work)
            elif mode == SOLVE:
                solve(LINE, 0, block, motion, geometry, inverse_mass, work)
            else:
                solve(LINE, 1, block, motion, geometry, inverse_mass, work)


@kernel
def line_address(arguments):
    """Address of the code that visits blocks of line parts."""
    return address_call(_line, arguments)[0]


@routine
def _point(arguments, mode, first, stop):
    motion, geometry, inverse_mass, _, work = arguments
    for block in range(first, stop):
        if work.integers[block, ANY, 0]:
            if mode == START:
                start(POINT, block, motion, geometry, inverse_mass, work)
            elif mode == SOLVE:
                solve(POINT, 0, block, motion, geometry, inverse_mass, work)
            else:
                solve(POINT, 1, block, motion, geometry, inverse_mass, work)


@kernel
def point_address(arguments):
    """Address of the code that visits blocks of point parts."""
    return address_call(_point, arguments)[0]


ADDRESSES = (
    rotation_address,
    cone_address,
    cross_address,
    coupling_address,
    pulley_address,
    translation_address,
    distance_address,
    axis_address,
    lock_address,
    line_address,
    point_address,
)
"""By type. The code stays where it is as long as the process lives."""
