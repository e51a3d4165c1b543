"""The architecture: who may import whom, what the map says, what the public names are."""

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import atlasphys as ap
from atlasphys.engine.step import STAGES

ROOT = Path(__file__).parents[2]
PACKAGE = Path(ap.__file__).parent
ENGINE = PACKAGE / "engine"


def imports(path):
    """The modules that a file imports, anywhere in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module


def test_import_contracts_hold():
    pytest.importorskip("importlinter")
    answer = subprocess.run(
        [sys.executable, "-c", "import sys; from importlinter.cli import lint_imports; sys.exit(lint_imports())"],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": str(PACKAGE.parent)},
        capture_output=True,
        text=True,
    )
    assert answer.returncode == 0, answer.stdout + answer.stderr
    assert "0 broken" in answer.stdout


def importers(package):
    """The folders or files, below the package, that import another package."""
    found = {path for path in PACKAGE.rglob("*.py") if package in {name.split(".")[0] for name in imports(path)}}
    simd = ENGINE / "simd"
    return {(simd if path.is_relative_to(simd) else path).relative_to(PACKAGE).as_posix() for path in found}


def test_only_the_jit_layer_imports_numba():
    assert importers("numba") == {"engine/jit.py", "engine/simd"}
    assert importers("llvmlite") == {"engine/simd"}


def test_the_engine_needs_numpy_and_numba_only():
    allowed = {"atlasphys", "numpy", "numba", "llvmlite", "platformdirs"} | set(sys.stdlib_module_names)
    for path in ENGINE.rglob("*.py"):
        names = {name.split(".")[0] for name in imports(path)}
        extra = {"scipy"} if path.name == "hull.py" else set()
        assert names <= allowed | extra, path


def test_the_step_calls_its_stages_in_order():
    source = (ENGINE / "step.py").read_text(encoding="utf-8")
    called = re.findall(r'profile\.stage\("(\w+)"\)', source)
    assert called == [stage for stage in STAGES if stage in called]
    assert {"broadphase", "narrowphase", "manifold", "solver", "finish"} <= set(called)


def test_the_map_follows_the_step():
    text = (ENGINE / "README.md").read_text(encoding="utf-8")
    headings = re.findall(r"^## (\d+)\. (\w+)", text, re.MULTILINE)
    assert headings == [(str(i), stage) for i, stage in enumerate(STAGES, 1)]
    mentioned = set(re.findall(r"`([\w/]+(?:/|\.py))`", text))
    assert len(mentioned) >= 5
    assert [path for path in mentioned if not (ENGINE / path).exists() and not (ROOT / path).exists()] == []
    folders = {path.name for path in ENGINE.iterdir() if path.is_dir() and path.name != "__pycache__"}
    assert [name for name in folders if f"{name}/" not in text] == []


def test_importing_the_package_loads_nothing_heavy():
    code = (
        "import sys, atlasphys\n"
        "print([name for name in ('numpy', 'numba', 'scipy', 'pydantic', 'h5py', 'rich') if name in sys.modules])"
    )
    environment = os.environ | {"PYTHONPATH": str(PACKAGE.parent)}
    answer = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"


@pytest.mark.parametrize("name", sorted(set(ap.__all__) - {"__version__"}))
def test_public_names_resolve_and_are_documented(name):
    value = getattr(ap, name)
    assert value.__name__ == name
    assert len(value.__doc__ or "") > 20
    assert name in dir(ap)
    for attribute, member in vars(value).items() if isinstance(value, type) else ():
        if not attribute.startswith("_") and (callable(member) or isinstance(member, property)):
            assert (getattr(member, "__doc__", None) or "").strip(), f"{name}.{attribute}"


def test_public_names_are_listed_once():
    assert len(set(ap.__all__)) == len(ap.__all__)
    with pytest.raises(AttributeError, match="no attribute 'Ellipsoid'"):
        _ = ap.Ellipsoid


def test_errors_form_one_tree():
    errors = [getattr(ap, name) for name in ap.__all__ if name.endswith("Error")]
    assert len(errors) >= 6
    assert all(issubclass(error, ap.AtlasPhysError) for error in errors)


def test_modules_are_documented_and_of_readable_length():
    for path in PACKAGE.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        if text.strip():
            assert ast.get_docstring(ast.parse(text)), path
        assert text.count("\n") <= 700, path
