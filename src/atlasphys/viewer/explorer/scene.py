"""The two scenes of the page: the shapes, and beside them, from wherever one looks, what the algorithm looks at."""

from __future__ import annotations

from typing import Any

import numpy as np

from atlasphys.explainer.slides.figure import A, Arrows, B, Dots, Label, Lines, Mark, Solid
from atlasphys.explainer.slides.solids import Floats, Hull, hull_of
from atlasphys.viewer.explorer.explorer import Explorer

DOT = 0.035
"""Radius of a corner of the simplex, in sizes of the smaller shape."""

FORWARD = 1e-3
"""How far polygons in one plane are drawn before each other, in sizes of the smaller shape."""


def flattened(mark: Mark, height: float) -> Mark:
    """A mark in the plane z = 0; polygons that lie on others a little before it."""
    if isinstance(mark, Solid):
        return Solid(outline(mark.hull, FORWARD * height), mark.colour, mark.opacity, mark.outlined)
    return mark


def outline(hull: Hull, height: float = 0.0) -> Hull:
    """The shadow of a body on the plane z = 0, or another."""
    return hull_of(hull.vertices * (1.0, 1.0, 0.0) + (0.0, 0.0, height))


def same(a: Mark, b: Mark) -> bool:
    """Whether two marks look the same."""
    if type(a) is not type(b) or a.colour != b.colour:
        return False
    if isinstance(a, Solid) and isinstance(b, Solid):
        alike = a.hull.vertices.shape == b.hull.vertices.shape and a.hull.faces.shape == b.hull.faces.shape
        return (
            alike
            and a.opacity == b.opacity
            and bool((a.hull.vertices == b.hull.vertices).all() and (a.hull.faces == b.hull.faces).all())
        )
    if isinstance(a, Label) and isinstance(b, Label):
        return a.text == b.text and np.array_equal(a.at, b.at)
    assert not isinstance(a, Solid | Label)
    assert not isinstance(b, Solid | Label)
    return np.array_equal(a.points, b.points) and getattr(a, "width", 0) == getattr(b, "width", 0)


SHRUNK = 0.996
"""Faces of the shapes are drawn so much smaller: what lies on them would flicker."""


class Room:
    """Marks below one node of the page's scene; those that stay are left alone."""

    def __init__(self, scene: Any, path: str) -> None:
        self._scene, self.path = scene, path
        self._nodes: list[tuple[Mark, list[Any]]] = []
        self._made = 0
        self.frame = scene.add_frame(path, show_axes=False)

    def draw(self, marks: tuple[Mark, ...], size: float) -> None:
        """Show these marks and no others."""
        left, nodes = list(self._nodes), []
        new = []
        for mark in marks:
            found = next((entry for entry in left if same(entry[0], mark)), None)
            if found is None:
                new.append(mark)
            else:
                left.remove(found)
                nodes.append(found)
        for _, handles in left:
            for handle in handles:
                handle.remove()
        self._nodes = nodes + [(mark, self._add(mark, size)) for mark in new]

    def _add(self, mark: Mark, size: float) -> list[Any]:
        self._made += 1
        name, scene = f"{self.path}/{self._made}", self._scene
        match mark:
            case Solid():
                return add_solid(scene, name, mark)
            case Lines(points=points):
                return (
                    [
                        scene.add_line_segments(
                            name, points.astype(np.float32), mark.colour, thickness=mark.width, thickness_units="screen"
                        )
                    ]
                    if len(points)
                    else []
                )
            case Arrows(points=points):
                return [
                    scene.add_arrows(
                        name, points.astype(np.float32), mark.colour, shaft_radius=0.35 * DOT * size, head_radius=0.9 * DOT * size,
                        head_length=2.4 * DOT * size,
                    )
                ]  # fmt: skip
            case Dots(points=points):
                return [
                    scene.add_icosphere(
                        f"{name}/{k}", DOT * size * mark.size, mark.colour, position=tuple(point), cast_shadow=False
                    )
                    for k, point in enumerate(points.astype(np.float64))
                ]
        aside = (0.0, (-1.4 if mark.below else 1.4) * DOT * size, 0.0)  # clear of the dot that it names
        return [
            scene.add_label(
                name,
                mark.text,
                position=tuple(np.asarray(mark.at, np.float64) + aside),
                anchor="top-right" if mark.below else "bottom-left",
            )
        ]


def add_solid(scene: Any, name: str, mark: Solid, shrunk: float = 1.0) -> list[Any]:
    """A convex body: its faces, and the edges between them."""
    hull, handles = mark.hull, []
    if len(hull.faces):
        vertices = shrunk * hull.vertices
        handles.append(
            scene.add_mesh_simple(
                f"{name}/faces", vertices.astype(np.float32), hull.faces.astype(np.uint32), color=mark.colour, opacity=mark.opacity,
                flat_shading=True, side="back" if mark.hollow else "double", cast_shadow=False, receive_shadow=False,
            )
        )  # fmt: skip
    if mark.outlined and len(hull.edges) and not hull.is_smooth:
        ends = hull.vertices[hull.edges].astype(np.float32)
        handles.append(
            scene.add_line_segments(f"{name}/edges", ends, mark.colour, thickness=1.5, thickness_units="screen")
        )
    return handles


class Scene:
    """Draws an explorer's slide. Only the page's thread may call it."""

    def __init__(self, server: Any, explorer: Explorer) -> None:
        self._server, self._scene = server, server.scene
        self._scene.set_up_direction("+y")
        self._scene.configure_environment_map(None)
        self._scene.configure_default_lights(enabled=False)
        self._scene.add_light_hemisphere(
            "/lights/sky", sky_color=(255, 255, 255), ground_color=(170, 165, 160), intensity=1.6
        )
        self._scene.add_light_directional(
            "/lights/sun", color=(255, 250, 240), intensity=1.6, position=(0.45, 1.0, 0.8)
        )
        self.shapes = Room(self._scene, "/shapes")
        self.marks = Room(self._scene, "/shapes/marks")
        self.beside = Room(self._scene, "/beside")
        self.picture = Room(self._scene, "/beside/picture")
        self.bodies: list[tuple[Any, list[Any]]] = []
        self._hulls: tuple[Any, ...] = ()
        self._opacity = 0.0
        self.middles = np.zeros((2, 3))
        self.radius = 1.0
        self._captions = [
            self._scene.add_label(path, "", anchor="center-center", font_screen_scale=1.1)
            for path in ("/shapes/caption", "/beside/caption")
        ]
        self.fit(explorer)

    # Where things are ------------------------------------------------------------------------------------------------

    def fit(self, explorer: Explorer) -> None:
        """Choose the middles of both scenes, and how far apart they are, for the shapes as they are."""
        pair = explorer.pair
        plane = np.array((1.0, 1.0, 0.0 if pair.is_flat and explorer.stage == "gjk" else 1.0))
        points = plane * np.concatenate([hull.vertices for hull in pair.bodies])
        radius = float(np.linalg.norm(np.ptp(points, axis=0))) / 2
        self.middles[0] = (points.min(axis=0) + points.max(axis=0)) / 2 + pair.position[0]
        beside = np.zeros((1, 3))
        if pair.difference is not None:
            beside = plane * np.concatenate([beside, pair.difference.vertices])
        if explorer.slide.faces_viewer:
            beside = np.zeros((1, 3))
        self.middles[1] = (beside.min(axis=0) + beside.max(axis=0)) / 2
        self.radius = max(radius, float(np.linalg.norm(np.ptp(beside, axis=0))) / 2)

    def arrange(self, right: Floats, up: Floats, explorer: Explorer) -> None:
        """Put the two scenes beside each other as seen from a camera."""
        slide = explorer.slide
        apart = self.radius * right if any(one.beside for one in explorer.slides) else 0.0 * right
        self.shapes.frame.position = tuple(-apart)
        self.beside.frame.position = tuple(apart)
        turn = np.array((1.0, 0.0, 0.0, 0.0))
        if slide.faces_viewer:
            turn = quaternion(np.stack([right, up, np.cross(right, up)], axis=1))
        self.picture.frame.wxyz = tuple(turn)
        self.picture.frame.position = (0.0, 0.0, 0.0) if slide.faces_viewer else tuple(-self.middles[1])
        for caption in self._captions:
            caption.position = tuple(-1.08 * self.radius * up)

    # What is drawn ---------------------------------------------------------------------------------------------------

    def draw(self, explorer: Explorer, flat: bool) -> None:
        """Show the present slide; ``flat``: as a figure in the plane."""
        slide, pair = explorer.slide, explorer.pair
        self._draw_bodies(explorer, flat)
        self.marks.frame.position = tuple(pair.position[0] - self.middles[0])
        shapes, beside = slide.shapes, slide.beside
        if flat:
            shapes, beside = (
                tuple(flattened(mark, k * pair.size) for k, mark in enumerate(marks)) for marks in (shapes, beside)
            )
        self.marks.draw(shapes, pair.size)
        self.picture.draw(beside, pair.size)
        self._captions[0].text = f"A: {pair.names[0]},  B: {pair.names[1]}"
        self._captions[1].text = slide.caption
        self._captions[1].visible = bool(slide.caption)

    def _draw_bodies(self, explorer: Explorer, flat: bool) -> None:
        hulls = explorer.pair.local_bodies
        key = (flat, *(hull.vertices.tobytes() for hull in hulls))
        if key != self._hulls:
            self._make_bodies(hulls, flat)
            self._hulls, self._opacity = key, 0.0
        for which, (frame, handles) in enumerate(self.bodies):
            position, orientation = explorer.pose(which)
            frame.position, frame.wxyz = tuple(position - self.middles[0]), tuple(orientation)
            if explorer.slide.opacity != self._opacity:
                for handle in handles[:1]:
                    handle.opacity = explorer.slide.opacity
        self._opacity = explorer.slide.opacity

    def _make_bodies(self, hulls: tuple[Hull, Hull], flat: bool) -> None:
        for frame, handles in self.bodies:
            for handle in handles:
                handle.remove()
            frame.remove()
        self.bodies = []
        for name, hull, colour in zip("ab", hulls, (A, B), strict=True):
            frame = self._scene.add_frame(f"/shapes/{name}", show_axes=False)
            solid = Solid(outline(hull) if flat else hull, colour, 0.55)
            handles = add_solid(self._scene, f"/shapes/{name}/body", solid, SHRUNK)
            self.bodies.append((frame, handles))


def quaternion(rotation: Floats) -> Floats:
    """(w, x, y, z) of a rotation matrix."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(rotation).as_quat()
    return np.array((w, x, y, z))
