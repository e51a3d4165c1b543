"""The command ``atlasphys``: one file a command. What is heavy to import is imported when a command needs it."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from cyclopts import App, CycloptsError

from atlasphys import __version__
from atlasphys.cli.bench import bench
from atlasphys.cli.compare import compare
from atlasphys.cli.doctor import doctor
from atlasphys.cli.explain import explain
from atlasphys.cli.render import render
from atlasphys.cli.run import run
from atlasphys.cli.scenes import scenes
from atlasphys.cli.validate import validate
from atlasphys.cli.view import view
from atlasphys.cli.warmup import warmup
from atlasphys.errors import AtlasPhysError, InvalidArgumentError, SceneError

USAGE_ERROR, RUN_ERROR, INTERRUPTED = 2, 1, 130
"""Exit codes: what was asked for makes no sense; it went wrong on the way; it was stopped by Ctrl-C."""

app = App(name="atlasphys", help="Rigid-body physics that can be read stage by stage.", version=__version__)
for command in (run, view, render, scenes, explain, validate, compare, warmup, bench, doctor):
    app.command(command)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        arguments: the words after ``atlasphys``. Default: those that the process was given.

    Returns:
        The exit code. Errors are said in a line each on standard error.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        code = app(words, print_error=False, exit_on_error=False, result_action="return_value")
        sys.stdout.flush()
    except (CycloptsError, SceneError, InvalidArgumentError) as error:
        return _fail(error, USAGE_ERROR)
    except AtlasPhysError as error:
        return _fail(error, RUN_ERROR)
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:  # the reader of our output went away; what Python would still write must go nowhere
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return RUN_ERROR
    return code if isinstance(code, int) else 0


def _fail(error: Exception, code: int) -> int:
    for line in str(error).strip().splitlines():
        print(f"atlasphys: {line}", file=sys.stderr)
    return code
