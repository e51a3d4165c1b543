"""Scenes: read from files, made by name, checked, built into worlds, saved."""

from atlasphys.scene.load import load_scene
from atlasphys.scene.scene import Scene

__all__ = ["Scene", "load_scene"]
