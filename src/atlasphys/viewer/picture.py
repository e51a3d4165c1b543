"""Pictures of frames with VTK, without a display: bodies as instances of a few meshes, as on the page."""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from atlasphys.engine.shapes.plane import Plane
from atlasphys.errors import MissingExtraError
from atlasphys.viewer import colours, overlays, shapes
from atlasphys.viewer.frame import Frame
from atlasphys.viewer.joints import joint_lines
from atlasphys.viewer.lines import draw_lines
from atlasphys.viewer.shading import measure_brightness, smooth_edges
from atlasphys.viewer.sun import DIRECTION, Sun
from atlasphys.viewer.sun import colours as drawn_colours
from atlasphys.viewer.viewpoint import Viewpoint

SHOWABLE = ("velocity", "force", "impulse", "contacts", "boxes", "axes")
"""What can be drawn beside the bodies."""

ARROWS = {"velocity": (31, 119, 220), "force": (34, 160, 60), "impulse": (214, 39, 40)}
BACKGROUND = {False: (244, 247, 250), True: (24, 27, 31)}
GROUND = {False: (214, 220, 226), True: (58, 64, 72)}
LINES = {False: (176, 185, 194), True: (88, 96, 106)}
"""By whether it is dark. The ground fades into the background."""

FINE = 14.0
"""Radius in the picture from which on balls are drawn with all their triangles [pixels]."""

GRID_CELLS = 20
"""Cells of the grid to each side."""


@dataclass(frozen=True)
class Look:
    """How pictures look."""

    size: tuple[int, int] = (1280, 720)
    """Width and height [pixels]."""
    shadows: bool = True
    dark: bool = False
    shown: tuple[str, ...] = ()
    """Out of ``SHOWABLE``."""
    joints: bool = True
    """Whether joints are drawn, as lines in front of the bodies."""


class Painter:
    """Takes pictures of frames that share a table.

    Args:
        first: the frame by whose extent the ground is sized.
        look: how they look.

    Raises:
        MissingExtraError: pyvista is not installed.
    """

    def __init__(self, first: Frame, look: Look) -> None:
        try:
            import pyvista
        except ImportError:
            raise MissingExtraError("pictures need the package pyvista: pip install 'atlasphys[render]'") from None
        self._vtk = pyvista
        self._look = look
        self._own, self._scale = colours.own_colours(first.table), overlays.typical(first.table)
        self._plotter = _plotter(pyvista, look.size)
        self._plotter.set_background([c / 255 for c in BACKGROUND[look.dark]])
        self._sun = Sun(self._plotter.render_window) if look.shadows else None
        self._poly = cache(self._make_poly)
        self._batches = [(batch, *self._add_batch(batch)) for batch in shapes.batches(first.table)]
        self._casting = np.array(
            [row for row, e in enumerate(first.table.entries) if not isinstance(e.shape, Plane)], int
        )
        self._widest = max(
            (
                float(2 * batch.scale.max() + np.abs(batch.offset).max()) * _extent(batch)
                for batch, _, _ in self._batches
            ),
            default=1.0,
        )
        lower, upper = overlays.world_box(first)
        self._reach = 8.0 * max(float((upper - lower).max()), 4 * self._scale.width)
        self._middle = 0.5 * (lower + upper)
        self._add_planes(first)
        if "axes" in look.shown:
            self._add_axes()
        self._overlay_actors: list[Any] = []
        self._add_light()

    def close(self) -> None:
        """Free what VTK holds."""
        self._plotter.close()

    def paint(self, frame: Frame, viewpoint: Viewpoint) -> npt.NDArray[np.uint8]:
        """(height, width, 3) the picture of a frame."""
        colour = colours.shown_colours(frame, self._own)
        self._place_camera(viewpoint)
        for batch, points, mappers in self._batches:
            position, orientation = batch.poses(frame)
            points.points = position - self._middle  # VTK computes in single precision
            points["orientation"] = orientation
            points["colour"] = (batch.tint[:, None] * colour[batch.rows]).astype(np.uint8)
            if batch.mesh in ("ball", "band"):
                small = self._radius_seen(position, batch.scale[:, 0], viewpoint) < FINE
                for mapper in mappers:
                    mapper.SetSourceData(self._poly(f"coarse {batch.mesh}" if small else batch.mesh))
            for mapper in mappers:
                mapper.Modified()
        self._draw_overlays(frame)
        self._plotter.render_window.Render()
        return self._finished(frame, viewpoint)

    def _radius_seen(self, position: Any, radius: Any, viewpoint: Viewpoint) -> float:
        """Radius of the largest of some balls in the picture [pixels]."""
        eye = viewpoint.look_at if viewpoint.orthographic else position
        distance = np.sqrt(((eye - viewpoint.position) ** 2).sum(axis=-1))
        scale = 0.5 * self._look.size[1] / math.tan(math.radians(viewpoint.field_of_view) / 2)
        return float((radius / np.maximum(distance, 1e-9)).max()) * scale

    def _finished(self, frame: Frame, viewpoint: Viewpoint) -> npt.NDArray[np.uint8]:
        """What was drawn, with shadows, joints and smooth edges."""
        columns, rows = self._look.size
        window = self._plotter.render_window
        picture = drawn_colours(window, rows, columns)
        if self._sun is not None:
            centres = frame.position[self._casting].astype(np.float64) - self._middle
            centres = centres[np.isfinite(centres).all(axis=1)]
            self._sun.shade(picture, self._plotter.renderer, centres, self._widest)
        if self._look.joints and frame.joints is not None:
            lines = joint_lines(frame, overlays.centers(frame), 0.7 * self._scale.width)
            layers = [(getattr(lines, name), colours.JOINTS[name]) for name in ("idle", "arms", "links", "axes")]
            picture = draw_lines(picture, layers, viewpoint)
        brightness, smoothed = np.empty((rows, columns), np.float32), np.empty_like(picture)
        measure_brightness(picture, brightness)
        smooth_edges(picture, brightness, smoothed)
        return smoothed[::-1]

    # Bodies ----------------------------------------------------------------------------------------------------------

    def _make_poly(self, key: Hashable) -> Any:
        mesh = shapes.mesh(key)
        faces = np.concatenate([np.full((len(mesh.faces), 1), 3), mesh.faces], axis=1).ravel()
        poly = self._vtk.PolyData(mesh.vertices, faces)
        return poly.compute_normals(split_vertices=not mesh.is_smooth, feature_angle=1.0 if not mesh.is_smooth else 180.0,
                                    consistent_normals=False, auto_orient_normals=False)  # fmt: skip

    def _add_batch(self, batch: shapes.Batch) -> tuple[Any, tuple[Any, ...]]:
        """The instances' points, and what draws them: in the picture, and for the sun."""
        from vtkmodules.vtkRenderingCore import vtkActor

        count = len(batch.rows)
        points = self._vtk.PolyData(np.zeros((count, 3)))
        points["orientation"] = np.tile((1.0, 0.0, 0.0, 0.0), (count, 1))
        points["scale"] = batch.scale
        points["colour"] = np.zeros((count, 3), np.uint8)
        mapper = _instances(points, self._poly(batch.mesh))
        mapper.SetScalarModeToUsePointFieldData()
        mapper.SelectColorArray("colour")
        mapper.SetColorModeToDirectScalars()
        actor = vtkActor()
        actor.SetMapper(mapper)
        shade = actor.GetProperty()
        shade.SetAmbient(0.55)
        shade.SetDiffuse(0.6)
        shade.SetSpecular(0.08)
        shade.SetSpecularPower(20)
        self._plotter.renderer.AddActor(actor)
        if self._sun is not None and batch.mesh != "band":
            shadow = _instances(points, mapper.GetSource())
            shadow.ScalarVisibilityOff()
            self._sun.add(shadow)
            return points, (mapper, shadow)
        return points, (mapper,)

    # Surroundings ----------------------------------------------------------------------------------------------------

    def _add_planes(self, frame: Frame) -> None:
        cell = 10.0 ** math.floor(math.log10(2.5 * self._scale.width))
        for entry in frame.table.entries:
            if not isinstance(entry.shape, Plane):
                continue
            normal = np.array(entry.shape.normal)
            foot = self._middle - (self._middle @ normal - entry.shape.offset) * normal
            along = np.cross(normal, (1.0, 0.0, 0.0) if abs(normal[0]) < 0.9 else (0.0, 0.0, 1.0))
            along /= np.sqrt((along**2).sum())
            across = np.cross(normal, along)
            ground = np.array([round(255 * c) for c in entry.color] if entry.color else GROUND[self._look.dark])
            self._add_disc(foot, along, across, ground)
            self._add_grid(foot + 4e-3 * self._scale.width * normal, along, across, cell, ground)

    def _faded(self, colour: Any, points: Any, foot: Any, reach: float) -> Any:
        """(k, 3) the colour at points of the ground, which fades into the background with their distance from its middle."""
        distance = np.sqrt(((points - foot) ** 2).sum(axis=1)) / reach
        share = np.clip(1.3 * (1 - distance), 0.0, 1.0)[:, None]
        return np.round(share * colour + (1 - share) * np.array(BACKGROUND[self._look.dark])).astype(np.uint8)

    def _add_disc(self, foot: Any, along: Any, across: Any, colour: Any) -> None:
        """The ground, as rings about its middle."""
        radii, angles = self._reach * np.linspace(0, 1, 13) ** 1.5, np.linspace(0, 2 * math.pi, 49)
        r, angle = (grid.ravel() for grid in np.meshgrid(radii, angles, indexing="ij"))
        points = foot + (r * np.cos(angle))[:, None] * along + (r * np.sin(angle))[:, None] * across
        a = (np.arange(12)[:, None] * 49 + np.arange(48)).ravel()
        cells = np.column_stack([np.full(len(a), 4), a, a + 1, a + 50, a + 49]).ravel()
        disc = self._vtk.PolyData(points - self._middle, cells)
        disc["colour"] = self._faded(colour, points, foot, self._reach)
        self._add_unlit(disc)

    def _add_grid(self, foot: Any, along: Any, across: Any, cell: float, ground: Any) -> None:
        """Lines through multiples of a cell's size, counted from the world's origin."""
        ticks = cell * np.arange(-GRID_CELLS, GRID_CELLS + 1)
        count, reach = len(ticks), cell * GRID_CELLS
        points = []
        for a, b in ((along, across), (across, along)):
            shift = [np.round(foot @ axis / cell) * cell - foot @ axis for axis in (a, b)]
            points.append(foot + (ticks + shift[0])[:, None, None] * a + (ticks + shift[1])[None, :, None] * b)
        flat = np.concatenate(points).reshape(-1, 3)
        cells = np.column_stack(
            [np.full(2 * count, count), np.arange(2 * count * count).reshape(2 * count, count)]
        ).ravel()
        lines = self._vtk.PolyData(flat - self._middle, lines=cells)
        share = np.clip(1.3 * (1 - np.sqrt(((flat - foot) ** 2).sum(axis=1)) / reach), 0.0, 1.0)[:, None]
        under = self._faded(ground, flat, foot, self._reach)
        lines["colour"] = np.round(share * LINES[self._look.dark] + (1 - share) * under).astype(np.uint8)
        self._add_unlit(lines.ribbon(width=0.016 * cell, normal=tuple(np.cross(along, across))))

    def _add_unlit(self, poly: Any) -> None:
        self._plotter.add_mesh(
            poly, scalars="colour", rgb=True, ambient=1.0, diffuse=0.0, show_scalar_bar=False, render=False
        )

    def _add_lines(self, lines: Any, colour: tuple[int, int, int], thickness: float) -> Any:
        """Lines as thin tubes [thickness in m]."""
        count = len(lines)
        cells = np.column_stack([np.full(count, 2), np.arange(0, 2 * count, 2), np.arange(1, 2 * count, 2)]).ravel()
        tubes = self._vtk.PolyData(lines.reshape(-1, 3), lines=cells).tube(radius=0.5 * thickness, n_sides=4)
        return self._plotter.add_mesh(
            tubes, color=list(colour), ambient=0.9, diffuse=0.1, show_scalar_bar=False, render=False
        )

    def _add_axes(self) -> None:
        length = 1.5 * self._scale.width
        for axis, colour in zip(np.eye(3), ((214, 39, 40), (34, 160, 60), (31, 119, 220)), strict=True):
            self._add_arrows(np.array([[np.zeros(3), length * axis]]), colour)

    def _add_light(self) -> None:
        """A sun; the sky is in the surfaces' ambient share."""
        sun = self._vtk.Light(
            position=tuple(DIRECTION), focal_point=(0, 0, 0), intensity=0.95, light_type="scene light"
        )
        sun.positional = False
        self._plotter.add_light(sun)

    # Overlays --------------------------------------------------------------------------------------------------------

    def _draw_overlays(self, frame: Frame) -> None:
        for actor in self._overlay_actors:
            self._plotter.remove_actor(actor, render=False)
        self._overlay_actors.clear()
        make = {
            "velocity": overlays.velocity_arrows,
            "force": overlays.force_arrows,
            "impulse": overlays.impulse_arrows,
        }
        for name, colour in ARROWS.items():
            if name in self._look.shown:
                self._overlay_actors += self._add_arrows(make[name](frame, self._scale), colour)
        if "boxes" in self._look.shown:
            self._overlay_actors.append(
                self._add_lines(
                    overlays.bounding_boxes(frame) - self._middle, (120, 130, 140), 0.02 * self._scale.width
                )
            )
        if "contacts" in self._look.shown and frame.contacts is not None and len(frame.contacts):
            points = self._vtk.PolyData(frame.contacts["point"] - self._middle)
            balls = points.glyph(
                geom=self._vtk.Sphere(radius=0.06 * self._scale.width, theta_resolution=10, phi_resolution=8),
                scale=False,
                orient=False,
            )
            self._overlay_actors.append(
                self._plotter.add_mesh(balls, color=[255, 140, 0], show_scalar_bar=False, render=False)
            )

    def _add_arrows(self, arrows: Any, colour: tuple[int, int, int]) -> list[Any]:
        if len(arrows) == 0:
            return []
        points = self._vtk.PolyData(arrows[:, 0] - self._middle)
        points["arrow"] = arrows[:, 1] - arrows[:, 0]
        length = np.sqrt((points["arrow"] ** 2).sum(axis=1))
        points["length"] = length
        thick = self._scale.width / max(float(np.median(length)), 1e-9)
        geometry = self._vtk.Arrow(
            tip_length=min(0.35, 0.15 * thick),
            tip_radius=min(0.1, 0.06 * thick),
            shaft_radius=min(0.04, 0.022 * thick),
            tip_resolution=12,
            shaft_resolution=8,
        )
        glyphs = points.glyph(orient="arrow", scale="length", geom=geometry)
        return [self._plotter.add_mesh(glyphs, color=list(colour), ambient=0.4, show_scalar_bar=False, render=False)]

    # Camera ----------------------------------------------------------------------------------------------------------

    def _place_camera(self, viewpoint: Viewpoint) -> None:
        camera = self._plotter.camera
        camera.position = tuple(viewpoint.position - self._middle)
        camera.focal_point = tuple(viewpoint.look_at - self._middle)
        arm = viewpoint.position - viewpoint.look_at
        distance = float(np.sqrt((arm**2).sum()))
        camera.up = (0.0, 0.0, -1.0) if abs(arm[1]) > 0.999 * distance else (0.0, 1.0, 0.0)
        camera.view_angle = viewpoint.field_of_view
        camera.parallel_projection = viewpoint.orthographic
        camera.parallel_scale = distance * math.tan(math.radians(viewpoint.field_of_view) / 2)
        camera.clipping_range = (0.05 * distance, distance + 3 * self._reach)


def _plotter(pyvista: Any, size: tuple[int, int]) -> Any:
    """A window that is not shown. Without a display VTK says so before it does without; that is no news."""
    from vtkmodules.vtkCommonCore import vtkLogger

    before = vtkLogger.GetCurrentVerbosityCutoff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)
    try:
        plotter = pyvista.Plotter(off_screen=True, window_size=list(size), lighting="none")
        plotter.render_window.SetMultiSamples(0)  # its frames would be stale with several
        plotter.render_window.Initialize()
    finally:
        vtkLogger.SetStderrVerbosity(before)
    return plotter


def _instances(points: Any, source: Any) -> Any:
    """A mapper that draws a mesh at every point, scaled and turned."""
    from vtkmodules.vtkRenderingCore import vtkGlyph3DMapper

    mapper = vtkGlyph3DMapper()
    mapper.SetInputData(points)
    mapper.SetSourceData(source)
    mapper.SetOrientationArray("orientation")
    mapper.SetOrientationModeToQuaternion()
    mapper.SetScaleArray("scale")
    mapper.SetScaleModeToScaleByVectorComponents()
    mapper.SetScaleFactor(1.0)
    return mapper


def _extent(batch: shapes.Batch) -> float:
    """Distance of the farthest vertex of a batch's mesh from its middle, before scaling."""
    return float(np.sqrt((shapes.mesh(batch.mesh).vertices ** 2).sum(axis=1)).max())
