"""Doctests of the documentation are those of its pages; Sphinx's extensions need Sphinx, which may be missing."""

collect_ignore = ["_extensions"]
