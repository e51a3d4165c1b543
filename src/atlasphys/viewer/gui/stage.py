"""The scene: bodies, planes and what is shown about them, as nodes of the page."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from atlasphys.engine.shapes.plane import Plane
from atlasphys.viewer import colours, overlays, shapes
from atlasphys.viewer.frame import Frame, Table
from atlasphys.viewer.joints import NO_LINES, joint_at, joint_lines
from atlasphys.viewer.sun import DIRECTION

if TYPE_CHECKING:
    from atlasphys.viewer.gui.page import Page

GREEN, RED, BLUE, ORANGE, VIOLET, YELLOW = (
    (34, 160, 60), (214, 39, 40), (31, 119, 220), (255, 140, 0), (150, 80, 200), (255, 200, 0),
)  # fmt: skip

SHADOW = 0.42
"""Darkness of shadows on the ground."""

MARK = 0.7
"""Length of the marks of joints' axes, in widths of a typical body."""

CLICK = 0.012
"""How far from a joint's line a click may be to select it, of the picture's height."""


class Stage:
    """Draws frames. Only the page's thread may call it."""

    def __init__(self, page: Page) -> None:
        self._page, self._scene = page, page.server.scene
        self._table: Table | None = None
        self._nodes: list[tuple[shapes.Batch, Any]] = []
        self._planes: list[tuple[int, Any]] = []
        self._lines: dict[str, Any] = {}
        self._own = self._colour = np.empty((0, 3), np.uint8)
        self.scale = overlays.Scale(1.0, 1.0)
        self._generation = 0
        self._axes = self._scene.add_frame("/axes", axes_length=1.0, axes_radius=0.02, visible=False)
        self._scene.configure_environment_map(None)
        self._add_lights()
        self._body_clicked: tuple[Any, ...] = ()
        self._scene.on_click()(self._clicked)

    def _add_lights(self) -> None:
        """A sun and a bright sky, of our own: the default ones follow the camera's headlight and leave undersides black."""
        self._scene.configure_default_lights(enabled=False)
        self._scene.add_light_hemisphere(
            "/lights/sky", sky_color=(255, 255, 255), ground_color=(165, 160, 155), intensity=1.9
        )
        # The page would cast its shadows no farther than 20 m from the camera; see look.py.
        self._scene.add_light_directional(
            "/lights/sun", color=(255, 250, 242), intensity=2.0, position=tuple(DIRECTION)
        )

    # Bodies ----------------------------------------------------------------------------------------------------------

    def draw(self, frame: Frame) -> None:
        """Show a frame."""
        if frame.table is not self._table:
            self._build(frame)
        shown, table = self._page.shown, frame.table
        row = table.row(self._page.selected)
        colour = colours.shown_colours(
            frame, self._own, by_island=shown.islands, mark_sleeping=shown.sleeping, selected=row
        )
        new_colours = not np.array_equal(colour, self._colour)
        self._colour = colour
        for batch, node in self._nodes:
            position, orientation = batch.poses(frame)
            # Rounded as they are sent, so that what did not change is recognised.
            node.batched_positions = position.astype(np.float32)
            node.batched_wxyzs = orientation.astype(np.float32)
            if new_colours:
                node.batched_colors = _tinted(batch, colour)
        self._draw_planes(frame)
        self._axes.visible = shown.axes
        self._draw_overlays(frame, row)

    def _build(self, frame: Frame) -> None:
        """Make the nodes anew: bodies came or went."""
        for _, node in self._nodes:
            node.remove()
        for _, grid in self._planes:
            grid.remove()
        self._table, self._own = frame.table, colours.own_colours(frame.table)
        self._colour = self._own
        self.scale = overlays.typical(frame.table)
        self._generation += 1
        self._nodes = [
            (batch, self._batch_node(batch, k, frame)) for k, batch in enumerate(shapes.batches(frame.table))
        ]
        self._planes = []
        self._add_planes(frame)
        self._axes.axes_length, self._axes.axes_radius = 1.5 * self.scale.width, 0.03 * self.scale.width
        self._axes.origin_radius = 0.06 * self.scale.width

    def _batch_node(self, batch: shapes.Batch, number: int, frame: Frame) -> Any:
        mesh = shapes.mesh(batch.mesh)
        position, orientation = batch.poses(frame)
        node = self._scene.add_batched_meshes_simple(
            f"/bodies/{self._generation}/{number}",
            mesh.vertices.astype(np.float32),
            mesh.faces.astype(np.uint32),
            batched_wxyzs=orientation.astype(np.float32),
            batched_positions=position.astype(np.float32),
            batched_scales=batch.scale.astype(np.float32),
            batched_colors=_tinted(batch, self._own),
            flat_shading=not mesh.is_smooth,
            lod="off",
        )
        ids = frame.table.ids[batch.rows]
        page = self._page

        async def clicked(event: Any) -> None:  # a coroutine, so that it comes before the click on the scene
            self._body_clicked = (event.client_id, event.screen_pos)
            if not self._select_joint(event, arms=False):
                page.select(int(ids[event.instance_index or 0]))

        async def dragged(event: Any) -> None:  # a coroutine, so that the phases come in order
            if event.phase == "start":
                identity, point = int(ids[event.instance_index or 0]), event.start_position
                page.do(lambda session: session.grab(identity, point))
            target = event.end_position
            page.do(lambda session: session.drag(target))
            if event.phase == "end":
                page.do(lambda session: session.let_go())

        node.on_click(clicked)
        if not page.is_replay and not batch.is_static:
            node.on_drag("left")(dragged)
        return node

    async def _clicked(self, event: Any) -> None:
        """Select the joint whose line is under the pointer, unless a body is, too."""
        if self._body_clicked != (event.client_id, event.screen_pos):
            self._select_joint(event, arms=True)
        self._body_clicked = ()

    def _select_joint(self, event: Any, *, arms: bool) -> bool:
        """Select the joint under the pointer; ``arms``: also where only lines from the middles of bodies are."""
        page, frame = self._page, self._page.frame
        if not page.shown.joints or frame.joints is None:
            return False
        near = CLICK * event.client.camera.fov
        ray = (event.ray_origin, event.ray_direction)
        found = joint_at(frame, overlays.centers(frame), MARK * self.scale.width, *ray, near, arms=arms)
        if found is not None:
            page.select(None)
            page.select_joint(found)
        return found is not None

    # Planes ----------------------------------------------------------------------------------------------------------

    def _add_planes(self, frame: Frame) -> None:
        """The ground and its grid, one node, which fades into the background with the distance from the origin."""
        lower, upper = overlays.world_box(frame)
        extent = max(float((upper - lower).max()), 4 * self.scale.width)
        reach = 12.0 * extent + float(np.abs([lower, upper]).max())
        cell = 10.0 ** np.floor(np.log10(2.5 * self.scale.width))
        for row, entry in enumerate(frame.table.entries):
            if not isinstance(entry.shape, Plane):
                continue
            normal = np.array(entry.shape.normal)
            grid = self._scene.add_grid(
                f"/planes/{self._generation}/{row}", 2 * reach, 2 * reach, plane="xz", cell_size=cell, section_size=10 * cell,
                fade_distance=reach, fade_strength=0.12, fade_from="origin", shadow_opacity=SHADOW,
                wxyz=_from_y_to(normal), position=tuple(entry.shape.offset * normal),
            )  # fmt: skip
            self._planes.append((row, grid))

    def _draw_planes(self, frame: Frame) -> None:
        shown, dark = self._page.shown, self._page.dark
        fine, coarse = colours.LINES[dark]
        for row, grid in self._planes:
            entry = frame.table.entries[row]
            colour = colours.ground(entry, dark)
            look = {
                "visible": (shown.plane or shown.grid) and not np.isnan(frame.position[row, 0]),
                "plane_color": colour,
                "plane_opacity": 1.0 if shown.plane else 0.0,
                "cell_color": fine,
                "section_color": coarse,
                "cell_thickness": 0.6 if shown.grid else 0.0,
                "section_thickness": 1.1 if shown.grid else 0.0,
            }
            for name, value in look.items():
                if getattr(grid, name) != value:
                    setattr(grid, name, value)

    # Overlays --------------------------------------------------------------------------------------------------------

    def _draw_overlays(self, frame: Frame, selected: int | None) -> None:
        shown, scale = self._page.shown, self.scale
        size = shown.arrow_size
        empty = np.empty((0, 2, 3))
        self._arrows("velocity", overlays.velocity_arrows(frame, scale, size) if shown.velocity else empty, BLUE)
        self._arrows("force", overlays.force_arrows(frame, scale, size) if shown.force else empty, GREEN)
        self._arrows("impulse", overlays.impulse_arrows(frame, scale, size) if shown.impulse else empty, RED)
        self._segments("normals", overlays.contact_normals(frame, scale) if shown.normals else empty, VIOLET)
        self._segments("boxes", overlays.bounding_boxes(frame) if shown.boxes else empty, (120, 130, 140))
        rows = np.array([] if selected is None else [selected], np.int64)
        is_plane = selected is not None and isinstance(frame.table.entries[selected].shape, Plane)
        marked = empty if selected is None or is_plane else overlays.box_edges(*overlays.bounds(frame, rows))
        self._segments("selection", marked[~np.isnan(marked).any(axis=(1, 2))], YELLOW)
        points = frame.contacts["point"] if shown.contacts and frame.contacts is not None else np.empty((0, 3))
        self._points("contacts", points, ORANGE)
        self._draw_joints(frame)
        there = frame.table.is_dynamic & ~np.isnan(frame.position[:, 0])
        self._points("centers", overlays.centers(frame)[there] if shown.centers else np.empty((0, 3)), (20, 20, 20))

    def _draw_joints(self, frame: Frame) -> None:
        lines = NO_LINES
        if self._page.shown.joints and frame.joints is not None and len(frame.joints.table):
            width = MARK * self.scale.width
            lines = joint_lines(frame, overlays.centers(frame), width, self._page.selected_joint)
        for name, points in lines._asdict().items():
            self._segments(f"joint {name}", points, colours.JOINTS[name], 4.0 if name == "selected" else 2.5)

    def _arrows(self, name: str, points: Any, colour: tuple[int, int, int]) -> None:
        width = self.scale.width

        def make() -> Any:
            return self._scene.add_arrows(
                f"/overlays/{name}",
                points,
                colours.linear(np.array(colour)),
                shaft_radius=0.028 * width,
                head_radius=0.075 * width,
                head_length=0.18 * width,
            )

        self._put(name, points, make)

    def _segments(self, name: str, points: Any, colour: tuple[int, int, int], thickness: float = 2.0) -> None:
        def make() -> Any:
            return self._scene.add_line_segments(
                f"/overlays/{name}", points, colour, thickness=thickness, thickness_units="screen"
            )

        self._put(name, points, make)

    def _points(self, name: str, points: Any, colour: tuple[int, int, int]) -> None:
        """Small octahedra: points of a cloud would be hidden in the bodies that they lie in."""

        def make() -> Any:
            return self._scene.add_point_cloud(
                f"/overlays/{name}",
                points,
                colour,
                point_size=0.09 * self.scale.width,
                point_shape="circle",
                precision="float32",
            )

        self._put(name, points, make)

    def _put(self, name: str, points: Any, make: Any) -> None:
        """Show points in the node of that name, which is made when there is something to show for the first time in this world."""
        key = f"{self._generation} {name}"
        node = self._lines.get(name)
        if node is not None and node[0] != key:
            node[1].remove()
            del self._lines[name]
            node = None
        if len(points) == 0:
            if node is not None:
                node[1].visible = False
            return
        if node is None:
            self._lines[name] = (key, make())
            return
        node[1].points = points.astype(np.float32)
        node[1].visible = True


def _tinted(batch: shapes.Batch, colour: Any) -> Any:
    """(m, 3) the colours of a batch's instances."""
    return colours.linear((batch.tint[:, None] * colour[batch.rows]).astype(np.uint8))


def _from_y_to(normal: Any) -> tuple[float, float, float, float]:
    """The shortest rotation from +y to a unit vector."""
    x, y, z = (float(c) for c in normal)
    if y < -1 + 1e-9:
        return 0.0, 1.0, 0.0, 0.0
    w = np.sqrt((1 + y) / 2)
    return float(w), z / (2 * float(w)), 0.0, -x / (2 * float(w))
