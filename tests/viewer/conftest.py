"""A headless browser, one for all tests, and pages to drive with it."""

import shutil
import warnings

import pytest

FLAGS = [
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
]


def chromium():
    """The browser of the system, or None."""
    return shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    """A running browser."""
    api = pytest.importorskip(
        "playwright.sync_api", reason="playwright is not installed: pip install 'atlasphys[test]'"
    )
    pytest.importorskip("viser", reason="viser is not installed: pip install 'atlasphys[viewer]'")
    program = chromium()
    if program is None:
        pytest.skip("Chromium is not installed: apt-get install chromium")
    with api.sync_playwright() as driver:
        context = driver.chromium.launch_persistent_context(
            tmp_path_factory.mktemp("profile"),
            executable_path=program,
            args=FLAGS,
            headless=True,
            viewport={"width": 1240, "height": 540},
        )
        context.set_default_timeout(10_000)
        yield context
        context.close()


@pytest.fixture(autouse=True)
def _quiet_sockets():
    """A browser that goes away leaves sockets that the server closes a little later."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)
        yield
