"""Towers on soft contacts buckle like columns: at N³ = 7.837 / 8 · ω² a / g cubes of side a (docs/soft_step.md)."""

import math

import pytest

import atlasphys as ap
from tests.engine.solvers.test_stacks_stand import lean

G = 9.81


def critical_height(frequency: float, g: float, size: float) -> float:
    """Greenhill's column, of bending stiffness κ = m ω² a² / 8 a joint and weight m g a cube."""
    greenhill = 7.837
    return (greenhill / 8 * (2 * math.pi * frequency) ** 2 * size / g) ** (1 / 3)


def fresh_tower(count: int, frequency: float, g: float, size: float) -> ap.World:
    substeps = max(4, round(frequency / 7.5))
    settings = ap.SoftStep(contact_recycling=False, contact_frequency=frequency, substeps=substeps)
    world = ap.World(preset="default", solver=settings, gravity=(0, -g, 0), sleeping=False, length_unit=size)
    world.add(ap.Plane())
    for level in range(count):
        world.add(ap.Box(size=(size, size, size)), position=(0, (level + 0.5) * size, 0))
    return world


@pytest.mark.parametrize(
    ("frequency", "g", "size"),
    [(30.0, G, 1.0), (30.0, 10 * G, 1.0), (30.0, G / 8, 1.0), (60.0, G, 1.0), (60.0, G, 0.25), (30.0, G, 4.0)],
)
def test_towers_stand_below_the_critical_height_and_lean_above(frequency, g, size):
    height, seconds = critical_height(frequency, g, size), 20 * math.sqrt(size * G / g)
    assert lean(fresh_tower(math.floor(0.95 * height), frequency, g, size), seconds)[0] < 0.01 * size
    assert lean(fresh_tower(math.ceil(1.15 * height), frequency, g, size), seconds)[0] > 0.1 * size


def test_the_lean_grows_like_that_of_a_column_above_its_critical_height():
    """σ² ≈ 3 g / (2 L) (1 − (N_c / N)³): a rod that falls over, less what the joints hold."""
    count, frequency = 20, 30.0
    world = fresh_tower(count, frequency, G, 1.0)
    early, late = lean(world, 4, 3)
    rate = math.log(late / early) / 3
    expected = math.sqrt(1.5 * G / count * (1 - (critical_height(frequency, G, 1.0) / count) ** 3))
    assert rate == pytest.approx(expected, rel=0.2)


def test_recycling_holds_up_what_buckles():
    world = ap.World(preset="default", sleeping=False)
    world.add(ap.Plane())
    for level in range(2 * round(critical_height(34.0, G, 1.0))):
        world.add(ap.Box(size=(1, 1, 1)), position=(0, level + 0.5, 0))
    assert lean(world, 20)[0] < 0.02
