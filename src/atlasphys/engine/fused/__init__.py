"""The step of the default world, its stages fused in one compiled call. ``steps.py`` has its order."""
