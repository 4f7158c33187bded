"""Colours summed ahead of the march, on the host: chords, bases, tables, columns, volumes."""

from __future__ import annotations

from dataclasses import fields, replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.polynomial.polynomial import polyval
from scipy.integrate import quad

from rtbow.base.arrays import Array
from rtbow.base.limits import LEAST_DELTA_E, MOST_DELTA_E
from rtbow.physics.air import rayleigh
from rtbow.physics.air.rayleigh import NO_AIR, Column, rayleigh_depth
from rtbow.physics.light.spectrum import colour_weights, wavelength_bins
from rtbow.render.colours.basis import LightBasis, column_degree, light_basis
from rtbow.render.colours.table import (
    BakedLight,
    ColourTable,
    chords,
    colour_table,
    folded_chord,
    hat_fit,
    unfolded,
)
from rtbow.render.fast.columns import (
    eye_column,
    filled_box,
    greatest_depth,
    kind_of,
    light_shares,
    radius_spread,
    sun_columns,
)
from rtbow.render.fast.lamp import over_discs, running_colours
from rtbow.render.fast.tolerance import FastSettings, hat_rows, node_step_nm, settings_for
from rtbow.world.lights import Sun
from rtbow.world.measured.spectra import load_spectrum
from rtbow.world.rain.volume import DropletVolume

# --- Chords -----------------------------------------------------------------------------------


def angles() -> Array:
    tiny = np.geomspace(1e-9, 0.1, 200)
    right = 0.5 * np.pi
    return np.sort(
        np.concatenate(
            [[0.0], tiny, np.linspace(0.1, 3.0, 2000), right - tiny, right + tiny, np.pi - tiny,
             [np.pi]]
        )
    )  # fmt: skip


def test_chords_are_of_the_unit_circle():
    theta = np.linspace(0.0, 0.5 * np.pi, 50)
    points = np.stack([np.cos(theta), np.sin(theta)], axis=1)
    np.testing.assert_allclose(
        folded_chord(theta), np.linalg.norm(points - [1.0, 0.0], axis=1), atol=1e-15
    )
    np.testing.assert_allclose(
        folded_chord(np.pi - theta), 2.0 * np.sqrt(2.0) - folded_chord(theta), atol=1e-15
    )


def test_chords_and_angles_are_inverse():
    theta = angles()
    np.testing.assert_allclose(unfolded(folded_chord(theta)), theta, rtol=0.0, atol=1e-14)
    chord = np.linspace(0.0, 2.0 * np.sqrt(2.0), 1001)
    np.testing.assert_allclose(folded_chord(unfolded(chord)), chord, rtol=0.0, atol=1e-14)


def test_chords_rise_with_the_angle():
    rise = np.diff(folded_chord(angles()))
    step = np.diff(angles())
    far = step > 1e-12
    # Slopes of 1 at both poles, and of 1/sqrt(2) at the right angle.
    slope = rise[far] / step[far]
    assert slope.min() > np.sqrt(0.5) - 1e-3
    assert slope.max() < 1.0 + 1e-3


@pytest.mark.parametrize(
    ("low", "high"),
    [
        (0.0, np.pi),
        (0.2, 1.85),
        (2.0, 2.6),
    ],
)
def test_columns_of_a_table_lie_near_enough(low, high):
    theta = unfolded(chords(low, high, 0.004, 100_000))
    assert theta[0] == pytest.approx(low, abs=1e-12)
    assert theta[-1] == pytest.approx(high, abs=1e-12)
    assert np.diff(theta).max() <= 0.004 * (1.0 + 1e-9)
    assert len(chords(low, high, 0.004, 77)) == 77


# --- Rows of radius ---------------------------------------------------------------------------


class TestHatFit:
    FINE = np.sort(np.random.default_rng(3).uniform(-1.0, 1.0, 200))
    FINE[[0, -1]] = -1.0, 1.0
    ROWS = np.linspace(-1.0, 1.0, 9)

    def test_straight_lines_are_met(self):
        for line in (np.ones_like, lambda x: 3.0 - 2.0 * x):
            np.testing.assert_allclose(
                hat_fit(self.FINE, self.ROWS) @ line(self.FINE), line(self.ROWS), atol=1e-12
            )

    def test_no_other_rows_are_nearer(self, rng):
        value = np.sin(9.0 * self.FINE)
        rows = hat_fit(self.FINE, self.ROWS) @ value

        def error(at: Array) -> float:
            return float(np.sum((np.interp(self.FINE, self.ROWS, at) - value) ** 2))

        best = error(rows)
        for _ in range(50):
            assert error(rows + 1e-3 * rng.normal(size=len(rows))) > best
        # The rows' own values are not as near: the mean error counts.
        assert best < error(np.sin(9.0 * self.ROWS))

    def test_one_row_is_the_mean(self):
        assert hat_fit(np.arange(4.0), np.zeros(1)) @ [1.0, 2.0, 3.0, 6.0] == pytest.approx(3.0)


# --- A light behind columns of air ------------------------------------------------------------

RANGES = {
    "low": Column(0.0, 0.1), "noon": Column(1.0, 1.4), "evening": Column(10.0, 14.0),
    "any": Column(0.0, 75.0),
}  # fmt: skip
SPECTRA = ("E490", "FL2", "HP1")
by_spectrum = pytest.mark.parametrize("name", SPECTRA)
by_range = pytest.mark.parametrize("column", RANGES.values(), ids=RANGES.keys())


def fine_weights(name: str) -> tuple[Array, Array]:
    """X, Y, Z weights at 1 nm (401, 3), and the air's depths (401,)."""
    bins = wavelength_bins(1.0)
    return colour_weights(load_spectrum(name), bins), rayleigh_depth(bins.wavelength_nm)


@by_spectrum
@pytest.mark.parametrize("step_nm", [1.0, 5.0, 10.0])
def test_without_air_all_light_is_there(name, step_nm):
    basis = light_basis(load_spectrum(name), step_nm, NO_AIR)
    assert len(basis.wavelength_nm) == round(400.0 / step_nm) + 1
    np.testing.assert_allclose(
        basis.coefficients(np.zeros(1)) @ basis.weights.sum(axis=1),
        fine_weights(name)[0].sum(axis=0)[None], rtol=1e-9,
    )  # fmt: skip
    assert column_degree(basis, NO_AIR, 1e-3) == 0


@by_spectrum
@by_range
def test_a_basis_holds_every_column(rng, name, column):
    basis = light_basis(load_spectrum(name), 5.0, column)
    at = np.concatenate([[column.low, column.high], rng.uniform(column.low, column.high, 40)])
    weights, tau = fine_weights(name)
    exact = np.exp(-np.outer(at, tau)) @ weights
    got = basis.coefficients(at) @ basis.weights.sum(axis=1)
    # 4e-5 of the brightest of the three, where one basis serves all columns; 1e-5 elsewhere.
    error = np.abs(got - exact).max(axis=1) / exact.max(axis=1)
    assert error.max() < (8e-5 if column.high > 70.0 else 2e-5)


@by_spectrum
def test_the_grey_part_is_the_mean_depth(name):
    basis = light_basis(load_spectrum(name), 5.0, Column(1.0, 3.0))
    weights, tau = fine_weights(name)
    for column in (1.0, 2.0, 3.0):
        logarithm = [np.log(np.exp(-tau * (column + s)) @ weights[:, 1]) for s in (-1e-4, 1e-4)]
        slope = (logarithm[1] - logarithm[0]) / 2e-4
        assert basis.grey(column) == pytest.approx(-slope, rel=1e-6)


def left_behind(table: ColourTable, grey: float, offset: Array) -> Array:
    """X, Y, Z (K, N, 3) of a table's first row behind columns, as the shader has them."""
    first = table.rows * table.components
    coefficients = table.values[first : first + table.degree, :, :3].astype(np.float64)
    powers = offset[:, None] ** np.arange(1, table.degree + 1)
    logarithm = np.tensordot(powers, coefficients, axes=1) if table.degree else 0.0
    return table.values[0, :, :3] * np.exp(logarithm - grey * offset[:, None, None])


def white_table(basis: LightBasis, column: Column, tolerance: float) -> ColourTable:
    """Colours of drops that send back all wavelengths alike."""
    degree = column_degree(basis, column, tolerance)
    outcomes = np.repeat(basis.weights.sum(axis=1)[:, None, None, None, :], 2, axis=3)
    baked = BakedLight.of(basis, np.array([0.0, 1.0]), outcomes, np.ones(1))
    return colour_table(baked, column, degree)


@by_spectrum
@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])
@pytest.mark.parametrize("reach", [0.02, 0.2, 1.0, 4.0])
def test_the_fall_off_keeps_its_tolerance(rng, name, tolerance, reach):
    column = Column(8.0 - reach, 8.0 + reach)
    basis = light_basis(load_spectrum(name), 5.0, column)
    table = white_table(basis, column, tolerance)
    at = rng.uniform(-reach, reach, 60)
    got = left_behind(table, basis.grey(column.middle), at)[:, 0]
    weights, tau = fine_weights(name)
    exact = np.exp(-np.outer(column.middle + at, tau)) @ weights
    if table.degree < 5:
        # Up to 1.5 times as much as asked for: the degree is that of a polynomial with a free
        # constant, which here is the middle's. 1e-5 is the basis's own.
        assert np.abs(got / exact - 1.0).max() < 1.6 * tolerance + 2e-5
    else:
        assert np.abs(got / exact - 1.0).max() < 1e-2


@by_spectrum
def test_the_degree_grows_with_the_reach_and_the_precision(name):
    basis = light_basis(load_spectrum(name), 5.0, Column(0.0, 20.0))

    def degree(reach: float, tolerance: float) -> int:
        return column_degree(basis, Column(10.0 - reach, 10.0 + reach), tolerance)

    reaches = (0.0, 0.01, 0.1, 0.5, 2.0, 8.0)
    for tolerance in (1e-2, 1e-3, 1e-4):
        found = [degree(reach, tolerance) for reach in reaches]
        assert found == sorted(found)
        assert found[:2] == [0, 1]
    assert degree(8.0, 1e-4) > degree(8.0, 1e-2) >= 1


@pytest.mark.parametrize("range_", [Column(2.0, 3.0), Column(0.0, 75.0)], ids=["own", "any"])
def test_a_table_of_drops_with_colours(rng, range_):
    """A made-up cross-section whose hue goes round with the angle, of two radii."""
    column = Column(2.0, 3.0)
    basis = light_basis(load_spectrum("E490"), 5.0, range_)
    chord = np.linspace(1.9, 2.4, 41)

    def section(nm: Array, radius: float) -> Array:
        hue = 2.0 * np.pi * (nm - 380.0) / 400.0
        return radius * (1.2 + np.sin(hue[:, None] + 9.0 * chord))

    outcomes = np.stack(
        [
            np.einsum("wn,bwx->bnx", section(basis.wavelength_nm, radius), basis.weights)
            for radius in (1.0, 2.0)
        ],
        axis=1,
    )[:, None]
    degree = column_degree(basis, column, 1e-3)
    shares = np.array([0.3, 0.7])
    table = colour_table(BakedLight.of(basis, chord, outcomes, shares), column, degree)
    assert (table.rows, table.components, table.degree) == (2, 1, degree)
    assert table.values.shape == (2 + degree, 41, 4)
    assert table.first + 40 / table.per_chord == pytest.approx(chord[-1])
    np.testing.assert_allclose(table.values[1], 2.0 * table.values[0], rtol=2e-6)
    bins = wavelength_bins(1.0)
    weights, tau = fine_weights("E490")
    # Linear between the wavelengths of cross-sections.
    nodes = section(basis.wavelength_nm, 1.0)
    sections = np.stack(
        [np.interp(bins.wavelength_nm, basis.wavelength_nm, nodes[:, k]) for k in range(41)], axis=1
    )
    at = rng.uniform(-0.5, 0.5, 30)
    passed = np.exp(-np.outer(column.middle + at, tau))
    exact = np.einsum("kf,fn,fx->knx", passed, sections, weights, optimize=True)
    got = left_behind(table, basis.grey(column.middle), at)
    # 2.5e-4 at worst: hues narrow the spectrum, and the polynomial fits the better.
    assert table.fit_error < 1e-3
    assert np.abs(got / exact - 1.0).max() < 1e-3
    # Between two components the fall-off is one.
    twice = BakedLight.of(basis, chord, np.repeat(outcomes, 2, axis=1), shares)
    both = colour_table(twice, column, degree)
    assert both.components == 2
    np.testing.assert_allclose(both.values[4:], table.values[2:], rtol=1e-5, atol=1e-6)


def test_the_rains_own_colour():
    def ratio(nm: Array) -> Array:
        return 0.8 + 0.4 * (nm - 380.0) / 400.0

    basis = light_basis(load_spectrum("E490"), 5.0, NO_AIR, ratio)
    assert basis.rain
    outcomes = np.repeat(basis.weights.sum(axis=1)[:, None, None, None, :], 3, axis=3)
    baked = BakedLight.of(basis, np.linspace(0.0, 1.0, 3), outcomes, np.ones(1))
    table = colour_table(baked, NO_AIR, 0)
    weights, _ = fine_weights("E490")
    excess = ratio(wavelength_bins(1.0).wavelength_nm) - 1.0
    clear = weights.sum(axis=0)
    np.testing.assert_allclose(table.values[0, 0, :3], clear, rtol=1e-6)
    for depth, bound in ((1.0, 1e-5), (0.3, 2e-3), (2.0, 1.5e-2)):
        exact = np.exp(-excess * depth) @ weights
        got = clear * np.exp(table.values[1, 0, :3].astype(np.float64) * depth)
        np.testing.assert_allclose(got, exact, rtol=bound)


def test_columns():
    column = Column(1.0, 3.0)
    assert (column.middle, column.reach) == (2.0, 1.0)
    nodes = column.nodes(4)
    np.testing.assert_allclose(nodes, -nodes[::-1], atol=1e-15)
    np.testing.assert_allclose(nodes, np.polynomial.chebyshev.chebpts1(4), atol=1e-15)
    for low, high in ((0.0, 0.2), (1.03, 1.4), (4.9, 9.1), (70.1, 73.9)):
        wide = Column(low, high).window(1.0)
        assert wide.low <= low
        assert high <= wide.high
        assert Column(low, high + 1e-6).window(1.0) == wide


# --- A lamp's disc ----------------------------------------------------------------------------


def colour_at(theta: float) -> float:
    return 1.0 + np.sin(11.0 * theta) ** 2 + np.exp(-(((theta - 2.4) / 0.15) ** 2))


def disc_table(count: int = 6001) -> tuple[ColourTable, Array]:
    chord = np.linspace(0.0, 2.0 * np.sqrt(2.0), count)
    values = np.zeros((1, count, 4), np.float32)
    values[0, :, 0] = [colour_at(theta) for theta in unfolded(chord)]
    per_chord = (count - 1) / float(chord[-1])
    return ColourTable(0.0, per_chord, 1, 1, 0, False, values, 0.0), chord


def mean_over_disc(theta: float, ratio: float) -> float:
    """Mean across a flat disc that a drop at this angle sees: chords of a circle."""
    disc = np.arcsin(min(ratio * np.sin(theta), 1.0))

    def chord(turn: float) -> float:
        at = abs(theta + disc * np.cos(turn))
        at = 2.0 * np.pi - at if at > np.pi else at
        return 2.0 / np.pi * np.sin(turn) ** 2 * colour_at(at)

    return quad(chord, 0.0, np.pi, epsabs=1e-10, limit=200)[0]


@pytest.mark.parametrize("ratio", [1e-3, 0.02, 0.2, 0.6])
def test_light_along_a_ray_past_a_disc(ratio):
    """The integral over angles along a ray, by adaptive quadrature, without the table."""
    table, chord = disc_table()
    running = over_discs(table, chord, np.array([ratio]), 0.05)
    assert running.shape == (2, len(chord), 4)
    point = running_colours(table.values.astype(np.float64), unfolded(chord))
    np.testing.assert_array_equal(running[0], point[0])
    for low, high in ((0.6, 0.9), (1.2, 1.9), (2.2, 2.7)):
        exact, _ = quad(lambda t: mean_over_disc(t, ratio), low, high, epsabs=1e-8)
        ends = [np.interp(folded_chord(np.array([t])), chord, running[1, :, 0])[0]
                for t in (low, high)]  # fmt: skip
        # 1e-5 of float32 and of straight lines between texels.
        assert ends[1] - ends[0] == pytest.approx(exact, abs=3e-5)


def test_a_disc_blurs():
    table, chord = disc_table(3001)
    running = over_discs(table, chord, np.array([1e-9, 0.05, 0.2]), 0.05)[..., 0]
    np.testing.assert_allclose(running[1], running[0], atol=2e-6)
    inner = slice(800, 2200)
    swing = [np.ptp(np.diff(row)[inner]) for row in running]
    assert swing[0] > swing[2] > swing[3]


# --- Air towards a sun ------------------------------------------------------------------------

BOX = np.array([[-1500.0, 200.0, 0.0], [1500.0, 1200.0, 1100.0]])
EYE = np.array([0.0, 0.0, 1.6])


def sun(altitude_deg: float) -> Sun:
    return Sun(np.zeros(3), float(np.radians(altitude_deg)), 0.005, load_spectrum("E490"))


@pytest.mark.parametrize("top", [300.0, 1100.0, 4000.0])
@pytest.mark.parametrize("altitude", [1.0, 3.0, 10.0, 20.0, 60.0, 90.0])
def test_a_cubic_follows_the_column_towards_the_sun(rng, altitude, top):
    box = BOX.copy()
    box[1, 2] = top
    found = sun_columns(sun(altitude), box, EYE)
    height = rng.uniform(0.0, top, 300)
    exact = rayleigh.sun_column(height, np.radians(altitude))
    if found.cubic is None:
        assert altitude < 5.0  # bent too much, and looked up in a table
    else:
        np.testing.assert_allclose(polyval(height, found.cubic), exact, rtol=0.0, atol=2.2e-3)
    # The range covers both ways, from any drop to the eye.
    place = rng.uniform(box[0], box[1], (300, 3)) - EYE
    length = np.linalg.norm(place, axis=1)
    seen = rayleigh.segment_column(EYE[2], place[:, 2] / length, length)
    both = seen + rayleigh.sun_column(place[:, 2] + EYE[2], np.radians(altitude))
    assert np.all(both >= found.column.low - 1e-3)
    assert np.all(both <= found.column.high + 1e-3)


def test_suns_in_the_earths_shadow_have_no_cubic():
    below = sun_columns(sun(-0.5), BOX, EYE)  # the shadow ends 242 m up
    assert below.cubic is None
    assert below.column.high > below.column.low
    gone = sun_columns(sun(-10.0), BOX, EYE)
    assert gone.cubic is None


def test_eye_column_is_that_of_the_farthest_corner():
    corner = np.array([1500.0, 1200.0, 1100.0]) - EYE
    least = rayleigh.segment_column(1.6, 0.0, float(np.hypot(1500.0, 1200.0)))
    most = rayleigh.segment_column(1.6, 0.0, float(np.linalg.norm(corner)))
    assert least <= eye_column(BOX, EYE) <= most


# --- Volumes ----------------------------------------------------------------------------------


def volume(number: Array, radius: Array | float = 400.0) -> DropletVolume:
    radii = np.float32(radius) + np.zeros(np.shape(number), np.float32)
    return DropletVolume(np.array(BOX), radii, np.float32(number))


def test_filled_box_holds_all_drops_and_no_empty_cells():
    number = np.zeros((7, 6, 12))
    number[2:4, 0, 5] = 10.0
    box = filled_box(volume(number))
    cells = (BOX[1] - BOX[0]) / np.array([6, 5, 11])
    # One cell about the points with drops, but for the volume's own faces.
    np.testing.assert_allclose(box[0], BOX[0] + cells * [1, 0, 4])
    np.testing.assert_allclose(box[1], BOX[0] + cells * [4, 1, 6])


def test_filled_box_of_all_and_nothing():
    np.testing.assert_array_equal(filled_box(volume(np.ones((3, 4, 5)))), BOX)
    empty = filled_box(volume(np.zeros((3, 4, 5))))
    np.testing.assert_array_equal(empty[0], empty[1])
    np.testing.assert_array_equal(filled_box(volume(np.ones((1, 1, 1)))), BOX)


def test_kinds_of_volumes(rng):
    shape = (8, 9, 10)
    place = np.linspace(0.0, 1.0, 8)[:, None, None] + np.zeros(shape)
    ones = np.ones(shape)
    assert kind_of(volume(ones)) == "alike"
    assert kind_of(volume(np.ones((1, 1, 1)))) == "alike"
    assert kind_of(volume(ones, 300.0 + 100.0 * place)) == "smooth"
    assert kind_of(volume(ones, rng.uniform(300.0, 600.0, shape))) == "rough"
    # Radii of points without drops mean nothing.
    odd = np.where(place > 0.5, rng.uniform(1.0, 5000.0, shape), 400.0)
    assert kind_of(volume(np.where(place > 0.5, 0.0, 1.0), odd)) == "alike"


def test_radius_spread_is_the_deviation_along_a_ray(rng):
    shape = (40, 40, 40)
    drawn = np.exp(rng.normal(6.0, 0.3, shape))
    number = drawn ** (-7.0 / 3.0)  # all points as bright as each other
    assert radius_spread(volume(1e9 * number, drawn)) == pytest.approx(0.3, rel=0.05)
    assert radius_spread(volume(np.ones(shape))) == 0.0
    # Greatest along the axis on which they grow.
    growing = np.exp(np.linspace(5.0, 6.0, 40))[:, None, None] + np.zeros(shape)
    number = 1e9 * growing ** (-7.0 / 3.0)
    assert radius_spread(volume(number, growing)) == pytest.approx(1.0 / np.sqrt(12.0), rel=0.05)


def test_greatest_depth_is_there_and_back():
    assert greatest_depth(volume(np.ones((1, 1, 1))), 1e-3) == pytest.approx(
        2e-3 * np.sqrt(3000.0**2 + 1000.0**2 + 1100.0**2)
    )


# --- Settings ---------------------------------------------------------------------------------

FINER_IS_MORE = {
    "samples_per_cell", "samples_per_log_radius", "texels_per_disc", "texels_per_fringe",
    "rows_per_fold", "lamp_scale",
}  # fmt: skip
FINER_IS_LESS = {"block", "bend", "wavelength_step_nm", "fringes_missed", "row_step", "colour",
                 "lamp_block", "lamp_bend", "share"}  # fmt: skip


@pytest.mark.parametrize("kind", ["alike", "smooth", "rough"])
def test_less_error_never_takes_coarser_settings(kind):
    names = {one.name for one in fields(FastSettings)}
    assert names == FINER_IS_MORE | FINER_IS_LESS
    found = [settings_for(e, kind) for e in np.geomspace(LEAST_DELTA_E, MOST_DELTA_E, 60)]
    for finer, coarser in pairwise(found):
        for name in FINER_IS_MORE:
            assert getattr(finer, name) >= getattr(coarser, name), name
        for name in FINER_IS_LESS - {"block"}:
            assert getattr(finer, name) <= getattr(coarser, name), name
    assert found[0].samples_per_cell > found[-1].samples_per_cell


@pytest.mark.parametrize("kind", ["alike", "smooth", "rough"])
def test_blocks_grow_with_the_error(kind):
    blocks = [settings_for(e, kind).block for e in (0.1, 0.25, 0.5, 1.0, 1.9)]
    assert blocks == sorted(blocks)
    assert (max(blocks) == 0) == (kind == "rough")


def test_fewer_rows_do_for_radii_that_spread():
    settings = settings_for(0.5, "smooth")
    rows = [hat_rows(spread, settings) for spread in (0.0, 0.01, 0.1, 0.27, 1.0)]
    assert rows == sorted(rows, reverse=True)
    assert rows[-1] == settings.rows_per_fold


def test_blurred_fringes_do_with_fewer_wavelengths():
    settings = settings_for(0.1, "alike")
    sharp, blurred = (node_step_nm(settings, blurred=b) for b in (False, True))
    assert sharp == settings.wavelength_step_nm < blurred
    for step in (sharp, blurred):
        assert (400.0 / step) % 1.0 == 0.0
    coarse = replace(settings, wavelength_step_nm=8.0)
    assert node_step_nm(coarse, blurred=True) == 8.0


def test_light_falls_off_as_that_of_the_radii_that_there_are():
    column = Column(0.0, 8.0)
    basis = light_basis(load_spectrum("equal-energy"), 5.0, column)
    nm = basis.wavelength_nm
    blue, red = np.exp(-(((nm - 450.0) / 30.0) ** 2)), np.exp(-(((nm - 630.0) / 30.0) ** 2))
    rows = [np.einsum("w,bwx->bx", one, basis.weights) for one in (blue, red)]
    outcomes = np.repeat(np.stack(rows, axis=1)[:, None, :, None, :], 2, axis=3)
    left = []
    for shares in ((1.0, 0.0), (0.0, 1.0)):
        baked = BakedLight.of(basis, np.array([0.0, 1.0]), outcomes, np.array(shares))
        table = colour_table(baked, column, 2)
        left.append(left_behind(table, basis.grey(column.middle), np.array([3.0]))[0, 0, 1])
    behind = left[0] / table.values[0, 0, 1], left[1] / table.values[0, 0, 1]
    # Rayleigh's depth at 450 nm is four times that at 630 nm.
    assert behind[0] < 0.7 * behind[1] < 1.0


def test_shares_of_light_are_those_of_drops_on_rows():
    radius_um = np.array([[[100.0, 200.0], [150.0, 400.0]]], dtype=np.float32)
    number = np.array([[[1.0, 2.0], [3.0, 0.0]]], dtype=np.float32)
    box = np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])
    volume = DropletVolume(box, np.repeat(radius_um, 2, axis=0), np.repeat(number, 2, axis=0))
    rows = np.log(np.geomspace(100e-6, 200e-6, 5))
    found = light_shares(volume, rows)
    light = number.astype(float) * radius_um.astype(float) ** (7.0 / 3.0)
    total = light[number > 0.0].sum()
    assert found.sum() == pytest.approx(1.0)
    assert found[0] == pytest.approx(light[0, 0, 0] / total)
    assert found[-1] == pytest.approx(light[0, 0, 1] / total, rel=1e-6)
    place = 4.0 * np.log2(1.5)
    assert found[2] == pytest.approx((1.0 - (place - 2.0)) * light[0, 1, 0] / total, rel=1e-4)
    assert found[1] == 0.0
