"""Run in a process of its own: what the compiled kernels answer and consist of, as JSON."""

import hashlib
import json
import re

import numpy as np

from atlasphys.engine.simd import instruction_set
from tests.engine.simd.bodies import contact_problem, restitution_impulses, solve_contacts
from tests.engine.simd.test_lanes import FLOATS, run_floats
from tests.engine.simd.values import awkward, bits

FUSED = re.compile(r"\bvfn?m(?:add|sub)\w*|\bfml[as]\b|\bfn?m(?:add|sub)\b")
"""Fused multiply-add instructions of x86-64 and of Arm."""


def awkward_contacts(real):
    """The contact problem with special numbers among its contacts and velocities."""
    contacts, bodies, motions, constants = contact_problem(30, real)
    contacts[10:] = np.where(np.arange(20) % 5 == 0, awkward(real, 20 * 20, 5).reshape(20, 8, 20), 1).swapaxes(1, 2)
    motions[60:, :6] = awkward(real, 60, 6)[:, :6]
    return contacts, bodies, motions, constants


def answers(real):
    """Arguments of each driver by its name, after the call."""
    problem = (*awkward_contacts(real), False, 2)
    solve_contacts(*problem)
    impulses = tuple(awkward(real, 50, seed) for seed in range(5))
    restitution_impulses(*impulses)
    floats = (awkward(real, 100, 1), awkward(real, 100, 2), np.zeros((100, len(FLOATS), 8), real))
    run_floats(*floats)
    return {"contacts": problem[:4], "restitution": impulses, "floats": floats}


def report():
    digests = {
        f"{name} {np.dtype(real)}": hashlib.sha256(b"".join(bits(array).tobytes() for array in arrays)).hexdigest()
        for real in (np.float32, np.float64)
        for name, arrays in answers(real).items()
    }
    drivers = (solve_contacts, restitution_impulses, run_floats)
    hits = sum(sum(driver.stats.cache_hits.values()) for driver in drivers)
    found = {"digests": digests, "hits": hits, "instruction_set": instruction_set()}
    if not hits:  # code from the cache has no listing
        code = "".join(text for driver in drivers for text in driver.inspect_llvm().values())
        assembly = "".join(text for driver in drivers for text in driver.inspect_asm().values())
        found["vectors"] = sorted(set(re.findall(r"= (f\w+) <8 x (float|double)>", code)))
        found["flags"] = re.findall(r"= f\w+ (?:fast|nnan|ninf|nsz|arcp|contract|afn|reassoc)\b", code)
        found["fused"] = FUSED.findall(assembly)
        found["registers"] = sorted(set(re.findall(r"\b[xyz]mm(?=\d)", assembly)))
    return found


if __name__ == "__main__":
    print(json.dumps(report()))
