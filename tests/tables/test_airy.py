"""Look-ups in Airy's table, on the CPU and in GLSL, against quadrature over the disc itself."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import pytest
from scipy.special import airy

from glsl_probe import probe, upload
from rtbow.base.errors import InputError
from rtbow.physics.drop.airy import RADIUS_POWER, SCALE_POWER, bow
from rtbow.physics.drop.water import relative_index
from rtbow.physics.light.disc import disc_nodes
from rtbow.tables import airy as table
from rtbow.tables.airy import (
    MAX_DISC,
    NEAR_S_FIXED,
    NEAR_Z_HIGH,
    POLE_DISTANCE,
    airy_table,
    build_airy_table,
    near_z_high,
    shader_constants,
)
from rtbow.tables.export import PlainTable, export_table, plain_table

NO_DISC_DISTANCE = 1e9


def square(z):
    """Ai²(-z)."""
    return airy(-np.asarray(z, dtype=np.float64))[0] ** 2


def direct_mean(z, s, pole_distance, disc_rad):
    """Ai²(-z) averaged over a disc of ``disc_rad`` on the sphere, one case.

    ``s`` is the disc's radius in z; ``pole_distance`` that of its centre to the pole at the end of
    the bright side, in disc radii: the quadrature's angles are measured from that pole.
    """
    if disc_rad == 0.0:
        return float(square(z))
    centre = pole_distance * disc_rad
    phase = 2.0 * s * np.sqrt(max(z + s, 1.0))
    angles, weights = disc_nodes(centre, disc_rad, 24 + int(0.6 * phase))
    return float(weights @ square(z - (s / disc_rad) * (angles - centre)))


@lru_cache
def peaks():
    """Scaled discs, and the greatest disc mean of Ai² over z for each: the flat disc's chords."""
    discs = np.concatenate([[0.0], np.geomspace(0.01, 60.0, 60)])
    t = (np.arange(250) + 0.5) * np.pi / 250
    greatest = []
    for s in discs:
        z = np.linspace(0.5, 2.0 + s, 200)[:, None]
        greatest.append((square(z + s * np.cos(t)) @ np.sin(t) ** 2).max() / (0.5 * len(t)))
    return discs, np.array(greatest)


@dataclass(frozen=True)
class Cases:
    """Arguments of the look-up, as float32 holds them, and the exact means in float64."""

    z: np.ndarray
    s: np.ndarray
    distance: np.ndarray
    exact: np.ndarray

    def worst(self, got):
        """Greatest deviation in units of the bow's own peak with its disc."""
        return float((np.abs(got - self.exact) / np.interp(self.s, *peaks())).max())


def cases_at(z, s, distance, disc_rad):
    z, s, distance = (
        np.float64(np.float32(a)) for a in np.broadcast_arrays(z, s, np.asarray(distance))
    )
    exact = [direct_mean(*case, disc_rad) for case in zip(z, s, distance, strict=True)]
    return Cases(z, s, distance, np.array(exact))


@lru_cache
def random_cases(reflections, diameter_deg):
    """Drops of 10-1500 µm at 380-780 nm: a third at any angle, by the bows, and by the pole."""
    rng = np.random.default_rng(7)
    third = 400 if diameter_deg < 1.0 else 150
    radius = np.exp(rng.uniform(np.log(10e-6), np.log(1500e-6), 3 * third))
    nm = rng.uniform(380.0, 780.0, 3 * third)
    disc = np.radians(0.5 * diameter_deg)
    # To a little beyond where rings about the pole matter.
    beside_pole = rng.uniform(0.0, 30.0 * max(disc, 0.002), third)
    theta = np.concatenate(
        [
            rng.uniform(0.0, np.pi, third),
            np.radians(rng.uniform(120.0, 150.0, third)),
            np.pi - beside_pole if reflections == 1 else beside_pole,
        ]
    )
    the_bow = bow(reflections, nm * 1e-9, relative_index(nm, 20.0))
    scale = the_bow.scale * radius**SCALE_POWER
    from_pole = np.pi - theta if reflections == 1 else theta
    return cases_at(
        scale * the_bow.side * (theta - the_bow.angle_rad),
        scale * disc,
        from_pole / disc if disc else NO_DISC_DISTANCE,
        disc,
    )


# Disc across in degrees, and the bound on the error as a share of the bow's peak. The worst of 4500
# cases for each bow was 0.0002, 0.0004, 0.0013, 0.0062 and 0.0101: of wide discs where the fringes
# begin, of the widest because they are not flat.
BOUNDS = [(0.0, 0.0003), (0.1, 0.0006), (0.533, 0.002), (2.0, 0.008), (5.0, 0.012)]
by_disc = pytest.mark.parametrize(("diameter_deg", "bound"), BOUNDS)
by_bow = pytest.mark.parametrize("reflections", [1, 2])

THRESHOLD_DISC = np.radians(0.1)
# A step where the fringes begin, on a disc of s = 5, is the worst: 0.0094, then 0.0012.
THRESHOLD_BOUNDS = {"near and fringes, wide": 0.011}
BESIDE = np.array([-0.1, -0.001, 0.001, 0.1])
THRESHOLDS = {
    # Last z of the near rows, for narrow and wider discs.
    "near and fringes, no disc": (NEAR_Z_HIGH + BESIDE, 1e-4, 1000.0),
    "near and fringes": (NEAR_Z_HIGH + BESIDE, 0.5, 1000.0),
    "near and fringes, wide": (near_z_high(5.0) + BESIDE, 5.0, 1000.0),
    "fixed and widening rows": (3.3, NEAR_S_FIXED + BESIDE, 1000.0),
    "greatest disc": (20.0, MAX_DISC + np.array([-1.0, *BESIDE, 16.0]), 1000.0),
    "shadow": ([-9.0, -11.1, -20.0, -400.0], 0.5, 1000.0),
    "shadow, wide": ([-5.0, -25.0, -33.5, -80.0], 24.0, 1000.0),
    "rings": (60.0, 0.4, [0.0, 0.5, 0.999, 1.001, 5.0, 20.0, 23.99, 24.01]),
}


@lru_cache
def threshold_cases(name):
    z, s, distance = THRESHOLDS[name]
    longest = max(np.size(z), np.size(s), np.size(distance))
    return cases_at(np.broadcast_to(z, longest), s, distance, THRESHOLD_DISC)


@pytest.fixture(scope="module")
def built():
    return build_airy_table()


@pytest.mark.slow
@by_bow
@by_disc
def test_cpu_look_up(built, reflections, diameter_deg, bound):
    cases = random_cases(reflections, diameter_deg)
    assert cases.worst(built.mean_airy_squared(cases.z, cases.s, cases.distance)) < bound


@pytest.mark.parametrize("name", THRESHOLDS)
def test_cpu_look_up_on_both_sides_of_a_threshold(built, name):
    cases = threshold_cases(name)
    assert cases.worst(
        built.mean_airy_squared(cases.z, cases.s, cases.distance)
    ) < THRESHOLD_BOUNDS.get(name, 0.002)


def glsl_look_up(gl, built, cases, disc, pole=None, wide=None):
    """Look up with the code of wide discs where there are any, unless told otherwise."""
    wide = bool(cases.s.max() > NEAR_S_FIXED) if wide is None else wide
    got = probe(
        gl,
        ["drop/airy.glsl"],
        "airyMean(nearTable, fringeTable, poleTable, z, disc, poleDistance)",
        {"z": cases.z, "disc": cases.s, "poleDistance": cases.distance},
        {
            **shader_constants(),
            "DISC": disc,
            "POLE": disc if pole is None else pole,
            "WIDE": wide,
            "LAMP_COUNT": 0,
        },
        textures={
            "nearTable": upload(gl, built.near),
            "fringeTable": upload(gl, built.fringe[None]),
            "poleTable": upload(gl, built.pole),
        },
    )[:, 0]
    assert np.all(np.isfinite(got))
    return got


@by_bow
@by_disc
def test_glsl_look_up(gl, built, reflections, diameter_deg, bound):
    cases = random_cases(reflections, diameter_deg)
    got = glsl_look_up(gl, built, cases, disc=diameter_deg > 0.0)
    assert cases.worst(got) < bound
    # The same steps in float32: worst 3.5e-5 of the peak, in fringes at z = 530.
    follows = got - built.mean_airy_squared(cases.z, cases.s, cases.distance)
    assert np.abs(follows).max() < 5e-5 * np.interp(cases.s, *peaks()).min()


@pytest.mark.parametrize("name", THRESHOLDS)
def test_glsl_look_up_on_both_sides_of_a_threshold(gl, built, name):
    cases = threshold_cases(name)
    assert cases.worst(glsl_look_up(gl, built, cases, disc=True)) < THRESHOLD_BOUNDS.get(
        name, 0.002
    )


def test_a_point_looks_the_same_with_and_without_the_disc_branch(gl, built):
    cases = random_cases(1, 0.0)
    with_disc, without = (glsl_look_up(gl, built, cases, disc) for disc in (True, False))
    np.testing.assert_allclose(with_disc, without, atol=1e-7)


def test_without_the_pole_branch_only_its_surroundings_change(gl, built):
    cases = random_cases(1, 0.533)
    with_pole, without = (glsl_look_up(gl, built, cases, disc=True, pole=p) for p in (True, False))
    away = cases.distance > POLE_DISTANCE
    np.testing.assert_array_equal(with_pole[away], without[away])
    assert np.any(with_pole[~away] != without[~away])


@pytest.mark.parametrize("diameter_deg", [0.0, 0.1])
def test_narrow_discs_need_no_code_of_wide_ones(gl, built, diameter_deg):
    cases = random_cases(1, diameter_deg)
    assert cases.s.max() < NEAR_S_FIXED
    narrow, wide = (glsl_look_up(gl, built, cases, disc=True, wide=w) for w in (False, True))
    # What the compiler makes of a division by a constant.
    np.testing.assert_allclose(narrow, wide, rtol=0.0, atol=3e-6)


@by_bow
def test_cross_section_is_strength_times_mean(built, reflections):
    nm = np.array([420.0, 640.0])
    radius = np.array([50e-6, 700e-6])
    theta = np.radians([100.0, 128.0, 139.0, 179.9])
    disc = np.radians(0.2665)
    the_bow = bow(reflections, nm * 1e-9, relative_index(nm, 20.0))
    got = built.cross_section(the_bow, the_bow.parallel, radius, theta, disc)
    assert got.shape == (2, 2, 4)
    for i, a in enumerate(radius):
        for j in range(len(nm)):
            scale = the_bow.scale[j] * a**SCALE_POWER
            strength = the_bow.parallel[j] * a**RADIUS_POWER
            for k, angle in enumerate(theta):
                expected = strength * direct_mean(
                    scale * the_bow.side * (angle - the_bow.angle_rad[j]),
                    scale * disc,
                    (np.pi - angle if reflections == 1 else angle) / disc,
                    disc,
                )
                assert got[i, j, k] == pytest.approx(expected, abs=0.002 * strength * 0.287)


def test_table_is_small_and_finite(built):
    arrays = (built.near, built.fringe, built.pole)
    assert all(np.all(np.isfinite(a)) and a.dtype == np.float32 for a in arrays)
    assert sum(a.nbytes for a in arrays) < 4 << 20


class TestCache:
    @pytest.fixture
    def folder(self, tmp_path, monkeypatch):
        monkeypatch.setenv("RTBOW_CACHE_DIR", str(tmp_path))
        return tmp_path

    @pytest.fixture
    def runs(self, built, monkeypatch):
        runs = []

        def build():
            runs.append(1)
            return built

        monkeypatch.setattr(table, "build_airy_table", build)
        return runs

    def assert_same(self, got, built):
        for name in ("near", "fringe", "pole"):
            np.testing.assert_array_equal(getattr(got, name), getattr(built, name), strict=True)

    def test_second_run_reads_the_first(self, folder, runs, built):
        for _ in range(2):
            self.assert_same(airy_table(), built)
        assert len(runs) == 1
        assert len(list(folder.iterdir())) == 1

    @pytest.mark.parametrize("where", [0.3, 0.9])
    def test_damaged_file_is_rebuilt(self, folder, runs, built, where):
        airy_table()
        (file,) = folder.iterdir()
        content = bytearray(file.read_bytes())
        content[int(where * len(content))] ^= 0xFF
        file.write_bytes(content)
        self.assert_same(airy_table(), built)
        assert len(runs) == 2
        airy_table()
        assert len(runs) == 2

    def test_cut_file_is_rebuilt(self, folder, runs, built):
        airy_table()
        (file,) = folder.iterdir()
        file.write_bytes(file.read_bytes()[:1000])
        self.assert_same(airy_table(), built)
        assert len(runs) == 2

    def test_other_code_is_another_file(self, folder, runs, monkeypatch):
        airy_table()
        hashed = []

        def digest(*modules):
            hashed.extend(modules)
            return "0123456789abcdef"

        monkeypatch.setattr(table, "source_digest", digest)
        for _ in range(2):
            airy_table()
        assert len(runs) == 2
        assert len(list(folder.iterdir())) == 2
        # All that computes the table's numbers.
        assert {"physics.drop", "physics.light.disc", "tables.airy"} <= set(hashed)


EXPORT = ((20.0, 300.0), (450.0, 550.0, 650.0), 1801, 0.533)


@pytest.fixture(scope="module")
def plain():
    return plain_table(PlainTable("airy", *EXPORT))


class TestExport:
    def test_axes(self, plain):
        np.testing.assert_allclose(plain["radius_um"], EXPORT[0])
        np.testing.assert_allclose(plain["wavelength_nm"], EXPORT[1])
        np.testing.assert_allclose(np.degrees(plain["theta_rad"]), np.arange(1801) / 10.0)
        for name in ("perpendicular", "parallel"):
            assert plain[name].shape == (2, 3, 1801)
            assert plain[name].dtype == np.float32

    @pytest.mark.parametrize("name", ["perpendicular", "parallel"])
    def test_values_are_both_bows_together(self, plain, name):
        disc = np.radians(0.5 * EXPORT[3])
        for r, a in enumerate(np.array(EXPORT[0]) * 1e-6):
            for w, nm in enumerate(EXPORT[1]):
                index = relative_index(np.array([nm]), 20.0)
                both = [bow(k, np.array([nm * 1e-9]), index) for k in (1, 2)]
                for t in (0, 1, 900, 1284, 1391, 1420, 1800):
                    theta, expected = t / 10.0 * np.pi / 180.0, 0.0
                    for one in both:
                        z = float(one.scale[0] * one.side * (theta - one.angle_rad[0]))
                        z, s = z * a**SCALE_POWER, float(one.scale[0]) * a**SCALE_POWER * disc
                        beside = np.pi - theta if one.reflections == 1 else theta
                        mean = direct_mean(z, s, beside / disc, disc)
                        expected += float(getattr(one, name)[0]) * a**RADIUS_POWER * mean
                    top = float(plain[name][r, w].max())
                    assert plain[name][r, w, t] == pytest.approx(expected, abs=0.002 * top)

    def test_primary_peak_is_of_the_published_size(self, plain):
        # Exact Mie theory at 100 µm; the two bows' tails and Airy's theory are within 2 %.
        mean = plain_table(PlainTable("airy", (100.0,), (450.0, 550.0, 650.0), 18001, 0.0))
        unpolarised = 0.5 * (mean["perpendicular"] + mean["parallel"])
        np.testing.assert_allclose(
            unpolarised.max(axis=2)[0], [4.27e-9, 3.88e-9, 3.60e-9], rtol=0.02
        )

    def test_file_holds_the_arrays(self, plain, tmp_path):
        path = tmp_path / "table.npz"
        export_table(path, PlainTable("airy", *EXPORT))
        with np.load(path) as data:
            assert set(data.files) == set(plain)
            for name, array in plain.items():
                np.testing.assert_array_equal(data[name], array)

    @pytest.mark.parametrize(
        ("radius", "nm", "disc", "named"),
        [
            ([], [550.0], 0.5, "radius-um"),
            ([300.0, 20.0], [550.0], 0.5, "sort"),
            ([0.0], [550.0], 0.5, "radius-um"),
            ([20.0], [550.0, float("nan")], 0.5, "wavelength-nm"),
            ([20.0], [550.0], -1.0, "disc"),
            ([20.0], [550.0], 6.0, "disc"),
        ],
    )
    def test_bad_axes_are_refused(self, tmp_path, radius, nm, disc, named):
        with pytest.raises(InputError, match=named):
            export_table(tmp_path / "table.npz", PlainTable("airy", radius, nm, 181, disc))
        assert not list(tmp_path.iterdir())
