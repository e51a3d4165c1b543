"""Settings of all tests."""

from hypothesis import settings

# The same examples in every run, and no time limit for one: the machine may be busy and the first call compiles.
settings.register_profile("atlasphys", derandomize=True, deadline=None, database=None)
settings.load_profile("atlasphys")
