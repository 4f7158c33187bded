"""Air columns against adaptive quadrature along the ray, and the column texture in GLSL."""

from functools import lru_cache

import moderngl
import numpy as np
import pytest
from scipy.integrate import quad

from glsl_probe import probe
from rtbow.physics.air.rayleigh import (
    ALTITUDE_CURVE,
    MAX_HEIGHT_M,
    column_table,
    horizon_rad,
    rayleigh_depth,
    segment_column,
    sun_column,
)
from textbook import EARTH_M, H0_M, column_along_ray, density


@pytest.mark.parametrize(
    ("wavelength_nm", "depth"),
    [
        (400.0, 0.36022),
        (450.0, 0.22111),
        (500.0, 0.14336),
        (550.0, 0.09707),
        (600.0, 0.06809),
        (650.0, 0.04919),
        (700.0, 0.03642),
    ],
)
def test_rayleigh_depth_is_the_papers(wavelength_nm, depth):
    # Bodhaine et al. 1999, table 3. Their equation 30 fits it to 1.3e-5.
    assert rayleigh_depth(np.array(wavelength_nm)) == pytest.approx(depth, abs=2e-5)


def test_rayleigh_depth_is_its_equation():
    # Worked by hand from equation 30.
    got = rayleigh_depth(np.array([400.0, 500.0, 650.0]))
    np.testing.assert_allclose(got, [0.360213, 0.143353, 0.049184], atol=6e-7)


def test_blue_is_scattered_by_the_fourth_power():
    depth = rayleigh_depth(np.array([400.0, 800.0]))
    # A little more than 2^4: the index of air and its anisotropy grow towards the blue.
    assert 16.0 < depth[0] / depth[1] < 17.5


@pytest.mark.parametrize(
    ("altitude_deg", "column"),
    [
        (0.0, 35.399),
        (1.0, 24.873),
        (2.0, 18.669),
        (3.0, 14.720),
        (5.0, 10.141),
        (10.0, 5.551),
        (20.0, 2.897),
        (30.0, 1.993),
        (90.0, 1.0),
    ],
)
def test_columns_from_sea_level(altitude_deg, column):
    got = float(sun_column(np.array(0.0), np.radians(altitude_deg)))
    assert got == pytest.approx(column, abs=6e-4)


@pytest.mark.parametrize(
    ("altitude_deg", "air_mass", "within"),
    # Kasten and Young 1989, with refraction and a real atmosphere.
    [
        (0.0, 38.09, 0.075),
        (1.0, 26.26, 0.055),
        (5.0, 10.316, 0.02),
        (10.0, 5.584, 0.007),
        (20.0, 2.904, 0.003),
        (30.0, 1.994, 0.001),
    ],
)
def test_columns_are_near_the_air_mass(altitude_deg, air_mass, within):
    got = float(sun_column(np.array(0.0), np.radians(altitude_deg)))
    assert (1.0 - within) * air_mass < got < air_mass


@pytest.mark.parametrize("height_m", [0.0, 3.0, 500.0, 5000.0, 20_000.0, 50_000.0])
def test_columns_by_quadrature(height_m):
    horizon = float(horizon_rad(np.array(height_m)))
    altitudes = np.concatenate(
        [
            np.radians([90.0, 60.0, 20.0, 5.0, 1.0, 0.1, 1e-4, 0.0]),
            horizon * np.array([0.01, 0.3, 0.9, 0.999, 0.999999]),
        ]
    )
    got = sun_column(np.array(height_m), altitudes)
    expected = [column_along_ray(height_m, altitude) for altitude in altitudes]
    np.testing.assert_allclose(got, expected, rtol=3e-12)  # worst 9e-13


def test_horizon_is_where_the_ray_grazes_the_ground():
    heights = np.array([0.0, 1.0, 100.0, 20_000.0])
    # The closest point to the Earth's centre is one radius away.
    closest = (EARTH_M + heights) * np.cos(horizon_rad(heights))
    np.testing.assert_allclose(closest, EARTH_M, rtol=1e-15)
    assert np.all(horizon_rad(heights) <= 0.0)
    assert horizon_rad(np.array(1.0)) == pytest.approx(-np.sqrt(2.0 / EARTH_M), rel=1e-6)


@pytest.mark.parametrize("height_m", [0.0, 100.0, 20_000.0])
def test_no_light_through_the_earth(height_m):
    horizon = float(horizon_rad(np.array(height_m)))
    below = sun_column(np.array(height_m), horizon - np.array([1e-9, 1e-3, 0.5, 1.4]))
    assert np.all(np.isposinf(below))
    assert np.isfinite(sun_column(np.array(height_m), horizon + 1e-9))


def test_columns_broadcast():
    got = sun_column(np.zeros((3, 1)), np.radians([10.0, 20.0]))
    assert got.shape == (3, 2)
    assert np.all(got[:, 0] > got[:, 1])


@pytest.mark.parametrize("height_m", [0.0, 1.6, 3000.0])
@pytest.mark.parametrize("rise", [0.0, 1e-12, 1e-6, 0.3, 1.0, -1e-6, -0.3, -1.0])
@pytest.mark.parametrize("length_m", [0.0, 1.0, 1234.5, 50_000.0])
def test_segment_in_flat_shells(height_m, rise, length_m):
    expected, _ = quad(
        lambda t: density(height_m + rise * t) / H0_M, 0.0, length_m, epsabs=1e-16, epsrel=1e-13
    )
    got = float(segment_column(height_m, np.array(rise), np.array(length_m)))
    assert got == pytest.approx(expected, rel=1e-12, abs=1e-16)


@pytest.mark.parametrize(
    ("length_m", "within"),
    [(2000.0, 1e-4), (20_000.0, 3e-3)],
)
@pytest.mark.parametrize("rise", [0.0, 0.02, 0.5, 1.0])
def test_flat_shells_are_near_the_round_earth(length_m, within, rise):
    exact = column_along_ray(0.0, np.arcsin(rise), length_m)
    got = float(segment_column(0.0, np.array(rise), np.array(length_m)))
    # Worst 1.0e-5 over 2 km and 8.3e-4 over 20 km.
    assert got == pytest.approx(exact, rel=within)


# Nearer to the horizon than this, float32 cannot say on which side an altitude is.
SLIVER_RAD = 2e-8

DEFINES = {
    "EARTH_RADIUS_M": EARTH_M,
    "SCALE_HEIGHT_M": H0_M,
    "MAX_HEIGHT_M": MAX_HEIGHT_M,
    "ALTITUDE_CURVE": ALTITUDE_CURVE,
}


@lru_cache
def table():
    return column_table().log_column


def glsl_sun_column(gl, height_m, altitude_rad):
    data = np.ascontiguousarray(table())
    texture = gl.ctx.texture(data.shape[::-1], 1, data, dtype="f4")
    texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
    texture.repeat_x = texture.repeat_y = False
    return probe(
        gl,
        ["air/atmosphere.glsl"],
        "sunColumn(columnTable, height, altitude)",
        {"height": height_m, "altitude": altitude_rad},
        DEFINES,
        textures={"columnTable": texture},
    )[:, 0]


def rounded(values):
    return np.float64(np.float32(values))


class TestGlsl:
    def test_column_texture(self, gl, rng):
        count = 8000
        height = rounded(MAX_HEIGHT_M * rng.random(3 * count) ** rng.choice([1.0, 2.0], 3 * count))
        altitude = np.radians(rng.uniform(-2.0, 90.0, 3 * count))
        altitude[count : 2 * count] = np.radians(rng.uniform(-2.0, 2.0, count))
        # On both sides of the horizon, at every distance.
        side = rng.choice([-1.0, 1.0], count) * 10.0 ** rng.uniform(-7.5, -1.5, count)
        altitude[2 * count :] = horizon_rad(height[2 * count :]) + side
        altitude = rounded(altitude)
        altitude[0], height[0] = np.float32(np.pi / 2), 0.0
        altitude[1], height[1] = 0.0, MAX_HEIGHT_M
        above = altitude - horizon_rad(height)
        clear = np.abs(above) > SLIVER_RAD
        assert np.mean(clear) > 0.99
        got = glsl_sun_column(gl, height, altitude)
        dark = above < 0.0
        assert np.all(got[clear & dark] > 1e29)
        lit = clear & ~dark
        error = got[lit] / sun_column(height[lit], altitude[lit]) - 1.0
        assert np.abs(error).max() < 1e-4  # worst 7e-5

    def test_dark_is_dark_for_the_most_transparent_light(self, gl):
        (column,) = glsl_sun_column(gl, [0.0], [-0.01])
        assert np.exp(-rayleigh_depth(np.array(780.0)) * column) == 0.0

    @pytest.mark.parametrize(
        ("height_m", "within"),
        # Measured for altitudes of 0 to 90 degrees: 3.5e-5, 3.9e-4, 7.8e-4, 2.4e-3, at 0 degrees;
        # a fifth of that at 5. The column itself is then below 1e-1 of its value at 20 km.
        [(20_500.0, 1e-4), (25_000.0, 5e-4), (30_000.0, 1e-3), (50_000.0, 3e-3)],
    )
    def test_above_the_texture(self, gl, height_m, within):
        altitude = rounded(np.radians(np.linspace(0.0, 90.0, 181)))
        height = np.full(181, height_m)
        got = glsl_sun_column(gl, height, altitude)
        np.testing.assert_allclose(got, sun_column(height, altitude), rtol=within)

    def test_horizon(self, gl):
        height = rounded(np.concatenate([[0.0, 1e-3, 1.6], np.geomspace(10.0, MAX_HEIGHT_M, 200)]))
        got = probe(
            gl, ["air/atmosphere.glsl"], "horizonAltitude(height)", {"height": height}, DEFINES
        )
        # Worst 1.6e-7 relative, 1.3e-8 rad.
        np.testing.assert_allclose(got[:, 0], horizon_rad(height), rtol=3e-7, atol=0.0)

    def test_segment_column(self, gl, rng):
        count = 4000
        height = rounded(rng.uniform(0.0, 3000.0, count))
        distance = rounded(10.0 ** rng.uniform(-1.0, 5.0, count))
        steep = rng.choice([-1.0, 1.0], count) * 10.0 ** rng.uniform(-9.0, 0.0, count)
        rise = rounded(np.where(rng.random(count) < 0.05, 0.0, steep))
        got = probe(
            gl,
            ["air/atmosphere.glsl"],
            "segmentColumn(height, rise, distance)",
            {"height": height, "rise": rise, "distance": distance},
            DEFINES,
        )[:, 0]
        # Worst 3.9e-6: two of Mesa's exp, each within 1.1e-6, and one as 1 - exp(-u) at u = 0.05.
        np.testing.assert_allclose(got, segment_column(height, rise, distance), rtol=5e-6)
