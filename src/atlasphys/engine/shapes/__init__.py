"""Solids: what the user gives, their mass properties, and the table and routines by which kernels read them."""
