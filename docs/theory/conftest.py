"""Doctests of the book are those of its chapters; Sphinx's extensions need Sphinx, which may be missing."""

collect_ignore = ["_extensions"]
