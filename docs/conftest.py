"""Doctests of the documentation are those of its pages; what Sphinx runs needs Sphinx and Matplotlib, which may be missing."""

collect_ignore = ["_extensions", "gallery", "theory/plots"]
