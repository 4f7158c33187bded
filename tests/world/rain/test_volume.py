"""Volumes: built from a scene, laid out for the texture, written, read, and refused."""

import numpy as np
import pytest

from rtbow.base.errors import InputError
from rtbow.reference.rays import interpolate
from rtbow.scene.droplets import Droplets
from rtbow.world.rain.volume import DropletVolume, build_volume, load_volume, save_volume

BOX = [[-10.0, 20.0, 0.0], [30.0, 80.0, 50.0]]


def droplets(**changes):
    parts = {
        "box_m": BOX,
        "grid": [4, 3, 2],
        "radius": {"distribution": "uniform", "min_um": 300, "max_um": 700},
        "density": {"number_per_m3": 1000},
    }
    return Droplets.model_validate({k: v for k, v in (parts | changes).items() if v is not None})


def arrays(**changes):
    """The arrays of a sound file, or of one broken in a way."""
    rng = np.random.default_rng(5)
    good = {
        "radius_um": rng.uniform(300.0, 700.0, (4, 3, 2)).astype(np.float32),
        "number_per_m3": rng.uniform(0.0, 1000.0, (4, 3, 2)).astype(np.float32),
        "box_m": np.array(BOX),
    }
    return {k: v for k, v in (good | changes).items() if v is not None}


@pytest.fixture
def write(tmp_path):
    def write(**contents):
        path = tmp_path / "volume.npz"
        np.savez(path, **contents)
        return path

    return write


class TestBuild:
    def test_grid(self):
        volume = build_volume(droplets())
        assert volume.shape == (4, 3, 2)
        assert not volume.uniform
        assert volume.radius_um.dtype == volume.number_per_m3.dtype == np.float32
        np.testing.assert_array_equal(volume.box_m, BOX)
        low, high = volume.radius_range_um
        assert 300.0 <= low < high <= 700.0

    def test_without_a_grid(self):
        volume = build_volume(
            droplets(grid=None, radius={"distribution": "constant", "radius_um": 500})
        )
        assert volume.uniform
        assert volume.shape == (1, 1, 1)
        assert volume.radius_range_um == (500.0, 500.0)

    def test_seed(self):
        same = [build_volume(droplets(seed=s)).radius_um for s in (1, 1, 2)]
        np.testing.assert_array_equal(same[0], same[1])
        assert np.all(same[0] != same[2])

    def test_rain(self):
        volume = build_volume(
            droplets(
                grid=[40, 40, 40],
                radius={"distribution": "marshall-palmer", "min_um": 15, "max_um": 1500},
                density={"rain_rate_mm_h": 5.0},
            )
        )
        # N0/Lambda between the ends (see the tests of drop sizes); 64,000 draws: 1 %.
        assert volume.number_per_m3.mean() == pytest.approx(2506.0, rel=0.02)

    def test_from_file(self, write):
        path = write(**arrays())
        volume = build_volume(Droplets(file=str(path)))
        np.testing.assert_array_equal(volume.radius_um, arrays()["radius_um"])


class TestMoments:
    def test_texture_order(self):
        nx, ny, nz = 4, 3, 2
        i, j, k = np.indices((nx, ny, nz))
        number = (100.0 * i + 10.0 * j + k + 1.0).astype(np.float32)
        volume = DropletVolume(np.array(BOX), np.full((nx, ny, nz), 500.0, np.float32), number)
        moments = volume.moments()
        assert moments.shape == (nz, ny, nx, 2)
        assert moments.dtype == np.float32
        assert moments.flags.c_contiguous
        # East is fastest, up slowest.
        assert moments[0, 0, 1, 0] == 101.0
        assert moments[0, 1, 0, 0] == 11.0
        assert moments[1, 0, 0, 0] == 2.0
        np.testing.assert_allclose(moments[..., 1], 500e-6 * moments[..., 0], rtol=1e-6)

    def test_points_lie_on_the_box_faces(self):
        volume = build_volume(droplets())
        moments = volume.moments().astype(np.float64)
        low, high = volume.box_m
        for i, j, k in np.ndindex(4, 3, 2):
            at = low + np.array([i / 3, j / 2, k / 1]) * (high - low)
            number, product = interpolate(at, volume.box_m, moments)
            assert number == pytest.approx(volume.number_per_m3[i, j, k], rel=1e-6)
            assert product / number == pytest.approx(1e-6 * volume.radius_um[i, j, k], rel=1e-6)

    def test_half_way_is_the_mean_of_the_moments(self):
        volume = build_volume(droplets())
        moments = volume.moments().astype(np.float64)
        low, high = volume.box_m
        at = low + np.array([0.5 / 3, 0.0, 1.0]) * (high - low)
        number, product = interpolate(at, volume.box_m, moments)
        n = volume.number_per_m3[:2, 0, 1].astype(float)
        a = volume.radius_um[:2, 0, 1].astype(float)
        assert number == pytest.approx(n.mean(), rel=1e-6)
        assert product / number == pytest.approx(1e-6 * (n * a).sum() / n.sum(), rel=1e-6)

    def test_empty_points_do_not_count(self):
        number = np.zeros((2, 2, 2), np.float32)
        number[0] = 10.0
        radius = np.full((2, 2, 2), 1234.0, np.float32)
        radius[0] = 300.0
        volume = DropletVolume(np.array(BOX), radius, number)
        assert volume.radius_range_um == (300.0, 300.0)
        empty = DropletVolume(np.array(BOX), radius, np.zeros_like(number))
        assert empty.radius_range_um == (0.0, 0.0)


class TestFile:
    def test_round_trip(self, tmp_path):
        volume = build_volume(droplets())
        path = tmp_path / "shower.npz"
        save_volume(volume, path)
        again = load_volume(path)
        np.testing.assert_array_equal(again.box_m, volume.box_m, strict=True)
        np.testing.assert_array_equal(again.radius_um, volume.radius_um, strict=True)
        np.testing.assert_array_equal(again.number_per_m3, volume.number_per_m3, strict=True)
        assert list(tmp_path.iterdir()) == [path]

    def test_other_number_types_are_read(self, write):
        path = write(
            **arrays(
                radius_um=np.full((4, 3, 2), 500, np.int16),
                number_per_m3=np.full((4, 3, 2), 10.0, np.float64),
            )
        )
        volume = load_volume(path)
        assert volume.radius_um.dtype == volume.number_per_m3.dtype == np.float32
        assert np.all(volume.radius_um == 500.0)

    def test_radius_of_an_empty_point_is_free(self, write):
        number, radius = arrays()["number_per_m3"], arrays()["radius_um"]
        number[0, 0, 0], radius[0, 0, 0] = 0.0, 0.0
        assert load_volume(write(**arrays(number_per_m3=number, radius_um=radius))).shape[0] == 4

    @pytest.mark.parametrize("missing", ["radius_um", "number_per_m3", "box_m"])
    def test_missing_array(self, write, missing):
        self.refused(write(**arrays(**{missing: None})), f"lacks {missing}")

    @pytest.mark.parametrize(
        ("changes", "said"),
        [
            ({"radius_um": np.full((4, 3, 3), 500.0)}, "(4, 3, 3)"),
            ({"radius_um": np.full((4, 6), 5.0), "number_per_m3": np.ones((4, 6))}, "(4, 6)"),
            ({"radius_um": np.array(500.0), "number_per_m3": np.array(1.0)}, "()"),
            (
                {"radius_um": np.full((4, 3, 1), 5.0), "number_per_m3": np.ones((4, 3, 1))},
                "(4, 3, 1)",
            ),
            (
                {"radius_um": np.full((1025, 2, 2), 5.0), "number_per_m3": np.ones((1025, 2, 2))},
                "(1025, 2, 2)",
            ),
            ({"box_m": np.array(BOX[::-1])}, "box_m"),
            ({"box_m": np.array([BOX[0], BOX[0]])}, "box_m"),
            ({"box_m": np.array(BOX[0])}, "box_m"),
            ({"box_m": np.array([[0.0, 0.0, np.nan], [1.0, 1.0, 1.0]])}, "box_m"),
            ({"box_m": np.array([[0.0, 0.0, 0.0], [1.0, np.inf, 1.0]])}, "box_m"),
            ({"box_m": np.array([["a", "b", "c"], ["d", "e", "f"]])}, "box_m"),
            ({"radius_um": np.full((4, 3, 2), 500.0 + 1j)}, "radius_um"),
        ],
    )
    def test_wrong_shape_or_kind(self, write, changes, said):
        self.refused(write(**arrays(**changes)), said)

    @pytest.mark.parametrize(
        ("name", "value", "said"),
        [
            ("number_per_m3", np.nan, "number_per_m3"),
            ("number_per_m3", np.inf, "number_per_m3"),
            ("number_per_m3", -1.0, "number_per_m3"),
            ("radius_um", np.nan, "radius_um"),
            ("radius_um", np.inf, "radius_um"),
            ("radius_um", 0.5, "1-5000"),
            ("radius_um", 5001.0, "1-5000"),
            ("radius_um", -300.0, "1-5000"),
        ],
    )
    def test_wrong_value(self, write, name, value, said):
        changed = arrays()[name]
        changed[1, 1, 1] = value
        self.refused(write(**arrays(**{name: changed})), said)

    @pytest.mark.parametrize("filler", [np.nan, -9999.0, np.inf, -np.inf, 0.0, 1e30])
    def test_radius_of_an_empty_point_may_be_anything(self, write, filler, caplog):
        number, radius = arrays()["number_per_m3"], arrays()["radius_um"]
        number[0, 0, 0], radius[0, 0, 0] = 0.0, filler
        volume = load_volume(write(**arrays(number_per_m3=number, radius_um=radius)))
        assert np.all(np.isfinite(volume.moments()))
        assert volume.radius_um[0, 0, 0] == volume.number_per_m3[0, 0, 0] == 0.0
        np.testing.assert_array_equal(volume.radius_um[1:], radius[1:])
        assert not caplog.messages

    def test_sound_traces_stay_and_odd_ones_are_none(self, write, caplog):
        number, radius = arrays()["number_per_m3"], arrays()["radius_um"]
        number[0, 0, 0], radius[1, 1, 1] = 1000.0, 500.0
        number[1, 1, 1] = 5e-4  # a trace with a radius that drops have
        number[2, 1, 1], radius[2, 1, 1] = 5e-4, np.nan
        number[3, 2, 1] = -5e-4
        path = write(**arrays(number_per_m3=number, radius_um=radius))
        for _ in range(2):
            volume = load_volume(path)
        expected = number.copy()
        expected[2, 1, 1] = expected[3, 2, 1] = 0.0
        np.testing.assert_array_equal(volume.number_per_m3, expected)
        (line,) = caplog.messages
        assert line.startswith(f"rtbow: {path}: 2 points")

    @pytest.mark.parametrize("factor", [-2e-6, 2e-6])
    def test_what_is_more_than_a_trace_is_refused(self, write, factor):
        number, radius = arrays()["number_per_m3"], arrays()["radius_um"]
        number[0, 0, 0] = 1000.0
        number[2, 0, 1], radius[2, 0, 1] = 1000.0 * factor, np.nan
        self.refused(write(**arrays(number_per_m3=number, radius_um=radius)), "[2, 0, 1]")

    @pytest.mark.parametrize("name", ["radius_um", "number_per_m3"])
    def test_refusal_names_the_first_place_and_how_many(self, write, name):
        changed = arrays()[name]
        changed[2, 1, 0] = changed[3, 0, 0] = changed[3, 2, 1] = -7.0
        number = arrays()["number_per_m3"] + 1.0
        path = write(**arrays(number_per_m3=number) | {name: changed})
        self.refused(path, f"{name}[2, 1, 0] = -7")
        self.refused(path, "(the first of 3 such points)")
        self.refused(path, "number_per_m3 to 0" if name == "radius_um" else "set it to 0")

    def test_float64_beyond_float32_is_refused(self, write):
        number = arrays()["number_per_m3"].astype(np.float64)
        number[0, 0, 0] = 1e300
        self.refused(write(**arrays(number_per_m3=number)), "number_per_m3")

    def test_pickled_objects_are_not_opened(self, write):
        self.refused(write(**arrays(radius_um=np.array([{"a": 1}], dtype=object))), "volume.npz")

    @pytest.mark.parametrize(
        "content", [b"", b"text, not numbers", b"PK\x03\x04 cut off", b"\x93NUMPY\x01\x00junk"]
    )
    def test_not_an_npz(self, tmp_path, content):
        path = tmp_path / "volume.npz"
        path.write_bytes(content)
        self.refused(path, "volume")

    def test_single_array(self, tmp_path):
        path = tmp_path / "volume.npz"
        with path.open("wb") as file:
            np.save(file, np.ones((3, 3, 3)))
        self.refused(path, "single array")

    @pytest.mark.parametrize("keep", [0.3, 0.7, 0.99])
    def test_cut_file(self, tmp_path, keep):
        path = tmp_path / "volume.npz"
        save_volume(build_volume(droplets()), path)
        content = path.read_bytes()
        path.write_bytes(content[: int(keep * len(content))])
        self.refused(path, "volume")

    @pytest.mark.parametrize("compressed", [True, False])
    def test_damaged_file(self, tmp_path, compressed):
        # Each reader below notices its own part: zip its directory and flags, zlib the data.
        path = tmp_path / "volume.npz"
        volume = build_volume(droplets(grid=[6, 6, 6]))
        if compressed:
            save_volume(volume, path)
        else:
            np.savez(path, **vars(volume))
        content = path.read_bytes()
        refused = 0
        for at in range(0, len(content), 3):
            damaged = bytearray(content)
            damaged[at] ^= 0xFF
            path.write_bytes(damaged)
            try:
                again = load_volume(path)
            except InputError:
                refused += 1
            else:  # in a time or a comment
                np.testing.assert_array_equal(again.radius_um, volume.radius_um)
        assert refused > 0.7 * len(content) / 3

    def test_missing_file(self, tmp_path):
        self.refused(tmp_path / "none.npz", "not found")

    def test_folder(self, tmp_path):
        path = tmp_path / "volume.npz"
        path.mkdir()
        self.refused(path, "volume")

    def test_unwritable(self, tmp_path):
        with pytest.raises(InputError):
            save_volume(build_volume(droplets()), tmp_path / "no" / "such" / "folder" / "v.npz")

    @staticmethod
    def refused(path, said):
        with pytest.raises(InputError) as caught:
            load_volume(path)
        assert str(caught.value).startswith(f"{path}: ")
        assert said in str(caught.value)
