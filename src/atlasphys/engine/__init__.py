"""The physics: NumPy and Numba only. README.md beside this file is the map, in the order in which a step runs."""
