"""Recordings: the poses of all bodies at every step, in a file."""

from atlasphys.record.read import Poses, Recording, Trajectory
from atlasphys.record.write import Recorder

__all__ = ["Poses", "Recorder", "Recording", "Trajectory"]
