"""GLSL functions of method ``fast`` against float64 at the same float32 inputs, on each backend."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import moderngl
import numpy as np
import pytest

from glsl_probe import probe, rounded, unit_vectors
from rtbow.base.limits import NO_PLANE
from rtbow.gl.glsl import Define
from rtbow.physics.air import rayleigh
from rtbow.physics.constants import EARTH_RADIUS_M, SCALE_HEIGHT_M
from rtbow.physics.drop.airy import RADIUS_POWER
from rtbow.physics.geometry import box_span
from rtbow.render.colours.table import RIGHT_ANGLE_CHORD, folded_chord
from rtbow.render.fast.shared import DARK

TABLE: Mapping[str, Define] = {
    "RIGHT_ANGLE_CHORD": RIGHT_ANGLE_CHORD,
    "SEVERAL_RADII": False,
    "POLARIZER": False,
    "COLUMN_DEGREE": 0,
    "RAIN_COLOUR": False,
    "COMPONENTS": 1,
    "RADIUS_ROWS": 1,
}
ROOT2 = np.sqrt(2.0)


def uploaded(gl: Any, rows: np.ndarray) -> moderngl.Texture:
    """A table of rows (rows, columns, 4) as the programs read it."""
    data = np.ascontiguousarray(rows, dtype=np.float32)
    texture = gl.ctx.texture((rows.shape[1], rows.shape[0]), 4, data, dtype="f4")
    texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
    texture.repeat_x = texture.repeat_y = False
    return texture


# --- Angles along the table -------------------------------------------------------------------


class TestFoldedChord:
    def chords(self, gl, u, v):
        return probe(gl, ["fast/colours.glsl"], "foldedChord(u, v)", {"u": u, "v": v}, TABLE)[:, 0]

    def test_any_angle(self, gl, rng):
        count = 20_000
        u, beside = unit_vectors(rng, count), unit_vectors(rng, count)
        beside -= (beside * u).sum(axis=1, keepdims=True) * u
        beside /= np.linalg.norm(beside, axis=1, keepdims=True)
        tiny = 10.0 ** rng.uniform(-7.0, 0.0, count)
        kind = np.arange(count) % 4
        angle = np.select(
            [kind == 0, kind == 1, kind == 2],
            [tiny, np.pi - tiny, 0.5 * np.pi + rng.choice([-1.0, 1.0], count) * tiny],
            rng.uniform(0.0, np.pi, count),
        )[:, None]
        u, v = rounded(u), rounded(np.cos(angle) * u + np.sin(angle) * beside)
        a, b = (w / np.linalg.norm(w, axis=1, keepdims=True) for w in (u, v))
        theta = 2.0 * np.arctan2(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))
        got, exact = self.chords(gl, u, v), folded_chord(theta)
        # Worst 2.4e-7, a unit of the last place of 2 sqrt(2).
        np.testing.assert_allclose(got, exact, rtol=0.0, atol=4e-7)
        # Digits are kept at the forward pole; at the other one a place of 2.8 is all there is.
        near = theta < 0.1
        np.testing.assert_allclose(got[near], exact[near], rtol=0.0, atol=1e-7)

    def test_poles(self, gl, rng):
        u = unit_vectors(rng, 300)
        np.testing.assert_array_equal(self.chords(gl, u, u), 0.0)
        np.testing.assert_allclose(self.chords(gl, u, -u), 2.0 * ROOT2, rtol=1e-7)


def places(rng):
    """Distances of a lamp from a ray, and places along it from the foot, over all sizes."""
    side = rounded(10.0 ** rng.uniform(-3.0, 5.0, 8000))
    place = rng.choice([-1.0, 1.0], 8000) * 10.0 ** rng.uniform(-4.0, 5.0, 8000)
    place[:20] = 0.0
    place[20:40] = side[20:40]
    place[40:60] = -side[40:60]
    return side, rounded(place)


def test_folded_chord_along_a_ray(gl, rng):
    side, place = places(rng)
    got = probe(gl, ["fast/colours.glsl"], "foldedChordAt(side, place)",
                {"side": side, "place": place}, TABLE)[:, 0]  # fmt: skip
    # Light runs from the lamp to the drop: along the ray before the foot, and against it behind.
    exact = folded_chord(np.arctan2(side, -place))
    # Worst 3.5e-7, of 2 sqrt(2) less a chord.
    np.testing.assert_allclose(got, exact, rtol=0.0, atol=6e-7)
    ahead = place < 0.0
    np.testing.assert_allclose(got[ahead], exact[ahead], rtol=6e-7)


def test_slope_of_the_folded_chord(gl, rng):
    side, place = places(rng)
    got = probe(gl, ["fast/colours.glsl"], "chordSlopeAt(side, place)",
                {"side": side, "place": place}, TABLE)[:, 0]  # fmt: skip
    theta = np.arctan2(side, -place)
    exact = np.where(place > 0.0, np.sin(0.5 * theta), np.cos(0.5 * theta))
    np.testing.assert_allclose(got, exact, rtol=4e-7)
    # It is the slope of the host's own chord.
    step = 1e-6
    inner = np.abs(theta - 0.5 * np.pi) > 0.01
    inner &= (theta > 0.01) & (theta < np.pi - 0.01)
    slope = (folded_chord(theta + step) - folded_chord(theta - step)) / (2.0 * step)
    np.testing.assert_allclose(got[inner], slope[inner], rtol=1e-5)


def test_bisector(gl, rng):
    side, first = places(rng)
    span = 10.0 ** rng.uniform(-3.0, 5.0, len(side))
    last = rounded(first + span)
    got = probe(
        gl, ["light/lamp_ray.glsl"], "bisector(LampRay(side, 0.0, 0.0), first, last)",
        {"side": side, "first": first, "last": last}, {"LAMP_COUNT": 1, "NEAREST_M": 1e-3},
    )[:, 0].astype(np.float64)  # fmt: skip
    middle = 0.5 * (np.arctan2(side, -first) + np.arctan2(side, -last))
    near, far = np.hypot(side, first), np.hypot(side, last)
    terms = (np.abs(first) * far + np.abs(last) * near) / (near + far)
    # Four roundings of the two products' sizes, which cancel beside the foot.
    exact = -side / np.tan(middle)
    assert np.all(np.abs(got - exact) < 4.0 * 2.0**-24 * terms)


# --- Rows of radius ---------------------------------------------------------------------------

GROUPS = 3


class TestGatherRow:
    DEFINES: Mapping[str, Define] = {
        **TABLE, "SEVERAL_RADII": True, "NODES": True, "HAT_GROUPS": GROUPS, "RADIUS_ROWS": 24,
    }  # fmt: skip

    def weights(self, gl, row, reach, first):
        """Weights of all rows that a pass keeps (n, 12)."""
        found = [
            probe(
                gl, ["fast/sun/row_weights.glsl"],
                f"Gathered rows = nothingYet(firstRow); gatherRow(rows, table, reach, row); "
                f"result = rows.weights[{group}];",
                {"row": row, "reach": reach}, self.DEFINES,
                {"firstRow": first}, preamble="uniform ColourTable table;",
            )
            for group in range(GROUPS)
        ]  # fmt: skip
        return np.concatenate(found, axis=1).astype(np.float64)

    def test_a_drop_counts_once(self, gl, rng):
        row = rounded(np.concatenate([rng.uniform(0.0, 23.0, 2000), np.arange(24.0)]))
        reach = rounded(rng.uniform(0.0, 1e4, len(row)))
        both = np.concatenate([self.weights(gl, row, reach, f) for f in (0.0, 12.0)], axis=1)
        np.testing.assert_allclose(both.sum(axis=1), reach, rtol=2e-7)
        # At its own place, by its two neighbours alone.
        np.testing.assert_allclose(both @ np.arange(24.0), reach * row, rtol=2e-6, atol=1e-3)
        assert np.all(np.count_nonzero(both, axis=1) <= 2)

    def test_drops_add_up(self, gl):
        found = probe(
            gl, ["fast/sun/row_weights.glsl"],
            "Gathered rows = nothingYet(0.0); gatherRow(rows, table, a, 0.25);"
            " gatherRow(rows, table, b, 1.5); result = rows.weights[0];",
            {"a": [4.0], "b": [2.0]}, self.DEFINES, preamble="uniform ColourTable table;",
        )  # fmt: skip
        np.testing.assert_allclose(found[0], [3.0, 2.0, 1.0, 0.0])


@pytest.mark.parametrize("polarizer", [False, True])
def test_colours_between_rows_and_texels(gl, rng, polarizer):
    rows, columns = 5, 9
    both = rng.uniform(0.0, 3.0, (2 * rows, columns, 4))
    defines = {**TABLE, "SEVERAL_RADII": True, "NODES": False, "RADIUS_ROWS": rows,
               "POLARIZER": polarizer}  # fmt: skip
    texel, row = rounded(rng.uniform(-2.0, 10.0, 500)), rounded(rng.uniform(-1.0, 6.0, 500))
    share = rounded(rng.uniform(0.0, 1.0, 500))
    got = probe(
        gl, ["fast/colours.glsl"], "colourOf(colours, texel, row, share)",
        {"texel": texel, "row": row, "share": share}, defines,
        textures={"colours": uploaded(gl, both)},
    )[:, :3]  # fmt: skip
    x, y = np.clip(texel, 0.0, columns - 1.0), np.clip(row, 0.0, rows - 1.0)
    i, j = np.minimum(x.astype(int), columns - 2), np.minimum(y.astype(int), rows - 2)
    fx, fy = (x - i)[:, None], (y - j)[:, None]

    def bilinear(table):
        low = table[j, i] * (1.0 - fx) + table[j, i + 1] * fx
        return (low * (1.0 - fy) + fy * (table[j + 1, i] * (1.0 - fx) + table[j + 1, i + 1] * fx))[
            :, :3
        ]

    exact = bilinear(both[:rows])
    if polarizer:
        exact = 0.5 * (share[:, None] * exact + (1.0 - share[:, None]) * bilinear(both[rows:]))
    # Filtered by the device, whose weights have 8 bits or more.
    np.testing.assert_allclose(got, exact, rtol=0.0, atol=3.0 * 2.0**-8)


# --- Air and rain -----------------------------------------------------------------------------


@pytest.mark.parametrize("degree", [0, 1, 3, 5])
@pytest.mark.parametrize("rain", [False, True])
@pytest.mark.parametrize("several", [False, True])
def test_fall_off(gl, rng, degree, rain, several):
    rows, columns = (4, 7) if several else (1, 7)
    scale = 0.3 ** np.arange(1, degree + 1)
    table = rng.uniform(0.0, 1.0, (rows + degree + rain, columns, 4))
    for k in range(degree):
        table[rows + k] = scale[k] * rng.uniform(-1.0, 1.0, (columns, 4))
    table = rounded(table)
    defines = {**TABLE, "SEVERAL_RADII": several, "NODES": False, "RADIUS_ROWS": rows,
               "COLUMN_DEGREE": degree, "RAIN_COLOUR": rain}  # fmt: skip
    texel = np.concatenate([np.arange(7.0), rounded(rng.uniform(0.0, 6.0, 500))])
    column, depth = (rounded(rng.uniform(low, 2.0, len(texel))) for low in (-2.0, 0.0))
    got = probe(
        gl, ["fast/colours.glsl"], "fallOff(colours, texel, column, depth)",
        {"texel": texel, "column": column, "depth": depth}, defines,
        textures={"colours": uploaded(gl, table)},
    )[:, :3]  # fmt: skip
    left = np.minimum(texel.astype(int), columns - 2)
    share = (texel - left)[:, None, None]
    at = (table[:, left].transpose(1, 0, 2) * (1.0 - share)
          + table[:, left + 1].transpose(1, 0, 2) * share)[..., :3]  # fmt: skip
    powers = column[:, None] ** np.arange(1, degree + 1)
    logarithm = np.einsum("nk,nkc->nc", powers, at[:, rows : rows + degree])
    if rain:
        logarithm = logarithm + at[:, -1] * depth[:, None]
    # 2e-6 by Mesa's exp; rows of several radii are filtered by the device.
    np.testing.assert_allclose(got, np.exp(logarithm), rtol=2e-2 if several else 4e-6)


PATH: Mapping[str, Define] = {
    **TABLE,
    "EARTH_RADIUS_M": EARTH_RADIUS_M,
    "SCALE_HEIGHT_M": SCALE_HEIGHT_M,
    "MAX_HEIGHT_M": rayleigh.MAX_HEIGHT_M,
    "ALTITUDE_CURVE": rayleigh.ALTITUDE_CURVE,
    "RADIUS_POWER": RADIUS_POWER,
    "NO_PLANE": NO_PLANE,
    "DARK": DARK,
    "MAX_STEPS": 1000,
    "LEAST_STEPS": 1,
    "GRID": False,
    "AIR": True,
    "EXTINCTION": False,
    "ATTENUATION": False,
    "SUN": True,
    "SHADOW": False,
}


class TestColumn:
    CUBIC = (0.3, -2e-4, 1e-8, -3e-13)

    def columns(self, gl, eye, ray, distance, near):
        names = {
            "air.eyeHeight": eye,
            "air.perMetre": float(rayleigh.segment_column(eye, 0.0, 1.0)),
            "air.sunward": self.CUBIC,
        }
        return probe(
            gl, ["fast/air.glsl"], "columnAt(air, distance * ray, ray, distance)",
            {"ray": ray, "distance": distance}, {**PATH, "NEAR_AIR": near}, names,
            preamble="uniform Columns air;",
        )[:, 0]  # fmt: skip

    @pytest.mark.parametrize("eye", [0.0, 1.6, 2000.0])
    @pytest.mark.parametrize("near", [False, True])
    def test_is_the_closed_form(self, gl, rng, eye, near):
        ray = rounded(unit_vectors(rng, 3000))
        distance = rounded(10.0 ** rng.uniform(0.0, 4.0, 3000))
        # As high or low as the host takes the series for near: 0.6 of the scale height.
        far = np.abs(ray[:, 2]) * distance > 0.6 * SCALE_HEIGHT_M
        ray, distance = ray[~far], distance[~far]
        height = eye + ray[:, 2] * distance
        exact = np.polynomial.polynomial.polyval(height, self.CUBIC)
        segment = rayleigh.segment_column(eye, ray[:, 2], distance)
        got = self.columns(gl, eye, ray, distance, near)
        # The series' first term left out is u^5/720: 1.1e-4 at 0.6.
        bound = (1.5e-4 if near else 2e-6) * segment + 4e-7
        assert np.all(np.abs(got - exact - segment) < bound)

    def test_along_the_horizon(self, gl):
        got = self.columns(gl, 0.0, [[0.0, 1.0, 0.0]], [799.4], True)
        np.testing.assert_allclose(got, self.CUBIC[0] + 0.1, rtol=1e-6)

    @pytest.mark.parametrize("near", [False, True])
    def test_what_the_grey_part_leaves(self, gl, near):
        column = rounded(np.linspace(-2.0, 2.0, 401))
        got = probe(
            gl, ["fast/air.glsl"], "greyLeft(air, column)", {"column": column},
            {**PATH, "NEAR_AIR": near}, {"air.grey": 0.15}, preamble="uniform Columns air;",
        )[:, 0]  # fmt: skip
        # A depth of 0.3 at most, whose fifth power over 120 is left out.
        np.testing.assert_allclose(got, np.exp(-0.15 * column), rtol=3e-5 if near else 1.5e-6)


# --- Directions that a box's slabs divide by ---------------------------------------------------


class TestSpecialDirections:
    LOW, HIGH = np.array([-3.0, 2.0, -1.0]), np.array([5.0, 10.0, 7.0])

    @pytest.mark.parametrize("tiny", [0.0, -0.0, 1e-38, -1e-38, 1e-31, -1e-31])
    @pytest.mark.parametrize(
        "at",
        [
            "inside",
            "on low",
            "on high",
            "beside",
        ],
    )
    def test_a_component_that_all_but_vanishes(self, gl, tiny, at):
        """Along a face a ray is inside, beside the box it never enters; whatever the rounding."""
        rays, lows, highs, expected = [], [], [], []
        for axis in range(3):
            other, third = (axis + 1) % 3, (axis + 2) % 3
            eye = 0.5 * (self.LOW + self.HIGH)
            eye[axis] = {
                "inside": eye[axis], "on low": self.LOW[axis], "on high": self.HIGH[axis],
                "beside": self.HIGH[axis] + 1e-3,
            }[at]  # fmt: skip
            eye[other] = self.LOW[other] - 2.0
            for share in (0.0, 0.1):
                ray = np.zeros(3)
                ray[axis], ray[other], ray[third] = tiny, np.sqrt(1.0 - share**2), share
                rays.append(ray)
                lows.append(self.LOW - eye)
                highs.append(self.HIGH - eye)
                exact = ray.copy()
                exact[axis] = 0.0
                entry, leave = box_span(np.zeros(3), exact[None], np.stack([lows[-1], highs[-1]]))
                expected.append((entry[0], leave[0]))
        got = probe(gl, ["common/box.glsl"], "boxSpan(ray, low, high)",
                    {"ray": rays, "low": lows, "high": highs})[:, :2]  # fmt: skip
        assert not np.isnan(got).any()
        for (entry, leave), (first, last) in zip(got, expected, strict=True):
            assert (entry < leave) == (first < last)
            if first < last:
                np.testing.assert_allclose((entry, leave), (first, last), rtol=1e-6)

    @pytest.mark.parametrize("axis", [0, 1, 2])
    @pytest.mark.parametrize("sign", [-1.0, 1.0])
    def test_along_an_axis_from_within(self, gl, axis, sign):
        ray = sign * np.eye(3)[axis]
        low, high = np.array([-1.0, -2.0, -3.0]), np.array([4.0, 5.0, 6.0])
        got = probe(gl, ["common/box.glsl"], "boxSpan(ray, low, high)",
                    {"ray": ray[None], "low": low[None], "high": high[None]})[0, :2]  # fmt: skip
        np.testing.assert_allclose(got, [0.0, (high if sign > 0.0 else -low)[axis]], rtol=1e-6)
