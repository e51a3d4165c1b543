"""Vectors, quaternions, matrices, transforms and boxes as tuples of scalars, for use inside kernels."""
