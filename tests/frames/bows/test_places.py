"""Which pictures can show a bow, against angles worked by hand."""

import numpy as np
import pytest

import rtbow
from rtbow.frames.bows.places import sight_of
from rtbow.physics.drop.medium import Medium
from rtbow.world.rain.volume import DropletVolume
from rtbow.world.world import resolve

LARGE = {"droplets.radius.radius_um": 3000.0}


def sight(**changes):
    """The sight of scene uniform with keys changed, two underscores for each dot."""
    keys = {key.replace("__", "."): value for key, value in changes.items()}
    world = resolve(rtbow.load_scene("uniform", {"camera.size_px": [32, 18], **LARGE, **keys}))
    return sight_of(world, slice(0, 32))


def test_descartes_circles_of_an_index():
    """Descartes: 42.03 and 50.98 degrees for an index of 4/3; 22.84 for one of 1.5."""
    water, glass = Medium(refractive_index=4.0 / 3.0), Medium(refractive_index=1.5)
    assert 180.0 - water.descartes_deg(1, 550.0) == pytest.approx(42.03, abs=0.01)
    assert 180.0 - water.descartes_deg(2, 550.0) == pytest.approx(50.98, abs=0.01)
    assert 180.0 - glass.descartes_deg(1, 550.0) == pytest.approx(22.84, abs=0.01)


@pytest.mark.parametrize(
    ("altitude", "shows"),
    [(20.2, False), (21.2, True), (22.3, True), (23.6, False), (29.6, False), (31.0, True)],
)
def test_a_narrow_view_shows_what_it_looks_at(altitude, shows):
    """Under a sun of 20 degrees the primary's top stands 20.9 to 22.4 high, blue to red, and the
    secondary's 30.4 to 33."""
    assert sight(camera__altitude_deg=altitude, camera__fov_deg=1.0).bow_shows is shows


def test_a_bow_needs_rain_where_it_stands():
    beside = [[-900.0, 200.0, 0.0], [-700.0, 1200.0, 1100.0]]
    low = [[-1500.0, 200.0, 0.0], [1500.0, 1200.0, 20.0]]
    assert sight().bow_shows
    assert sight(droplets__box_m=beside, camera__azimuth_deg=-40.0).bow_shows
    assert not sight(droplets__box_m=beside, camera__azimuth_deg=40.0).rain_shows
    # 20 m of rain 200 m away: the feet of the bow alone, 35 to 37 degrees to the sides.
    assert sight(droplets__box_m=low).bow_shows
    feet = sight(droplets__box_m=low, camera__fov_deg=60.0)
    assert feet.rain_shows
    assert not feet.bow_shows


def test_a_far_away_shower_is_not_missed():
    speck = [[-5.0, 9000.0, 3700.0], [5.0, 9010.0, 3710.0]]  # 22.4 degrees up, 0.06 across
    assert sight(droplets__box_m=speck).rain_shows


def test_turning_is_what_another_camera_sees():
    turned = sight(camera__azimuth_deg=30.0, camera__altitude_deg=-5.0).turned(130.0, 40.0)
    other = sight(camera__azimuth_deg=130.0, camera__altitude_deg=40.0)
    np.testing.assert_allclose(turned.view.basis, other.view.basis, atol=1e-12)
    assert turned.looking_deg == pytest.approx((130.0, 40.0))
    wide = sight(camera__fov_deg=100.0)
    np.testing.assert_allclose(sight().widened(100.0).view.basis, wide.view.basis, atol=1e-12)


def test_the_bow_of_a_lamp_is_seen_opposite_it():
    """A lamp 10 m behind an eye in the rain and level with it: drops near the eye show its bow 42
    degrees from what is ahead, those farther away at more, and none at less."""
    lamp = [{"type": "point", "position_m": [0.0, -10.0, 1.6], "luminous_flux_lm": 1000.0}]
    box = [[-50.0, -50.0, -50.0], [50.0, 50.0, 50.0]]
    shared = {"light": lamp, "droplets__box_m": box, "camera__fov_deg": 5.0}
    assert sight(**shared, camera__altitude_deg=46.0).bow_shows
    assert not sight(**shared, camera__altitude_deg=34.0).bow_shows


def test_the_box_shrinks_to_where_drops_are():
    number = np.zeros((5, 3, 1), np.float32)
    number[2, 0] = 1.0
    box = np.array([[0.0, 0.0, 0.0], [4.0, 2.0, 1.0]])
    volume = DropletVolume(box, np.ones_like(number), number)
    np.testing.assert_allclose(volume.filled_box_m, [[1.0, 0.0, 0.0], [3.0, 1.0, 1.0]])
    assert DropletVolume(box, np.ones_like(number), 0.0 * number).filled_box_m is None
