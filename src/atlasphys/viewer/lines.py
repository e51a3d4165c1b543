"""Lines over a finished picture: joints, which bodies would hide."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from atlasphys.viewer.viewpoint import Viewpoint

Floats = npt.NDArray[np.float64]

NEAR = 0.01
"""Lines are cut off this near to the camera, in distances to what it looks at."""


def projected(segments: Floats, viewpoint: Viewpoint, size: tuple[int, int]) -> Floats:
    """(m, 2, 2) where the visible parts of segments (k, 2, 3) are in a picture [pixels], from its lower left corner.

    Args:
        segments: starts and ends in the world [m].
        viewpoint: where the picture is taken from, upright.
        size: width and height of the picture [pixels].
    """
    arm = viewpoint.look_at - viewpoint.position
    distance = float(np.sqrt((arm**2).sum()))
    ahead = arm / distance
    up = (0.0, 0.0, -1.0) if abs(arm[1]) > 0.999 * distance else (0.0, 1.0, 0.0)
    right = np.cross(ahead, up)
    right /= np.sqrt((right**2).sum())
    seen = (segments - viewpoint.position) @ np.stack([right, np.cross(right, ahead), ahead], axis=1)
    near = NEAR * distance
    depth = seen[:, :, 2]
    seen, depth = seen[(depth > near).any(axis=1)], depth[(depth > near).any(axis=1)]
    for end in (0, 1):  # a point behind moves along its segment to where that comes into sight
        behind = np.flatnonzero(depth[:, end] < near)
        share = (near - depth[behind, end]) / (depth[behind, 1 - end] - depth[behind, end])
        seen[behind, end] += share[:, None] * (seen[behind, 1 - end] - seen[behind, end])
    scale = 0.5 * size[1] / math.tan(math.radians(viewpoint.field_of_view) / 2)
    far = distance if viewpoint.orthographic else seen[:, :, 2:]
    points: Floats = scale * seen[:, :, :2] / far + 0.5 * np.array(size)
    return points


def draw_lines(
    picture: npt.NDArray[np.uint8], layers: list[tuple[Floats, tuple[int, int, int]]], viewpoint: Viewpoint
) -> npt.NDArray[np.uint8]:
    """A picture with lines drawn on it, the last ones on top.

    Args:
        picture: (height, width, 3), its lowest row first.
        layers: segments (k, 2, 3) [m] and the colour of each layer.
        viewpoint: where the picture is taken from.
    """
    from PIL import Image, ImageDraw

    height, width = picture.shape[:2]
    image: Any = Image.fromarray(picture)
    draw = ImageDraw.Draw(image)
    thickness = max(1, round(height / 360))
    for segments, colour in layers:
        points = np.clip(projected(segments, viewpoint, (width, height)), -4 * width, 5 * width)
        for line in points.reshape(-1, 4).tolist():
            draw.line(line, fill=colour, width=thickness)
    return np.asarray(image)
