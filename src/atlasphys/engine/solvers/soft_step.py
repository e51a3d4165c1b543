"""Soft steps: small substeps, soft contacts, and a rigid pass that takes back the speed which pushing out gave.

Each step is cut into substeps of length h. In each: velocities gain what forces give them; last substep's impulses are applied (warm starting);
every contact is visited once as a damped spring of frequency ω and damping ratio ζ; bodies move; and every contact is visited once more as a
rigid one without pushing (relaxing). Many short steps with one sweep each converge better than one long step with many sweeps (M. Macklin et
al., "Small Steps in Physics Simulation", 2019), and soft contacts remove overlap without overshoot (E. Catto, "Soft Constraints", GDC 2011;
"Solver2D", 2024). Bodies of the two visits are in ``soft_contact.py``, those of the motion in ``body_block.py``.
"""

import math
from dataclasses import dataclass

from atlasphys.engine.shapes.arguments import invalid, number

MOST_SUBSTEPS = 1000

MOST_JOINT_FREQUENCY = 0.5
"""Greatest frequency of joints, as a share of the number of substeps a second. A net of 100 × 100 balls tears itself apart there."""

JOINT_FREQUENCY = 0.35
"""The same share where no frequency is given. Errors under load fall as the square of a substep; at 0.38 a
hundredfold weight on a chain of twenty trembles."""


@dataclass(frozen=True, slots=True)
class SoftStep:
    """Settings of the solver ``soft_step``.

    Attributes:
        substeps: substeps a step. More: stiffer contacts and smaller errors, in proportion slower.
        contact_frequency: stiffness of contacts as the frequency of a spring [Hz]; at most 0.15 of the number of substeps a second is used.
            0: 34 Hz at 240 substeps a second, and in proportion to their number; so overlap under load falls as the square of a substep.
            Smaller: softer contacts, and impacts that are spread over more steps.
        contact_damping: damping ratio of that spring. Smaller: overlaps are pushed out faster, and overshoot below 1.
        push_out_speed: greatest speed at which overlap is pushed out [m/s], for a length unit of 1 m.
        joint_frequency: stiffness of joints as the frequency of a spring [Hz]; at most half of the number of substeps a second is used.
            0: 84 Hz at 240 substeps a second, and in proportion to their number; so errors under load fall as the square of a substep.
            Larger: joints stretch less; large nets under heavy loads tear.
        joint_damping: damping ratio of that spring. Smaller: errors are taken back faster.
        joint_push_out_speed: greatest speed at which errors of joints are taken back [m/s, rad/s], for a length unit of 1 m. Smaller: bodies
            that are far apart come together more gently, and large nets in fast motion stretch more.
        joint_sweeps: passes over the joints in a substep. More: chains and nets stretch less.
        warm_starting: start from the impulses of the last substep. Without it stacks sag.
        contact_recycling: keep the contact points of pairs that have barely moved since they were last collided (docs/soft_step.md). Tall stacks
            stand only with it; without it every pair is collided in every step and angular momentum is exact.
        recycle_slip: how far the two bodies' copies of a recycled contact point may part along the surface [m], for a length unit of 1 m.
            Larger: what slides over an edge is held up.
        recycle_speed: how fast the two may come together or part there [m/s], for a length unit of 1 m. Larger: impacts lose or gain angular
            momentum.
        recycle_turn: angle by which either body may have turned since [rad]. Larger: tall stacks survive harder blows. Smaller: what tips
            over together with what it stands on does so less late.
        recycle_twist: angle by which the two may have turned against each other [rad]. Larger: bodies that tip over are held up. Smaller:
            piles do not come to rest.

    Raises:
        InvalidArgumentError: a value is not of the right kind or out of range.
    """

    substeps: int = 4
    contact_frequency: float = 0.0
    contact_damping: float = 10.0
    push_out_speed: float = 3.0
    joint_frequency: float = 0.0
    joint_damping: float = 7.0
    joint_push_out_speed: float = 20.0
    joint_sweeps: int = 2
    warm_starting: bool = True
    contact_recycling: bool = True
    recycle_slip: float = 0.02
    recycle_speed: float = 0.2
    recycle_turn: float = math.radians(1.5)
    recycle_twist: float = math.radians(1)

    def __post_init__(self) -> None:
        if type(self.substeps) is not int or not 1 <= self.substeps <= MOST_SUBSTEPS:
            raise invalid("substeps", f"an integer from 1 to {MOST_SUBSTEPS}", self.substeps)
        if type(self.joint_sweeps) is not int or not 1 <= self.joint_sweeps <= 100:
            raise invalid("joint_sweeps", "an integer from 1 to 100", self.joint_sweeps)
        for name, least, most in (
            ("contact_damping", 0.0, 1e3),
            ("push_out_speed", 0.0, 1e6),
            ("joint_damping", 0.0, 1e3),
            ("joint_push_out_speed", 0.0, 1e6),
            ("recycle_slip", 0.0, 1.0),
            ("recycle_speed", 0.0, 1e6),
            ("recycle_turn", 0.0, 0.5),
            ("recycle_twist", 0.0, 0.5),
        ):
            if not least <= number(name, getattr(self, name)) <= most:
                raise invalid(name, f"a number from {least:g} to {most:g}", getattr(self, name))
        for name in ("contact_frequency", "joint_frequency"):
            frequency = getattr(self, name)
            if number(name, frequency) != 0 and not 0.01 <= frequency <= 1e5:
                raise invalid(name, "0 or a number from 0.01 to 100000", frequency)
        for name in ("warm_starting", "contact_recycling"):
            if type(getattr(self, name)) is not bool:
                raise invalid(name, "True or False", getattr(self, name))


def softness(frequency: float, damping: float, h: float) -> tuple[float, float]:
    """Rate [1/s] and mass scale of a soft contact integrated implicitly with step h (Catto 2011); the impulse scale is 1 minus the latter."""
    omega = 2 * math.pi * frequency
    a = 2 * damping + h * omega
    b = h * omega * a
    return omega / a, b / (1 + b)


def joint_softness(settings: SoftStep, h: float) -> tuple[float, float]:
    """The same of the joints."""
    share = min(settings.joint_frequency * h, MOST_JOINT_FREQUENCY) or JOINT_FREQUENCY
    return softness(share / h, settings.joint_damping, h)
