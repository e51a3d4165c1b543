"""The tables that hold everything a world remembers, as NamedTuples of arrays."""
