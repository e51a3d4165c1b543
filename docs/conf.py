"""Sphinx settings of the documentation: ``python -m sphinx -W -n docs OUT`` builds it without network."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parent / "_extensions"))

project = "AtlasPhys"
copyright = "AtlasPhys, MIT licence"
extensions = ["myst_parser", "mathml"]
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = project
html_static_path = ["_static"]
html_css_files = ["book.css"]
html_math_renderer = "mathml"
numfig = True  # formulas are numbered by chapter
exclude_patterns = ["_build"]
