"""The cases, one law a file."""
