"""Meshes, colours, arrows and boxes: what is drawn agrees with what the engine computes with."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import atlasphys as ap
from atlasphys.viewer import colours, overlays, shapes
from atlasphys.viewer.session import Session
from atlasphys.world.rotation import rotate

SHAPES = [
    ap.Sphere(radius=0.7),
    ap.Box(size=(1, 2, 3)),
    ap.Capsule(radius=0.4, length=1.2),
    ap.Cylinder(radius=0.6, length=1.5),
    ap.Cone(radius=0.8, height=1.4),
    ap.ConvexHull([(0, 0, 0), (2, 0, 0), (0, 1, 0), (0, 0, 3), (1, 1, 1)]),
    ap.tetrahedron(0.9),
    ap.pyramid(5, 0.7, 1.1),
    ap.octahedron(0.8),
]


def points_of(shape):
    """Vertices of the parts in the shape's frame, and signed volume of the parts that are no bands."""
    vertices, volume = [], 0.0
    for part in shapes.parts(shape):
        mesh = shapes.mesh(part.mesh)
        placed = mesh.vertices * part.scale + part.offset
        vertices.append(placed)
        if part.mesh != "band":
            a, b, c = (placed[mesh.faces[:, k]] for k in range(3))
            volume += (a * np.cross(b, c)).sum() / 6
    return np.concatenate(vertices), volume


@pytest.mark.parametrize("shape", SHAPES, ids=repr)
def test_meshes_are_closed_face_outwards_and_have_the_shape_s_volume(shape):
    _, volume = points_of(shape)
    if isinstance(shape, ap.Capsule):  # the tube has no lids, and each ball is whole
        ball = 4 / 3 * np.pi * shape.radius**3
        volume -= ball
        volume += np.pi * shape.radius**2 * shape.length / 3  # the lids' share of the divergence theorem
        assert volume == pytest.approx(shape.volume, rel=0.07)
    else:
        assert volume == pytest.approx(shape.volume, rel=0.06)


def frame_of(shape, orientation=(1, 0, 0, 0)):
    world = ap.World()
    world.add(shape, position=(1, 2, 3), orientation=orientation)
    return Session(world).frame()


@given(
    st.sampled_from(SHAPES),
    st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: sum(x * x for x in q) > 0.01),
)
def test_bounding_boxes_hold_the_drawn_body_tightly(shape, orientation):
    frame = frame_of(shape, orientation)
    vertices, _ = points_of(shape)
    q = np.repeat(frame.orientation.astype(float), len(vertices), 0)
    drawn = frame.position[0] + rotate(q, vertices)
    lower, upper = overlays.bounds(frame, np.array([0]))
    room = 0.07 * np.ptp(vertices)  # round shapes are drawn with 20 corners, a sphere's band lies above it
    assert (drawn >= lower[0] - room).all()
    assert (drawn <= upper[0] + room).all()
    assert np.abs(drawn.min(axis=0) - lower[0]).max() < room
    assert np.abs(drawn.max(axis=0) - upper[0]).max() < room


def test_batches_draw_every_body_once_and_static_ones_apart():
    session = Session.from_scene(ap.load_scene("mixed_shapes"))
    table = session.table()
    drawn = [row for batch in shapes.batches(table) if batch.mesh not in ("band", "tube") for row in set(batch.rows)]
    expected = [row for row, entry in enumerate(table.entries) if not isinstance(entry.shape, ap.Plane)]
    assert sorted(drawn) == expected
    for batch in shapes.batches(table):
        assert all((table.entries[row].kind == "static") == batch.is_static for row in batch.rows)


def test_large_batches_are_cut_into_chunks():
    world = ap.World()
    for k in range(shapes.CHUNK + 10):
        world.add(ap.Box(size=(1, 1, 1)), position=(2 * k, 0, 0))
    sizes = [len(batch.rows) for batch in shapes.batches(Session(world).table())]
    assert sizes == [shapes.CHUNK, 10]


def test_the_ends_of_a_capsule_follow_its_orientation():
    frame = frame_of(ap.Capsule(radius=0.5, length=2), (np.sqrt(0.5), 0, 0, np.sqrt(0.5)))  # +y becomes −x
    ends = next(batch for batch in shapes.batches(frame.table) if batch.mesh == "ball")
    position, _ = ends.poses(frame)
    np.testing.assert_allclose(sorted(position[:, 0]), (0, 2), atol=1e-6)
    np.testing.assert_allclose(position[:, 1:], [(2, 3)] * 2, atol=1e-6)


def resting_stack():
    session = Session.from_scene(ap.load_scene("tower", height=3))
    session.contacts_wanted = True
    session.step(60)
    return session


def test_impulse_arrows_add_up_to_the_weight():
    """In a tower at rest the arrows on a cube hold it: their sum is its weight, at the scale of the arrows."""
    session = resting_stack()
    frame = session.frame()
    scale = overlays.typical(frame.table)
    arrows = overlays.impulse_arrows(frame, scale)
    assert len(arrows) == 4 + 2 * 8  # the ground does not move; between cubes there is one for each
    total = (arrows[:, 1] - arrows[:, 0]).sum(axis=0)
    np.testing.assert_allclose(total, (0, 3 * scale.width, 0), atol=0.02)


def test_force_arrows_of_falling_bodies_are_their_weight_and_of_resting_ones_nothing():
    frame = resting_stack().frame()
    scale = overlays.typical(frame.table)
    assert len(overlays.force_arrows(frame, scale)) == 0
    world = ap.World()
    world.add(ap.Box(size=(2, 2, 2)), position=(0, 9, 0))
    session = Session(world)
    session.step(2)
    arrows = overlays.force_arrows(session.frame(), overlays.typical(session.table()))
    np.testing.assert_allclose(arrows[0, 1] - arrows[0, 0], (0, -2, 0), rtol=1e-3)


def test_velocity_arrows_start_at_centres_of_mass():
    world = ap.World(gravity=(0, 0, 0))
    cone = world.add(ap.Cone(radius=1, height=2), position=(1, 1, 1), velocity=(4, 0, 0))
    arrows = overlays.velocity_arrows(Session(world).frame(), overlays.Scale(1, 1))
    np.testing.assert_allclose(arrows[0], [cone.center_of_mass, cone.center_of_mass + (1, 0, 0)])


def test_arrows_are_bounded_in_number_and_length():
    world = ap.World(gravity=(0, 0, 0))
    for k in range(overlays.MOST_ARROWS + 50):
        world.add(ap.Sphere(radius=0.5), position=(2 * k, 0, 0), velocity=(0, 1000 if k % 2 else 0.5, 0))
    arrows = overlays.velocity_arrows(Session(world).frame(), overlays.Scale(1, 1))
    assert len(arrows) == overlays.MOST_ARROWS
    length = np.linalg.norm(arrows[:, 1] - arrows[:, 0], axis=1)
    assert length.max() == pytest.approx(overlays.LONGEST)


def test_islands_are_what_touches():
    world = ap.World()
    world.add(ap.Plane())
    for x in (0, 10):
        for y in (0.5, 1.5):
            world.add(ap.Box(size=(1, 1, 1)), position=(x, y, 0))
    world.add(ap.Box(size=(1, 1, 1)), position=(0, 50, 0))
    session = Session(world)
    session.contacts_wanted = True
    session.step(2)
    assert colours.islands(session.frame()).tolist() == [0, 1, 1, 3, 3, 5]


def test_colours_show_selection_sleep_and_what_was_given():
    world = ap.World()
    world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.5, 0), color="#ff0000")
    world.add(ap.Plane())
    session = Session(world)
    own = colours.own_colours(session.table())
    assert own[0].tolist() == [255, 0, 0]
    assert colours.shown_colours(session.frame(), own) is own
    assert colours.shown_colours(session.frame(), own, selected=0)[0].tolist() != [255, 0, 0]
    session.step(60)
    assert session.frame().asleep.tolist() == [True, False]
    assert colours.shown_colours(session.frame(), own, mark_sleeping=True)[0].tolist() != [255, 0, 0]
    assert own[0].tolist() == [255, 0, 0]
