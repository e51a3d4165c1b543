"""Whole kernel bodies: arguments, both readings, other CPUs, the cache."""

import json
import os
import platform
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from atlasphys.engine.jit import kernel
from atlasphys.engine.simd import any_lane, full, instruction_set, lane_count, load, select, simd_kernel, store
from tests.engine.simd.bodies import contact_problem, restitution_impulses, solve_contacts, solve_contacts_scalar
from tests.engine.simd.report import FUSED, awkward_contacts
from tests.engine.simd.values import awkward, bits

ROOT = Path(__file__).parents[3]


class Pair(NamedTuple):
    values: np.ndarray
    shift: float


@simd_kernel
def everything(block, pair, scale, flag, count, nested, extra):
    """An argument of every kind."""
    x = load(pair.values, block)
    for k in range(count):  # a literal where it is called
        x = x * scale + k
    if extra is not None:
        x = x + load(extra, block)
    inner, (offset,) = nested
    store(inner, block + offset - offset, x + pair.shift + scale * scale)
    store(inner, block, full(x, 1) - load(inner, block) + 0 * x)
    store(inner, block, load(inner, block) + select(~flag, x, 0.5))


@simd_kernel
def has_negative(block, x) -> bool:
    return any_lane(load(x, block) < 0)


@kernel
def everything_everywhere(pair, scale, flag, nested, extra, negative):
    for block in range(pair.values.shape[0]):
        everything(block, pair, scale, flag, 3, nested, extra)
        negative[block] = has_negative(block, pair.values)


@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize("scale", [0.3, np.float32(0.3), np.float64(0.3)])
@pytest.mark.parametrize("flag", [True, False])
def test_arguments_of_every_kind(real, scale, flag):
    x = np.random.default_rng(0).normal(size=(20, 8)).astype(real)
    x[:10] = abs(x[:10])
    for extra in (None, x + 1):
        outs = [np.zeros_like(x), np.zeros_like(x)]
        negatives = [np.zeros(20, np.bool_), np.zeros(20, np.bool_)]
        for function, out, negative in zip(
            (everything_everywhere, everything_everywhere.py_func), outs, negatives, strict=True
        ):
            function(Pair(x, 0.1), scale, flag, (out, (2,)), extra, negative)
        np.testing.assert_array_equal(*map(bits, outs))
        np.testing.assert_array_equal(*negatives)
        assert outs[0].any()
        np.testing.assert_array_equal(negatives[0], (x < 0).any(axis=1))


def test_a_mask_as_an_integer_of_eight_bits():
    @simd_kernel
    def negative(block, x) -> int:
        return load(x, block) < 0

    @kernel
    def driver(x, bits):
        for block in range(len(x)):
            bits[block] = negative(block, x)

    x = awkward(np.float32, 50, 3)
    expected = ((x < 0) << np.arange(8)).sum(axis=1)
    for function in (driver, driver.py_func):
        found = np.zeros(50, np.int64)
        function(x, found)
        np.testing.assert_array_equal(found, expected)
    assert len(set(expected)) > 20


def test_floats_take_the_narrowest_dtype_of_the_arrays():
    @simd_kernel
    def body(singles, doubles, scale):
        store(singles, 0, load(singles, 0) * scale)
        store(doubles, 0, load(doubles, 0) + (full(load(singles, 0), 0) + scale).astype(np.float64))

    @kernel
    def driver(singles, doubles, scale):
        body(singles, doubles, scale)

    for function in (driver, driver.py_func):
        singles, doubles = np.ones((1, 8), "f"), np.zeros((1, 8))
        function(singles, doubles, 0.1)
        assert (singles == np.float32(0.1)).all()
        assert (doubles == np.float64(np.float32(0.1))).all()


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_restitution_impulse(real):
    arrays = [awkward(real, 300, seed) for seed in range(5)]
    answers = [[array.copy() for array in arrays] for _ in range(2)]
    restitution_impulses(*answers[0])
    restitution_impulses.py_func(*answers[1])
    np.testing.assert_array_equal(bits(answers[0][4]), bits(answers[1][4]))
    v, mass, e, old, _ = (np.where(np.isfinite(array) & (abs(array) < 1e3), array, 1).astype("d") for array in arrays)
    change = np.zeros_like(v)
    restitution_impulses(v, abs(mass) + 1, abs(e), abs(old), change)
    expected = np.maximum(abs(old) - (1 + np.where(v < -1, abs(e), 0)) * v / (abs(mass) + 1), 0) - abs(old)
    np.testing.assert_allclose(change, expected, rtol=1e-13, atol=1e-12)


@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize("relax", [True, False])
def test_contacts(real, relax):
    """Compiled, read by NumPy, and in scalar code: three times the same bits."""
    for make in (lambda: contact_problem(30, real), lambda: awkward_contacts(real)):
        before = make()
        answers = [make() for _ in range(3)]
        for function, answer in zip(
            (solve_contacts, solve_contacts.py_func, solve_contacts_scalar), answers, strict=True
        ):
            function(*answer, relax, 2)
        for other in answers[1:]:
            for one, two in zip(answers[0], other, strict=True):
                np.testing.assert_array_equal(bits(one), bits(two))
        static = before[3][:, 7] == 0
        np.testing.assert_array_equal(bits(answers[0][2][static]), bits(before[2][static]))
        assert (bits(answers[0][2][~static]) != bits(before[2][~static])).any(axis=1).mean() > 0.9


def in_a_process(folder, **settings):
    environment = os.environ | {"ATLASPHYS_CACHE_DIR": str(folder)} | settings
    for name in [name for name in ("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES") if name not in settings]:
        environment.pop(name, None)
    command = [sys.executable, "-m", "tests.engine.simd.report"]
    answer = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert answer.returncode == 0, answer.stderr
    return json.loads(answer.stdout)


@pytest.fixture(scope="module")
def native(tmp_path_factory):
    """The report of a process with an empty cache, and the cache."""
    folder = tmp_path_factory.mktemp("native")
    return in_a_process(folder), folder


def test_vector_instructions_are_emitted_and_none_is_fused(native):
    report, _ = native
    vectors = {tuple(pair) for pair in report["vectors"]}
    assert {
        (name, kind) for name in ("fadd", "fsub", "fmul", "fdiv", "fneg") for kind in ("float", "double")
    } <= vectors
    assert report["flags"] == []
    assert report["fused"] == []
    if report["instruction_set"] in ("AVX", "AVX2", "AVX-512"):
        assert "ymm" in report["registers"] or "zmm" in report["registers"]


def test_the_search_for_fused_instructions_finds_them():
    for instruction in (
        "\tvfmadd213ps\t%ymm0, %ymm1, %ymm2",
        "\tvfnmsub132pd ",
        "\tfmla\tv0.4s, v1.4s",
        "\tfmadd d0, d1, d2",
    ):
        assert FUSED.search(instruction)
    for instruction in ("\tvmulps\t%ymm0", "\tvaddsubps", "\tfmul v0.4s", "\tvfpclassps"):
        assert not FUSED.search(instruction)


def test_a_second_process_loads_from_the_cache_and_answers_the_same(native):
    report, folder = native
    again = in_a_process(folder)
    assert report["hits"] == 0
    assert again["hits"] == 6  # three drivers, two precisions
    assert again["digests"] == report["digests"]


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="names an x86-64 target")
def test_a_generic_cpu_gives_the_same_bits(native, tmp_path):
    generic = in_a_process(tmp_path, NUMBA_CPU_NAME="generic", NUMBA_CPU_FEATURES="")
    assert generic["instruction_set"] == "SSE2"
    assert generic["registers"] == ["xmm"]
    assert generic["fused"] == []
    assert generic["digests"] == native[0]["digests"]


def test_without_compiling_the_numpy_reading_runs(native, tmp_path):
    script = (
        "import json\nfrom tests.engine.simd import report as r\nimport hashlib, numpy as np\n"
        "found = r.answers(np.float32)\n"
        "print(json.dumps({n: hashlib.sha256(b''.join(r.bits(a).tobytes() for a in v)).hexdigest() for n, v in found.items()}))"
    )
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    answer = subprocess.run([sys.executable, "-c", script], cwd=ROOT, env=environment, capture_output=True, text=True)
    assert answer.returncode == 0, answer.stderr
    for name, digest in json.loads(answer.stdout).items():
        assert digest == native[0]["digests"][f"{name} float32"]


def test_what_a_body_may_not_be():
    with pytest.raises(TypeError, match="positional arguments only"):
        simd_kernel(lambda block, *rest: None)
    x = np.ones((1, 8))

    @simd_kernel
    def returns_lanes(x):
        return load(x, 0)

    @simd_kernel
    def returns_mask(x) -> bool:
        return load(x, 0) > 0

    @simd_kernel
    def returns_number(x) -> int:
        return load(x, 0)

    @simd_kernel
    def takes_text(x, text):
        pass

    @simd_kernel
    def branches(x, block):
        if block == 0:
            store(x, block, 1)

    @kernel
    def fourth(x):
        for block in range(x.shape[0]):
            branches(x, block)

    @kernel
    def first(x):
        returns_lanes(x)

    @kernel
    def second(x):
        return returns_mask(x)

    @kernel
    def third(x):
        takes_text(x, "text")

    @kernel
    def fifth(x):
        return returns_number(x)

    for driver, message in (
        (fifth, "must return a mask"),
        (first, "annotate it -> bool"),
        (second, "must return any_lane"),
        (third, "cannot take an argument"),
        (fourth, "branch on it in the driver"),
    ):
        with pytest.raises(TypeError, match=message):
            driver(x)


def test_what_doctor_shows():
    assert lane_count() == 8
    assert instruction_set() in ("AVX-512", "AVX2", "AVX", "SSE4.1", "SSE2", "NEON")
