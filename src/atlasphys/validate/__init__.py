"""Physical validation: cases with known answers. ``CASES`` is the table, one file each in ``cases/``.

>>> from atlasphys.validate import CASES
>>> CASES[3].law
'd = v²/(2 μ g), t = v/(μ g)'
"""

from atlasphys.validate.case import Case, Curve, MakeWorld, NotOfferedError, Result
from atlasphys.validate.cases import (
    bouncing_ball,
    cards,
    conservation,
    corner_on_face,
    cradle,
    domino_wave,
    double_pendulum,
    four_bar,
    free_fall,
    free_precession,
    hanging_chain,
    heavy_on_light,
    incline,
    intermediate_axis,
    isotropic_friction,
    oblique_bounce,
    order,
    overhang,
    painleve,
    pendulum,
    pyramid,
    repose,
    rolling,
    sliding_ball,
    sliding_block,
    spring_damper,
    stack_force,
    thin_wall,
    tipping,
    top,
    torsion,
    towers,
)

__all__ = ["CASES", "Case", "Curve", "MakeWorld", "NotOfferedError", "Result"]

CASES: dict[int, Case] = {
    module.CASE.number: module.CASE
    for module in (
        free_fall,
        incline,
        sliding_block,
        isotropic_friction,
        bouncing_ball,
        oblique_bounce,
        rolling,
        sliding_ball,
        tipping,
        intermediate_axis,
        free_precession,
        top,
        pendulum,
        double_pendulum,
        spring_damper,
        corner_on_face,
        cradle,
        torsion,
        stack_force,
        heavy_on_light,
        towers,
        pyramid,
        hanging_chain,
        four_bar,
        overhang,
        cards,
        domino_wave,
        conservation,
        thin_wall,
        painleve,
        repose,
        order,
    )
}
"""Number in docs/validation.md → case."""
