"""The Earth's shadow against places looked at one by one, from its centre and in all digits."""

import moderngl
import numpy as np
import pytest

from glsl_probe import probe
from rtbow.physics.air.earth_shadow import (
    edge_height_m,
    place_over_sphere,
    shadow_reaches,
    shadow_span,
)
from rtbow.physics.air.rayleigh import (
    ALTITUDE_CURVE,
    MAX_HEIGHT_M,
    column_table,
    horizon_rad,
    sun_column,
)
from rtbow.render.uniforms import shadow_uniforms
from rtbow.world.lights import Sun
from textbook import EARTH_M, H0_M, column_along_ray, towards

EYE = np.array([4e5, -3e5, 700.0])
"""Far from the origin of the scene: the sphere touches sea level below the eye."""


def from_centre(places, eye=EYE):
    return places - np.array([eye[0], eye[1], -EARTH_M])


def is_dark(places, sun, eye=EYE):
    """Whether the Earth is in the way of the straight line from a place to the sun."""
    q = from_centre(places, eye)
    along = q @ sun
    nearest = np.linalg.norm(q - along[..., None] * sun, axis=-1)
    return (along < 0.0) & (nearest < EARTH_M)


def lines(rng, count):
    """Places near the eye, directions and suns; most of them near the horizon."""
    places = EYE + rng.uniform(-1.0, 1.0, (count, 3)) * [2e4, 2e4, 1.0]
    places[:, 2] = rng.uniform(0.0, 4000.0, count)
    rise = np.radians(rng.choice([2.0, 20.0, 90.0], count) * rng.uniform(-1.0, 1.0, count))
    azimuth = rng.uniform(0.0, 2.0 * np.pi, count)
    rays = np.stack(
        [np.cos(rise) * np.sin(azimuth), np.cos(rise) * np.cos(azimuth), np.sin(rise)], axis=-1
    )
    suns = [towards(rng.uniform(0.0, 360.0), rng.uniform(-2.0, 0.3)) for _ in range(count)]
    return places, rays, suns


def test_shadow_of_a_line_is_that_of_its_places(rng):
    along = np.linspace(-60e3, 60e3, 4001)
    crossings = [0, 0, 0]
    for place, ray, sun in zip(*lines(rng, 400), strict=True):
        begin, end = shadow_span(place, ray, EYE, sun)
        dark = is_dark(place + along[:, None] * ray, sun)
        inside = (along > begin) & (along < end)
        # Rounding decides within micrometres of an edge; lines that graze it are within for long.
        sure = (np.abs(along - begin) > 1e-3) & (np.abs(along - end) > 1e-3)
        np.testing.assert_array_equal(dark[sure], inside[sure])
        crossings[np.count_nonzero(np.diff(dark))] += 1
    assert min(crossings) > 10  # lines that do not cross the edge, that do once, and twice


def test_lines_along_the_axis():
    for altitude, dark in ((-1.0, True), (-0.8, False)):
        # The edge is 970 m up at -1 degree, 621 m at -0.8.
        sun = towards(70.0, altitude)
        begin, end = shadow_span(EYE, -sun, EYE, sun)
        assert (begin < 0.0 < end) == dark
        assert not dark or end > 1e9


@pytest.mark.parametrize(
    ("altitude_deg", "edge_m"), [(-0.1, 9.7036), (-1.0, 970.49), (-2.0, 3883.2)]
)
def test_edge_over_the_eye(altitude_deg, edge_m):
    # R (1/cos - 1), worked by hand for R = 6371 km.
    assert float(edge_height_m(np.radians(altitude_deg))) == pytest.approx(edge_m, rel=1e-4)
    foot = np.array([EYE[0], EYE[1], 0.0])
    _, end = shadow_span(foot, np.array([0.0, 0.0, 1.0]), EYE, towards(180.0, altitude_deg))
    assert end == pytest.approx(edge_m, rel=1e-4)


def test_edge_rises_away_from_the_sun():
    sun = towards(180.0, -1.0)
    up = np.array([0.0, 0.0, 1.0])
    heights = [
        float(shadow_span(np.array([EYE[0], EYE[1] + y, 0.0]), up, EYE, sun)[1])
        for y in (-10e3, 0.0, 10e3)
    ]
    # By the tangent of its altitude: 17.5 m per km, along a straight line.
    np.testing.assert_allclose(np.diff(heights), 10e3 * np.tan(np.radians(1.0)), rtol=1e-6)


def test_places_over_the_sphere(rng):
    places = EYE + rng.uniform(-3e4, 3e4, (500, 3)) * [1.0, 1.0, 0.1]
    sun = towards(200.0, -1.2)
    height, altitude = place_over_sphere(places, EYE, sun)
    q = from_centre(places)
    radius = np.linalg.norm(q, axis=-1)
    np.testing.assert_allclose(height, radius - EARTH_M, rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(altitude, np.arcsin(q @ sun / radius), rtol=0.0, atol=1e-12)
    # 10 km away from the sun it stands 10 km over the radius lower, and the ground 7.8 m.
    far = EYE - 10e3 * np.array([sun[0], sun[1], 0.0]) / np.hypot(sun[0], sun[1])
    height, altitude = place_over_sphere(far, EYE, sun)
    assert float(height) - 700.0 == pytest.approx(1e8 / (2.0 * EARTH_M), rel=1e-3)
    assert float(altitude) == pytest.approx(np.radians(-1.2) - 10e3 / EARTH_M, abs=2e-7)


@pytest.mark.parametrize("low_m", [0.0, 5.0, 300.0])
def test_boxes_that_the_shadow_reaches(rng, low_m):
    reached = 0
    for _ in range(60):
        corner = EYE + rng.uniform(-15e3, 15e3, 3)
        box = np.stack([corner, corner + rng.uniform(100.0, 10e3, 3)])
        box[:, 2] = low_m, 2000.0
        sun = towards(rng.uniform(0.0, 360.0), rng.uniform(-1.0, 0.2))
        sides = [np.linspace(box[0, a], box[1, a], n) for a, n in ((0, 60), (1, 60), (2, 5))]
        dark = is_dark(np.stack(np.meshgrid(*sides), axis=-1), sun)
        got = shadow_reaches(box, EYE, sun)
        assert got or not dark.any()
        # A shadow no larger than the grid's meshes is none of theirs.
        if got and not dark.any():
            lower = np.stack([box[0] - np.array([0.0, 0.0, 0.2]), box[1]])
            sides[2] = np.linspace(lower[0, 2], lower[1, 2], 5)
            assert is_dark(np.stack(np.meshgrid(*sides), axis=-1), sun).any()
        reached += got
    assert 5 < reached < 55


# --- In the shader -----------------------------------------------------------------------------

DEFINES = {
    "EARTH_RADIUS_M": EARTH_M,
    "SCALE_HEIGHT_M": H0_M,
    "MAX_HEIGHT_M": MAX_HEIGHT_M,
    "ALTITUDE_CURVE": ALTITUDE_CURVE,
    "PIECES": 3,
}
INPUTS = {"sunTowards": "towards", "clear": "clear", "outward": "outward", "sunward": "sunward"}
SHADOW = "EarthShadow(sunTowards, clear, outward, sunward)"


def rounded(values):
    return np.float64(np.float32(values))


def shader_inputs(suns, eyes):
    """The numbers of a shadow for each case, rounded as the shader gets them."""
    numbers = [
        shadow_uniforms(Sun(sun, float(np.arcsin(sun[2])), 0.0, None), eye)
        for sun, eye in zip(suns, eyes, strict=True)
    ]
    return {name: np.array([n[key] for n in numbers]) for name, key in INPUTS.items()}


def height(eye, ray, sun, distance):
    """Height of a place along a ray over the cylinder of the shadow."""
    q = from_centre(eye + distance * ray, eye)
    return np.linalg.norm(q - (q @ sun) * sun) - EARTH_M


class TestGlsl:
    def test_shadow_span(self, gl, rng):
        count = 3000
        _, rays, suns = lines(rng, count)
        eyes = np.zeros((count, 3))
        eyes[:, 2] = rng.uniform(0.0, 4000.0, count)
        rays = rounded(rays)
        rays[0], rays[1] = rounded(suns[0]), rounded(-suns[1])  # along the axis
        got = probe(
            gl, ["air/earth_shadow.glsl"], f"shadowSpan({SHADOW}, ray)",
            {"ray": rays, **shader_inputs(suns, eyes)}, DEFINES,
        )[:, :2].astype(np.float64)  # fmt: skip
        crossed = 0
        for k in range(count):
            exact = np.array(shadow_span(eyes[k], rays[k], eyes[k], suns[k]))
            seen = got[k, 0] < 1e38
            if seen != (exact[0] < exact[1]):
                # Where only one of both finds the shadow, it is less than a graze.
                middle = (got[k] if seen else exact).mean()
                assert height(eyes[k], rays[k], suns[k], middle) > -0.01
            if not seen:
                continue
            for ours, theirs in zip(got[k], exact, strict=True):
                if 0.0 < theirs < 60e3:
                    # How far what was found is from the cylinder, or from the terminator.
                    off = height(eyes[k], rays[k], suns[k], ours)
                    along = abs(from_centre(eyes[k] + ours * rays[k], eyes[k]) @ suns[k])
                    worst = min(abs(off), along)
                    assert worst < 0.01, (ours, theirs)
                    crossed += 1
        assert crossed > 1000

    def test_column_over_the_sphere(self, gl, rng):
        count = 2000
        _, rays, suns = lines(rng, count)
        eyes = np.zeros((count, 3))
        eyes[:, 2] = rounded(rng.uniform(0.0, 4000.0, count))
        rays, distance = rounded(rays), rounded(rng.uniform(0.0, 20e3, count))
        data = np.ascontiguousarray(column_table().log_column)
        texture = gl.ctx.texture(data.shape[::-1], 1, data, dtype="f4")
        texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        texture.repeat_x = texture.repeat_y = False
        got = probe(
            gl, ["air/earth_shadow.glsl"],
            f"columnOverSphere(columnTable, {SHADOW}, eyeHeight, ray, distance)",
            {"ray": rays, "distance": distance, "eyeHeight": eyes[:, 2],
             **shader_inputs(suns, eyes)},
            DEFINES, textures={"columnTable": texture},
        )[:, 0]  # fmt: skip
        heights, altitudes = np.empty(count), np.empty(count)
        for k in range(count):
            place = eyes[k] + distance[k] * rays[k]
            heights[k], altitudes[k] = place_over_sphere(place, eyes[k], suns[k])
        lit = (altitudes > horizon_rad(heights) + 1e-7) & (heights > 0.0)
        assert np.count_nonzero(lit) > 500
        exact = sun_column(heights[lit], altitudes[lit])
        np.testing.assert_allclose(got[lit], exact, rtol=1e-4)  # the table's own 7e-5
        # And a few by quadrature along the straight line through shells.
        for k in np.flatnonzero(lit)[:5]:
            exact = column_along_ray(heights[k], altitudes[k])
            assert got[k] == pytest.approx(exact, rel=2e-4)
