"""The documentation builds without a warning and without network; its examples run, and its links lead somewhere."""

import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples" / "gallery").glob("*.py"))


class Page(HTMLParser):
    """The links of a page, what it loads, and the names that links may lead to."""

    def __init__(self, path):
        super().__init__()
        self.links, self.loads, self.names = [], [], set()
        self.feed(path.read_text("utf-8"))

    def handle_starttag(self, tag, attributes):
        values = {key: value for key, value in attributes if value}
        self.names |= {values[key] for key in ("id", "name") if key in values}
        if tag == "a" and "href" in values:
            self.links.append(values["href"])
        if tag in ("script", "img", "iframe") and "src" in values:
            self.loads.append(values["src"])
        if tag == "link" and "stylesheet" in values.get("rel", "") and "href" in values:
            self.loads.append(values["href"])


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    for name in ("sphinx", "furo", "myst_parser", "math_core", "sphinx_gallery", "matplotlib"):
        pytest.importorskip(name, reason="the documentation needs: pip install 'atlasphys[docs]'")
    out = tmp_path_factory.mktemp("docs")
    command = [sys.executable, "-m", "sphinx", "-W", "-n", "-q", "-d", out / "trees", "docs", out / "site"]
    built = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=900, check=False)
    assert built.returncode == 0, built.stderr
    return out / "site"


@pytest.fixture(scope="module")
def pages(site):
    return {path: Page(path) for path in site.rglob("*.html")}


def test_links_lead_to_what_is_there(site, pages):
    broken = []
    for path, page in pages.items():
        for link in page.links + page.loads:
            target = urlsplit(link)
            if target.scheme or target.netloc:
                continue
            file = (path.parent / unquote(target.path)).resolve() if target.path else path
            there = file.is_file()
            if there and target.fragment and file in pages:
                there = unquote(target.fragment) in pages[file].names
            if not there:
                broken.append(f"{path.relative_to(site)}: {link}")
    assert sum(len(page.links) for page in pages.values()) > 1000
    assert not broken


def test_pages_load_nothing_from_elsewhere(pages):
    # Links may leave the site; what a page loads may not.
    loads = {load for page in pages.values() for load in page.loads}
    assert loads
    assert not [load for load in loads if re.match(r"(https?:)?//", load)]


def test_mathematics_is_shown(site):
    assert (site / "theory" / "friction.html").read_text("utf-8").count("<math") > 40


def test_every_example_has_a_page_with_a_figure(site, pages):
    assert len(EXAMPLES) >= 12
    for example in EXAMPLES:
        page = pages[site / "gallery" / f"{example.stem}.html"]
        assert [load for load in page.loads if "sphx_glr_" in load], example.stem


def test_the_book_shows_every_figure_that_is_drawn(site, pages):
    drawn = {path.name for path in (ROOT / "docs" / "theory" / "figures").glob("*.svg")}
    shown = {Path(load).name for path, page in pages.items() if path.parent.name == "theory" for load in page.loads}
    assert len(drawn) > 12
    assert drawn <= shown
