"""Sphinx settings of the documentation: ``python -m sphinx -W -n docs OUT`` builds it without network."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parent / "_extensions"))

import gallery_order  # found by the line above

project = "AtlasPhys"
copyright = "AtlasPhys, MIT licence"
extensions = ["myst_parser", "mathml", "book_figures", "sphinx_gallery.gen_gallery"]
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = project
html_static_path = ["_static"]
html_css_files = ["book.css"]
html_math_renderer = "mathml"
numfig = True  # formulas are numbered by chapter
exclude_patterns = ["_build"]
suppress_warnings = ["config.cache"]  # the gallery's settings hold functions, which are not compared between builds

sphinx_gallery_conf = {
    "examples_dirs": "../examples/gallery",
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "within_subsection_order": gallery_order.place,
    "reset_modules": (gallery_order.style,),
    "run_stale_examples": True,  # the engine may have changed where the example did not
    "abort_on_example_error": True,
    "only_warn_on_example_error": False,
    "show_memory": False,
    "show_signature": False,
    "min_reported_time": 1000,
    "write_computation_times": False,
    "download_all_examples": False,
    "remove_config_comments": True,
}
