"""Shadows of pictures: the bodies once more, as the sun sees them."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from atlasphys.viewer.shading import cast_shadows

DIRECTION = np.array((-0.45, 1.0, 0.7))
"""Direction to the sun."""

DARKNESS = 0.42
"""Share of brightness that the shadow takes from a surface that faces the sun."""

MARGIN = 1.5
"""What is out of the picture by up to half of its width may cast shadows into it."""

Floats = npt.NDArray[np.float64]


class Sun:
    """Casts shadows on all that is in a picture.

    Args:
        window: the window of the picture; the sun's map is drawn in it, too, and has its size.
    """

    def __init__(self, window: Any) -> None:
        from vtkmodules.vtkRenderingCore import vtkRenderer

        self._window = window
        self._renderer = vtkRenderer()
        self._renderer.SetAutomaticLightCreation(False)
        self._renderer.GetActiveCamera().SetParallelProjection(True)
        self._renderer.DrawOff()
        window.AddRenderer(self._renderer)
        toward = DIRECTION / np.sqrt((DIRECTION**2).sum())
        right = np.cross((0.0, 1.0, 0.0), toward)
        right /= np.sqrt((right**2).sum())
        self._axes = np.array([right, np.cross(toward, right), toward])
        """Along the map's width and height, and towards the sun."""

    def add(self, mapper: Any) -> None:
        """Let what a mapper draws cast shadows."""
        from vtkmodules.vtkRenderingCore import vtkActor

        actor = vtkActor()
        actor.SetMapper(mapper)
        actor.GetProperty().SetLighting(False)
        self._renderer.AddActor(actor)

    def shade(self, picture: npt.NDArray[np.uint8], renderer: Any, centres: Floats, width: float) -> None:
        """Darken a picture that was just drawn, where the sun does not reach.

        Args:
            picture: (h, w, 3), changed.
            renderer: what drew it.
            centres: (n, 3) of the bodies that may cast shadows [m].
            width: of the largest of them [m].
        """
        rows, columns = picture.shape[:2]
        to_screen = _matrix(renderer.GetActiveCamera().GetCompositeProjectionTransformMatrix(columns / rows, -1.0, 1.0))
        homogeneous = centres @ to_screen[:, :3].T + to_screen[:, 3]
        near = (np.abs(homogeneous[:, :2]) < MARGIN * np.abs(homogeneous[:, 3:])).all(axis=1) & (
            homogeneous[:, 3] > -width
        )
        if not near.any():
            return
        depth = depths(self._window, rows, columns)
        along = centres[near] @ self._axes.T
        lower, upper = along.min(axis=0) - width, along.max(axis=0) + width
        texel = max((upper[0] - lower[0]) / (columns - 1), (upper[1] - lower[1]) / (rows - 1))
        middle = 0.5 * (lower + upper)
        highest = float((centres @ self._axes[2]).max()) + width
        lowest = float((centres @ self._axes[2]).min()) - width
        camera = self._renderer.GetActiveCamera()
        eye = self._axes.T @ np.array((middle[0], middle[1], highest + texel))
        camera.SetPosition(*eye)
        camera.SetFocalPoint(*(eye - self._axes[2]))
        camera.SetViewUp(*self._axes[1])
        camera.SetParallelScale(0.5 * rows * texel)
        camera.SetClippingRange(texel, texel + highest - lowest)
        renderer.DrawOff()
        self._renderer.DrawOn()
        self._window.Render()
        sun = depths(self._window, rows, columns)
        self._renderer.DrawOff()
        renderer.DrawOn()
        pixels = np.diag((2.0 / columns, 2.0 / rows, 2.0, 1.0))
        pixels[:3, 3] = 1.0 / columns - 1.0, 1.0 / rows - 1.0, -1.0
        to_map = np.eye(4)
        to_map[:3, :3] = self._axes / texel
        to_map[:2, 3] = 0.5 * np.array((columns - 1, rows - 1)) - middle[:2] / texel
        place = to_map @ np.linalg.inv(to_screen) @ pixels
        cast_shadows(picture, depth, place, sun, highest / texel, (highest - lowest) / texel, DARKNESS)


def depths(window: Any, rows: int, columns: int) -> npt.NDArray[np.float32]:
    """(rows, columns) the depth buffer of what was drawn last."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkFloatArray

    values = vtkFloatArray()
    window.GetZbufferData(0, 0, columns - 1, rows - 1, values)
    return np.asarray(vtk_to_numpy(values), np.float32).reshape(rows, columns)


def colours(window: Any, rows: int, columns: int) -> npt.NDArray[np.uint8]:
    """(rows, columns, 3) the pixels that were drawn last, from the bottom up."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

    values = vtkUnsignedCharArray()
    window.GetPixelData(0, 0, columns - 1, rows - 1, 0, values, 0)
    return np.asarray(vtk_to_numpy(values), np.uint8).reshape(rows, columns, 3)


def _matrix(matrix: Any) -> Floats:
    return np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])
