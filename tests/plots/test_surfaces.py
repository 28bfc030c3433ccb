"""What is drawn in three dimensions: closed surfaces, and the motion of their points as geometry has it."""

import numpy as np
import pytest

import rbfound as rb
from rbfound.plots import Body, rotor_body, solid_body
from rbfound.plots.surfaces import SIDES
from rbfound.thesis import bearings, rotor

CORNERS = np.array([[x, y, z] for z in (0.0, 1.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
FACES = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])
STILL = np.zeros((1, 8, 3))


def cube(**changes) -> Body:
    return Body(**({"name": "cube", "points": CORNERS, "faces": FACES, "shapes": STILL} | changes))


def turned(points, axis):
    """The displacements of points by a small rotation about an axis through the origin."""
    return np.cross(axis, points)


def nodes_of(machine, u):
    """Coordinates x, y, theta, psi of each node of a shaft from a function of z."""
    return np.array([u(z) for z in machine.mesh.z]).reshape(-1, 1)


def test_a_cube_has_its_volume_and_its_normals_point_outwards() -> None:
    assert cube().volume == pytest.approx(1.0)
    np.testing.assert_allclose(cube().normals, [[0, 0, -1], [0, 0, 1], [0, -1, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0]])


def test_of_a_cube_seen_from_a_corner_nine_edges_are_drawn_and_from_the_front_four() -> None:
    assert len(cube().edges([1, 2, 3])) == 9
    # only the front face is in sight: its rim
    assert {tuple(edge) for edge in cube().edges([0, 0, 1])} == {(4, 5), (5, 6), (6, 7), (4, 7)}


def test_an_edge_between_faces_that_hardly_bend_is_not_drawn() -> None:
    machine = rb.mount(rotor(), bearings())
    body = rotor_body(rotor(), machine.mesh.z, np.ones((4 * len(machine.mesh.z), 1)))
    along = body.points[body.edges([1, 0, 0])]
    lengthwise = along[np.abs(np.diff(along[:, :, 2], axis=1)[:, 0]) > 1e-9]
    # the two lines where the shaft turns away from the viewer, and none between
    assert len(lengthwise) >= 2
    np.testing.assert_allclose(lengthwise[:, :, 0], 0, atol=1e-12)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"faces": FACES[:, ::-1]}, "anticlockwise"),
        ({"faces": FACES[:, :3]}, r"\(faces, 4\)"),
        ({"faces": FACES + 1}, "names point 8 of 8"),
        ({"marks": {"tip": -1}}, "count from 0"),
        ({"shapes": np.zeros((8, 3))}, r"\(modes, p, 3\)"),
        ({"shapes": np.full((1, 8, 3), np.nan)}, "finite"),
    ],
)
def test_what_cannot_be_drawn_is_refused_in_a_sentence(changes, sentence) -> None:
    with pytest.raises(ValueError, match=sentence):
        cube(**changes)


def test_the_shaft_has_the_volume_of_prisms_with_so_many_sides() -> None:
    shaft = rotor().shaft
    machine = rb.mount(rotor(), bearings())
    body = rotor_body(rotor(), machine.mesh.z, np.ones((4 * len(machine.mesh.z), 1)))
    # a regular polygon in a circle of radius r covers SIDES/2 sin(2 pi/SIDES) r^2
    polygon = SIDES / 2 * np.sin(np.radians(360 / SIDES))
    squares = (np.array(shaft.diameter) / 2) ** 2
    assert body.volume == pytest.approx(polygon * squares @ shaft.length)


def test_a_shaft_that_is_shifted_and_turned_as_a_whole_moves_as_a_rigid_body() -> None:
    machine = rb.mount(rotor(), bearings())
    theta, psi = 0.3, -0.2
    # a rotation about X by theta moves the axis down by -theta z in y; one about Y by psi moves it by psi z in x
    shapes = nodes_of(machine, lambda z: (0.1 + psi * z, 0.5 - theta * z, theta, psi))
    body = rotor_body(rotor(), machine.mesh.z, shapes, list(machine.bearings))
    expected = np.array([0.1, 0.5, 0.0]) + turned(body.points, [theta, psi, 0.0])
    np.testing.assert_allclose(body.shapes[0], expected, atol=1e-14)


def test_bearings_and_disks_are_marked_on_the_axis() -> None:
    machine = rb.mount(rotor(), bearings())
    body = rotor_body(rotor(), machine.mesh.z, np.ones((4 * len(machine.mesh.z), 2)), list(bearings()))
    places = {name: body.points[k].tolist() for name, k in body.marks.items()}
    assert places == {"bearing 1": [0, 0, 0.045], "bearing 2": [0, 0, 0.85], "10 kg": [0, 0, 1.0]}


def test_a_rotor_on_a_body_has_its_first_bearing_in_the_first_seat() -> None:
    below = cube(marks={"seat 1": 6})
    z = rb.mount(rotor(), bearings()).mesh.z
    body = rotor_body(rotor(), z, np.ones((4 * len(z), 1)), list(bearings()), on=below)
    assert "bearing 1" not in body.marks
    np.testing.assert_allclose(body.points[body.marks["10 kg"]], [1, 1, 1 + 1.0 - 0.045])
    with pytest.raises(ValueError, match="no mark 'seat 1'"):
        rotor_body(rotor(), z, np.ones((4 * len(z), 1)), on=cube())


def test_shapes_must_fit_the_nodes_and_nodes_must_stand_at_the_steps() -> None:
    z = rb.mount(rotor(), bearings()).mesh.z
    with pytest.raises(ValueError, match="coordinates: shapes has 7 rows"):
        rotor_body(rotor(), z, np.ones((7, 1)))
    with pytest.raises(ValueError, match=r"No node stands at 0\.09 m"):
        rotor_body(rotor(), np.array([0.0, 1.0]), np.ones((8, 1)))


def bar(divisions=(2, 2, 6), length=1.0):
    """A bar of 0.2 x 0.3 m, 1 m long unless told, with its end at z = 0 as the bore of a seat."""
    solid = pytest.importorskip("rbfound.solid.modes", reason="the solid model needs scikit-fem")
    mesh = pytest.importorskip("rbfound.solid.mesh")
    return solid.elastic_solid([mesh.brick((0.2, 0.3, length), divisions)], None, [lambda p: np.abs(p[2]) < 1e-9])


def rigid(solid):
    """Three translations and three rotations of all nodes, (n, 6)."""
    places = solid.mesh.doflocs.T
    moves = [np.broadcast_to(e, places.shape) for e in np.eye(3)] + [turned(places, e) for e in np.eye(3)]
    return np.stack([move.T.ravel() for move in moves], axis=1)


def test_the_skin_of_a_solid_encloses_it_and_moves_with_it() -> None:
    solid = bar()
    body = solid_body(solid, rigid(solid))
    assert body.volume == pytest.approx(0.06)
    assert len(body.faces) == 2 * (2 * 2 + 2 * 6 + 2 * 6)
    skin = body.points[:-1]
    for shape, e in zip(body.shapes[:3], np.eye(3), strict=True):
        np.testing.assert_allclose(shape[:-1], np.broadcast_to(e, skin.shape))
    for shape, e in zip(body.shapes[3:], np.eye(3), strict=True):
        np.testing.assert_allclose(shape[:-1], turned(skin, e), atol=1e-14)


def test_a_seat_is_marked_in_the_middle_of_its_bore_and_moves_as_B_says() -> None:
    solid = bar()
    Phi = np.sin(np.arange(2.0 * solid.K.shape[0])).reshape(-1, 2)
    body = solid_body(solid, Phi)
    seat = body.marks["seat 1"]
    middle = solid.mesh.doflocs[:, np.abs(solid.mesh.doflocs[2]) < 1e-9]
    np.testing.assert_allclose(body.points[seat], (middle.max(axis=1) + middle.min(axis=1)) / 2, atol=1e-12)
    np.testing.assert_allclose(body.shapes[:, seat, :2].T, solid.B @ Phi, atol=1e-12)


def test_a_fine_solid_is_drawn_by_a_coarse_skin_of_the_same_body_and_of_no_other() -> None:
    fine, coarse = bar((4, 4, 12)), bar()
    Phi = fine.mesh.doflocs[[0, 1, 2]].reshape(-1, 1)
    body = solid_body(fine, Phi, drawn=coarse)
    assert len(body.faces) == len(solid_body(coarse, rigid(coarse)).faces)
    # the field u = position is met node by node
    np.testing.assert_allclose(body.shapes[0, :-1], body.points[:-1], atol=1e-12)
    with pytest.raises(ValueError, match="another body"):
        solid_body(bar(), rigid(bar()), drawn=bar(length=2.0))
    with pytest.raises(ValueError, match="Phi is"):
        solid_body(coarse, Phi)
