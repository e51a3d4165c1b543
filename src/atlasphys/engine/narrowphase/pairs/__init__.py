"""One file for each kind of pair that has a routine of its own, and one for all others."""
