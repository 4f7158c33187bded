"""What is drawn over the picture, against published angles and closed forms."""

import numpy as np
import pytest

from rtbow.scene.text.file import load_scene
from rtbow.view.picture.overlays import (
    bow_circles,
    box_edges,
    descartes_deg,
    grid,
    horizon,
    lamp_bows,
    marks,
    overlays,
)
from rtbow.view.picture.projection import View, part_views
from rtbow.world.rain.box import box_of
from textbook import pinhole, stationary_ray
from textbook import towards as unit

SIZE = (960, 540)


def shown(name, **changes):
    scene = load_scene(name, {key.replace("__", "."): value for key, value in changes.items()})
    ((part, view),) = part_views(scene, SIZE)
    return part, view


def angle_deg(a, b):
    return np.degrees(np.arccos(np.clip(np.sum(a * b, axis=-1), -1.0, 1.0)))


# Water at 20 degrees relative to air, CRC Handbook: Fraunhofer's C, D, F and h.
@pytest.mark.parametrize(
    ("nm", "index"), [(656.3, 1.33115), (589.3, 1.33299), (486.1, 1.33712), (404.7, 1.34274)]
)
@pytest.mark.parametrize("reflections", [1, 2, 3])
def test_descartes_angles(nm, index, reflections):
    scene, _ = shown("curtain")
    turn = np.degrees(stationary_ray(index, reflections)[1]) % 360.0
    expected = min(turn, 360.0 - turn)
    # Worst 0.009: the handbook's last digit of the index is 0.001.
    assert descartes_deg(scene, reflections, nm) == pytest.approx(expected, abs=0.02)


def test_warm_water_widens_the_bow():
    cold, _ = shown("curtain", scattering__water_temperature_c=0.0)
    warm, _ = shown("curtain", scattering__water_temperature_c=40.0)
    assert descartes_deg(cold, 1, 589.0) > descartes_deg(warm, 1, 589.0) + 0.3


def test_circles_are_about_the_antisolar_point():
    scene, view = shown("curtain")
    found = bow_circles(scene, view)
    assert [o.label for o in found] == [
        "primary 42.4° red", "primary 41.1° violet",
        "secondary 50.3° red", "secondary 52.7° violet",
    ]  # fmt: skip
    assert [o.wavelength_nm for o in found] == [680.0, 440.0] * 2
    for overlay in found:
        radius = float(overlay.label.split()[1].rstrip("°"))
        points = np.concatenate(overlay.lines)
        assert len(points) > 20
        away = angle_deg(view.directions(points), unit(0.0, -20.0))
        np.testing.assert_allclose(away, radius, atol=0.06)  # of the label's digits
        assert np.ptp(away[1:-1]) < 0.03  # ends are cut off chords
        assert np.linalg.norm(points - overlay.at, axis=1).min() < 20.0


def test_chosen_orders_and_wavelengths():
    scene, view = shown("curtain", camera__fov_deg=150.0, camera__altitude_deg=-20.0)
    found = bow_circles(scene, view, orders=(3,), wavelengths_nm=(580.0,))
    assert [o.label.split()[0] for o in found] == ["tertiary"]
    mie, view = shown("curtain", scattering__theory="mie", scattering__orders=[1])
    assert len(bow_circles(mie, view)) == 4  # exact theory has all
    one, view = shown("curtain", scattering__orders=[1])
    assert len(bow_circles(one, view)) == 2


def test_two_suns_have_two_bows():
    lights = [{"altitude_deg": 20.0}, {"altitude_deg": 10.0, "azimuth_deg": 160.0}]
    scene, view = shown("curtain", light=lights)
    found = bow_circles(scene, view)
    assert len(found) == 8
    assert {o.label[-3:] for o in found} == {"(0)", "(1)"}
    points = np.concatenate(found[4].lines)
    away = angle_deg(view.directions(points), unit(-20.0, -10.0))
    np.testing.assert_allclose(away, 42.4, atol=0.06)


def brute_span(eye, rays, box):
    """Where rays (n, 3) enter and leave a box: the middle two of their six crossings."""
    with np.errstate(divide="ignore"):
        crossings = np.sort(((box[:, None] - eye) / rays).reshape(2, -1, 3), axis=0)
    enter, leave = np.maximum(crossings[0].max(axis=1), 0.0), crossings[1].min(axis=1)
    return enter, leave


LAMP_VIEWS = {
    "before the rain": {},
    "in the rain": {"camera__position_m": [0.0, 30.0, 1.5], "camera__altitude_deg": 50.0},
    "two lamps": {"name": "two-lamps"},
    "down": {"camera__altitude_deg": -30.0, "camera__position_m": [0.0, 5.0, 20.0]},
}


@pytest.mark.parametrize("name", LAMP_VIEWS)
def test_lamp_bows_are_the_spindle_torus(name):
    changes = dict(LAMP_VIEWS[name])
    scene, view = shown(changes.pop("name", "street-lamp"), **changes)
    box, eye = np.array(scene.droplets.box_m), np.array(scene.camera.position_m)
    found = [o for o in lamp_bows(scene, view, box) if o.lines]
    assert found
    for overlay in found:
        order = 1 if "primary" in overlay.label else 2
        seen_under = np.pi - np.radians(descartes_deg(scene, order, overlay.wavelength_nm))
        number = int(overlay.label[-2]) if len(scene.light) > 1 else 0
        away = np.array(scene.light[number].position_m) - eye
        reach = np.linalg.norm(away)
        for line in overlay.lines:
            rays = view.directions(line)
            enter, leave = brute_span(eye, rays, box)
            here = enter if "near" in overlay.label else leave
            # Law of sines in the triangle of eye, drop and lamp.
            aside = np.radians(angle_deg(rays, away / reach))
            torus = reach * np.sin(aside + seen_under) / np.sin(seen_under)
            drop = here[:, None] * rays
            far = here > 1e-3
            np.testing.assert_allclose(torus[~far], 0.0, atol=1e-4 * reach)  # cut at a side
            # As an angle at the drop, in which a surface that is grazed is as exact.
            sides = np.linalg.norm(away - drop, axis=1) * here
            angle = np.arccos(np.sum((drop - away) * drop, axis=1)[far] / sides[far])
            # Worst 2e-5, at the box's own edges; else 1e-11.
            np.testing.assert_allclose(angle, seen_under, atol=1e-4)
            assert np.median(np.abs(torus - here)) < 1e-6 * reach


@pytest.mark.parametrize("name", LAMP_VIEWS)
def test_no_part_of_a_lamps_bow_is_missed(name):
    changes = dict(LAMP_VIEWS[name])
    scene, view = shown(changes.pop("name", "street-lamp"), **changes)
    box, eye = np.array(scene.droplets.box_m), np.array(scene.camera.position_m)
    x, y = np.meshgrid(np.arange(20.0, 940.0, 3.0), np.arange(20.0, 520.0, 3.0))
    rays = view.directions(np.stack([x, y], axis=-1))
    enter, leave = (a.reshape(x.shape) for a in brute_span(eye, rays.reshape(-1, 3), box))
    for overlay in lamp_bows(scene, view, box):
        order = 1 if "primary" in overlay.label else 2
        number = int(overlay.label[-2]) if len(scene.light) > 1 else 0
        lamp = np.array(scene.light[number].position_m) - eye
        drop = (enter if "near" in overlay.label else leave)[..., None] * rays
        to_lamp = (lamp - drop) / np.linalg.norm(lamp - drop, axis=-1, keepdims=True)
        beyond = angle_deg(to_lamp, rays) > descartes_deg(scene, order, overlay.wavelength_nm)
        # Within the box's picture, and away from its own sides.
        hit = enter < leave
        both = hit[:-1, :-1] & hit[1:, 1:] & hit[:-1, 1:] & hit[1:, :-1]
        crossed = both & (beyond[:-1, :-1] != beyond[1:, 1:])
        points = np.stack([x[:-1, :-1][crossed], y[:-1, :-1][crossed]], axis=-1) + 1.5
        if len(points):
            drawn = np.concatenate([np.empty((0, 2)), *map(filled, overlay.lines)])
            gaps = np.linalg.norm(points[:, None] - drawn[None], axis=-1).min(axis=1)
            assert gaps.max() < 12.0  # a cell, at the box's sides
            assert np.median(gaps) < 2.5


def test_lamp_bows_lie_on_the_rain(rng):
    points, off = 0, []
    for _ in range(150):
        scene, view = shown(
            "street-lamp",
            camera__position_m=rng.uniform([-90.0, -20.0, 0.0], [90.0, 110.0, 60.0]).tolist(),
            camera__azimuth_deg=float(rng.uniform(-180.0, 180.0)),
            camera__altitude_deg=float(rng.uniform(-60.0, 60.0)),
            camera__fov_deg=float(rng.uniform(20.0, 150.0)),
        )
        box, eye = np.array(scene.droplets.box_m), np.array(scene.camera.position_m)
        for overlay in lamp_bows(scene, view, box):
            for line in overlay.lines:
                rays = view.directions(line)
                enter, leave = brute_span(eye, rays, box)
                assert np.all(enter < leave)
                drop = (enter if "near" in overlay.label else leave)[:, None] * rays
                to_lamp = np.array(scene.light[0].position_m) - eye - drop
                angle = angle_deg(to_lamp / np.linalg.norm(to_lamp, axis=1)[:, None], rays)
                order = 1 if "primary" in overlay.label else 2
                off += list(np.abs(angle - descartes_deg(scene, order, overlay.wavelength_nm)))
                points += len(line)
    assert points > 1000
    # What is off lies in the last cell before the box's outline, where the angle changes at once.
    assert np.quantile(off, 0.98) < 1e-3


def filled(line):
    """Points along a line, two pixels apart."""
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    at = np.linspace(0.0, way[-1], 2 + int(way[-1] / 2.0))
    return np.stack([np.interp(at, way, line[:, k]) for k in (0, 1)], axis=1)


def test_lamp_bows_have_smooth_lines():
    scene, view = shown("street-lamp")
    for overlay in lamp_bows(scene, view, np.array(scene.droplets.box_m)):
        for line in overlay.lines:
            steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
            assert steps.max() < 20.0


def test_a_sun_has_no_torus_and_a_lamp_no_circle():
    scene, view = shown("curtain")
    assert lamp_bows(scene, view, box_of(scene.droplets)) == []
    scene, view = shown("street-lamp")
    assert bow_circles(scene, view) == []


def test_the_horizon_is_level():
    for altitude, straight in ((0.0, True), (30.0, True), (-40.0, True)):
        _, view = shown("curtain", camera__altitude_deg=altitude, camera__fov_deg=120.0)
        (line,) = horizon(view).lines
        rays = view.directions(line)
        np.testing.assert_allclose(rays[:, 2], 0.0, atol=1e-9)
        assert np.ptp(line[:, 1]) < 1e-6 or not straight
    assert horizon(shown("curtain", camera__altitude_deg=89.0)[1]).lines == ()


@pytest.mark.parametrize(
    ("azimuth", "altitude", "fov"),
    [(0, 22.5, 84), (-100, 0, 30), (175, -60, 120), (0, 90, 100), (20, 80, 1), (0, 0, 0.5),
     (0, 45, 170)],
)  # fmt: skip
def test_the_grid_has_some_lines_and_says_which(azimuth, altitude, fov):
    _, view = shown(
        "curtain", camera__azimuth_deg=azimuth, camera__altitude_deg=altitude, camera__fov_deg=fov
    )
    found = grid(view)
    assert 3 <= len(found) <= 60
    names = [o.label for o in found]
    assert len(set(names)) == len(names)
    compass = {"N": 0.0, "E": 90.0, "S": 180.0, "W": 270.0}
    for overlay in found:
        points = np.concatenate(overlay.lines)
        east, north, up = view.directions(points[1:-1] if len(points) > 2 else points).T
        if overlay.label[0] in "+-":
            np.testing.assert_allclose(
                np.degrees(np.arcsin(up)), float(overlay.label[:-1]), atol=0.05 * fov / 84
            )
            continue
        expected = compass.get(overlay.label)
        expected = float(overlay.label[:-1]) if expected is None else expected
        flat = np.hypot(east, north) > 1e-6
        turned = np.degrees(np.arctan2(east, north))[flat] - expected
        np.testing.assert_allclose((turned + 180.0) % 360.0 - 180.0, 0.0, atol=1e-6)


def test_the_grid_is_as_fine_as_the_view():
    wide, narrow = (len(grid(shown("curtain", camera__fov_deg=f)[1])) for f in (100.0, 2.0))
    assert 8 <= wide <= 30
    assert 8 <= narrow <= 30


def test_the_grid_covers_the_view():
    # At every place a line of each kind is no farther than a step and a half.
    _, view = shown("curtain", camera__fov_deg=40.0, camera__altitude_deg=10.0)
    labels = [o.label for o in grid(view)]
    around = {"340°", "345°", "350°", "355°", "N", "5°", "10°", "15°", "20°"}
    assert set(labels) == {"+5°", "+10°", "+15°", "+20°"} | around


def test_the_box_has_its_corners():
    scene, view = shown("street-lamp")
    box = box_of(scene.droplets)
    points = np.concatenate(box_edges(view, box).lines)
    corners = np.array([[x, y, z] for x in (-60, 60) for y in (8, 80) for z in (0, 30)])
    pixels = pinhole(scene.camera, corners - scene.camera.position_m, SIZE)
    seen = np.all((pixels >= 0.0) & (pixels <= SIZE), axis=1)
    assert seen.sum() == 4  # those of the far side
    gaps = np.linalg.norm(pixels[seen][:, None] - points[None], axis=-1).min(axis=1)
    np.testing.assert_allclose(gaps, 0.0, atol=1e-6)
    # From above all twelve edges are seen, and each once.
    above, view = shown("street-lamp", camera__position_m=[0.0, -150.0, 60.0],
                        camera__altitude_deg=-12.0)  # fmt: skip
    whole = box_edges(view, box_of(above.droplets)).lines
    assert len({tuple(np.sort(np.round(line, 3), axis=0).ravel()) for line in whole}) == 12


def test_marks():
    scene, view = shown("curtain", camera__altitude_deg=0.0)
    (mark,) = marks(scene, view)
    assert (mark.kind, mark.label) == ("antisolar", "antisolar point")
    np.testing.assert_allclose(mark.at, pinhole(scene.camera, unit(0.0, -20.0), SIZE))
    scene, view = shown("curtain", camera__azimuth_deg=180.0)
    (mark,) = marks(scene, view)
    assert (mark.kind, mark.label) == ("light", "sun")
    scene, view = shown("street-lamp", camera__azimuth_deg=180.0, camera__altitude_deg=10.0)
    (mark,) = marks(scene, view)
    assert (mark.kind, mark.label) == ("light", "lamp")
    np.testing.assert_allclose(mark.at, pinhole(scene.camera, [0.0, -7.0, 4.5], SIZE))
    scene, view = shown("street-lamp", camera__altitude_deg=-20.0)
    assert [m.label for m in marks(scene, view)] == ["opposite the lamp"]


def test_each_part_of_a_split_picture_has_its_own():
    right = {"camera.fov_deg": 40.0, "light.0.altitude_deg": 10.0}
    scene = load_scene("curtain", {"compare": {"split": 0.5, "right": right}})
    found = [o for o in overlays(scene, SIZE, {"circles"}) if o.label == "primary 42.4° red"]
    assert len(found) == 2
    left, right = (np.concatenate(o.lines) for o in found)
    assert left[:, 0].max() == pytest.approx(480.0)
    assert right[:, 0].min() == pytest.approx(480.0)
    views = [view for _, view in part_views(scene, SIZE)]
    for points, view, altitude in ((left, views[0], -20.0), (right, views[1], -10.0)):
        away = angle_deg(view.directions(points), unit(0.0, altitude))
        np.testing.assert_allclose(away, 42.4, atol=0.06)


def test_overlays_are_those_asked_for():
    scene, _ = shown("street-lamp")
    kinds = {name: {o.kind for o in overlays(scene, SIZE, {name})} for name in
             ("circles", "grid", "box")}  # fmt: skip
    assert kinds == {"circles": {"bow"}, "grid": {"grid", "horizon"}, "box": {"box"}}
    assert overlays(scene, SIZE, set()) == []
    assert overlays(scene, SIZE, {"circles", "box"}, boxes=[None]) == []
    for overlay in overlays(scene, SIZE, {"circles", "grid", "box"}):
        assert overlay.at is not None
        points = np.concatenate(overlay.lines)
        assert np.isfinite(points).all()
        assert (points >= -1e-6).all()
        assert (points <= np.array(SIZE) + 1e-6).all()


def test_boxes(tmp_path):
    scene, _ = shown("street-lamp")
    np.testing.assert_array_equal(box_of(scene.droplets), [[-60, 8, 0], [60, 80, 30]])
    file, _ = shown("curtain")
    box = box_of(file.droplets)
    assert box.shape == (2, 3)
    assert np.all(box[1] > box[0])
    bad = tmp_path / "bad.npz"
    bad.write_bytes(b"PK nothing")
    for path in (bad, tmp_path / "missing.npz"):
        droplets = file.droplets.model_copy(update={"file": str(path)})
        assert box_of(droplets) is None


def test_a_view_of_another_shape_stretches():
    scene, _ = shown("curtain")
    square = View(scene.camera, (500, 500))
    wide = View(scene.camera, (1000, 500))
    (one,), (other,) = (o.lines for o in (bow_circles(scene, v)[0] for v in (square, wide)))
    assert one[:, 1].min() == pytest.approx(other[:, 1].min(), abs=0.5)
    assert one[:, 0].max() * 2.0 == pytest.approx(other[:, 0].max(), abs=0.5)
