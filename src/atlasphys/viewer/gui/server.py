"""The server of a page."""

from __future__ import annotations

import contextlib
import io
import socket
import sys
from typing import Any

from atlasphys.errors import InvalidArgumentError, MissingExtraError

HOST = "127.0.0.1"
"""A page has no login, so it is served to this machine only."""

FIRST_PORT = 8080


def address(server: Any) -> str:
    """Where a server's page is."""
    return f"http://{HOST}:{server.get_port()}"


def stop(server: Any) -> None:
    """Stop serving."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


def serve(port: int | None) -> Any:
    """A viser server on this machine.

    Args:
        port: port to be served at; None: 8080, or the next that is free; 0: any.

    Raises:
        MissingExtraError: viser is not installed.
        InvalidArgumentError: the port is in use.
    """
    try:
        import viser
    except ImportError:
        raise MissingExtraError("the viewer needs the package viser: pip install 'atlasphys[viewer]'") from None
    if port:
        _refuse_busy(port)
    with _silence():  # its banner
        server = viser.ViserServer(
            host=HOST, port=FIRST_PORT if port is None else port, label="AtlasPhys", verbose=False
        )
    if port and server.get_port() != port:
        server.stop()
        raise _busy(port)
    return server


def _silence() -> contextlib.AbstractContextManager[Any]:
    """Let nothing be printed, nor displayed in a notebook, past which ``sys.stdout`` goes."""
    if "IPython" in sys.modules:
        from IPython.utils.capture import capture_output

        return capture_output()  # type: ignore[no-any-return]
    return contextlib.redirect_stdout(io.StringIO())


def _refuse_busy(port: int) -> None:
    if not 0 <= port <= 65535:
        raise InvalidArgumentError(f"port must be a number from 0 to 65535 (got {port})")
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((HOST, port))
        except OSError:
            raise _busy(port) from None


def _busy(port: int) -> InvalidArgumentError:
    return InvalidArgumentError(
        f"port {port} cannot be used, perhaps another viewer does; give another, or 0 for any that is free"
    )
