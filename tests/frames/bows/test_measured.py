"""Numbers of frames whose bows are known: rings of a formula, and Descartes' bow of large drops."""

import numpy as np
import pytest

import rtbow
from rtbow.base.errors import InputError
from rtbow.frames.bows.measured import measured
from rtbow.frames.bows.stored import stored_frame
from rtbow.frames.image import frame_metadata, write_frame
from rtbow.physics.drop.medium import Medium
from rtbow.world.camera.resolve import pixel_directions
from rtbow.world.world import resolve

AROUND = [[-1e3, -1e3, -998.4], [1e3, 1e3, 1001.6]]
"""A cube of rain about the eye, which is 1.6 m high."""
RINGS = {"droplets.box_m": AROUND, "camera.size_px": [320, 180], "camera.altitude_deg": 21.0}
PER_SIGMA = np.sqrt(2.0 * np.log(2.0))
"""Half of a Gaussian's full width at half maximum, in standard deviations."""


def rings(scene, *gaussians, base=0.0):
    """A grey frame of Gaussian rings (radius, deviation, height), in degrees, in rain that is as
    deep as the cube about the eye is along each ray."""
    rays = pixel_directions(scene.camera)
    sun = np.radians(20.0)
    antisolar = np.array([0.0, np.cos(sun), -np.sin(sun)])
    angle = np.degrees(np.arccos(rays @ antisolar))
    value = base + sum(h * np.exp(-0.5 * ((angle - r) / s) ** 2) for r, s, h in gaussians)
    depth = 1.0 / np.abs(rays).max(axis=-1)
    return np.repeat((value * depth)[..., None], 3, axis=2).astype(np.float32)


def numbers(scene, frame, **options):
    parts = scene.parts()
    worlds = [resolve(part) for part, _ in parts]
    return measured(worlds, [columns for _, columns in parts], frame, **options)


def test_gaussian_rings():
    scene = rtbow.load_scene("uniform", RINGS)
    base = 0.05
    frame = rings(scene, (41.6, 0.8, 1.0), (51.4, 1.0, 0.4), base=base)
    found = numbers(scene, frame)
    assert found.size_px == (320, 180)
    luminance = frame @ np.array([0.2126, 0.7152, 0.0722])
    assert found.peak_luminance_cd_m2 == pytest.approx(luminance.max(), rel=1e-5)
    assert found.mean_luminance_cd_m2 == pytest.approx(luminance.mean(), rel=1e-5)
    assert found.left_out == ()
    for bow, (name, radius, sigma, height) in zip(
        found.bows, (("primary", 41.6, 0.8, 1.0), ("secondary", 51.4, 1.0, 0.4)), strict=True
    ):
        assert (bow.part, bow.light, bow.bow) == (0, "light.0", name)
        assert bow.radius_deg == pytest.approx(radius, abs=0.03)
        assert bow.radius_rgb_deg == pytest.approx([radius] * 3, abs=0.03)
        # Towards the bright side half-way to the base; towards the dark one half of all of it.
        dark_side = np.sqrt(2.0 * np.log(2.0 * height / (height - base)))
        assert bow.width_deg == pytest.approx(sigma * (PER_SIGMA + dark_side), abs=0.06)
        assert bow.width_rgb_deg == pytest.approx([bow.width_deg] * 3, abs=1e-5)
        assert bow.contrast == pytest.approx(height / (height + 2.0 * base), abs=0.03)
        assert bow.chromaticity_uv == pytest.approx([0.1978, 0.4683], abs=2e-4)  # D65
    quick = numbers(scene, frame, fringes=False)
    assert quick.bows[0].radius_deg == found.bows[0].radius_deg
    assert quick.bows[0].supernumerary_contrast is None


def test_drops_of_another_index():
    """Glass of 1.5: Descartes' primary has 22.84 degrees, far from water's."""
    scene = rtbow.load_scene(
        "uniform",
        {**RINGS, "scattering.refractive_index": 1.5, "camera.altitude_deg": 0.0,
         "scattering.orders": [1]},
    )  # fmt: skip
    (bow,) = numbers(scene, rings(scene, (22.6, 0.5, 1.0))).bows
    assert bow.radius_deg == pytest.approx(22.6, abs=0.03)
    assert bow.width_deg == pytest.approx(2.0 * PER_SIGMA * 0.5, abs=0.06)


def test_what_cannot_be_measured_is_left_out():
    lamp = {"type": "point", "position_m": [0.0, -10.0, 3.0], "luminous_flux_lm": 1e4}
    lamps = rtbow.load_scene("uniform", {**RINGS, "light": [lamp]})
    found = numbers(lamps, rings(lamps, (41.6, 0.8, 1.0)))
    assert found.bows == ()
    assert "bows of lamps" in found.left_out[0]
    coarse = rtbow.load_scene("uniform", {**RINGS, "camera.size_px": [32, 18]})
    found = numbers(coarse, rings(coarse, (41.6, 0.8, 1.0)))
    assert found.bows == ()
    assert "too coarse" in found.left_out[0]
    black = rtbow.load_scene("uniform", RINGS)
    assert numbers(black, np.zeros((180, 320, 3), np.float32)).bows == ()


def test_two_suns_and_two_parts():
    suns = [{"altitude_deg": 20.0}, {"altitude_deg": 60.0}]  # the second's bow is below the picture
    scene = rtbow.load_scene(
        "uniform",
        {**RINGS, "light": suns, "compare.split": 0.5, "compare.right": {"droplets.seed": 7}},
    )
    found = numbers(scene, rings(scene, (41.6, 0.8, 1.0), (51.4, 1.0, 0.4)))
    places = [(bow.part, bow.light, bow.bow) for bow in found.bows if bow.light == "light.0"]
    assert places == [(part, "light.0", bow) for part in (0, 1) for bow in ("primary", "secondary")]


def test_the_red_edge_of_large_drops_is_that_of_geometric_optics():
    """R is greatest near 610 nm, where water has an index of 1.3322 relative to air (Hale and
    Querry 1973 through IAPWS): Descartes' bow of 42.2 degrees, from its two angles."""
    changes = {
        "camera.size_px": [64, 36], "camera.fov_deg": 24.0, "camera.altitude_deg": 21.0,
        "droplets.radius.radius_um": 3000.0, "scattering.orders": [1],
        "render.wavelength_step_nm": 10.0,
    }  # fmt: skip
    scene = rtbow.load_scene("uniform", changes)
    with rtbow.Renderer(scene) as renderer:
        (bow,) = renderer.measured(renderer.render("reference")).bows
        with pytest.raises(InputError, match="shape"):
            renderer.measured(np.zeros((2, 2, 3), np.float32))
    index = 1.3322
    incidence = np.arccos(np.sqrt((index**2 - 1.0) / 3.0))
    descartes = 4.0 * np.arcsin(np.sin(incidence) / index) - 2.0 * incidence
    red = bow.radius_rgb_deg[0]
    assert red == pytest.approx(np.degrees(descartes), abs=0.3)
    assert red > bow.radius_deg > bow.radius_rgb_deg[2]
    # The colours of 440 to 680 nm span 1.4 degrees, over which no drop is too large.
    span = Medium().descartes_deg(1, 440.0) - Medium().descartes_deg(1, 680.0)
    assert 0.5 * span < bow.width_deg < 2.0 * span


def test_a_frame_on_file_finds_its_scene(tmp_path):
    """By its text with what was set, its name and the files beside that."""
    changes = {key: value for key, value in RINGS.items() if key.startswith("camera")}
    scene = rtbow.load_scene("curtain", {**changes, "camera.azimuth_deg": 3.0})
    frame = rings(scene, (41.6, 0.8, 1.0))
    path = str(tmp_path / "bow.exr")
    write_frame(path, frame, frame_metadata(scene, "rtbow", "fast", "none"), 12.5)
    stored = stored_frame(path)
    assert stored.scene == scene
    assert stored.exposure_ev == 12.5
    np.testing.assert_array_equal(stored.rgb, frame)
    assert stored.measured() == numbers(scene, frame)


# --- Before a sky or a ground ------------------------------------------------------------------

AROUND_KEYS = {"atmosphere.sky": True, "ground.albedo": 0.3}
SMALL = {"camera.size_px": [160, 90], "droplets.box_m": [[-1e3, -1e3, 0.0], [1e3, 1e3, 1e3]],
         "camera.altitude_deg": 21.0, "atmosphere.rayleigh": True}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("pixel", ["centre", "area"])
def test_bows_before_a_sky_are_measured_in_the_drops_own_light(pixel):
    plain = {**SMALL, "camera.pixel": pixel}
    with rtbow.Renderer(rtbow.load_scene("uniform", plain)) as renderer:
        alone = renderer.measured(renderer.render("fast"))
    with rtbow.Renderer(rtbow.load_scene("uniform", plain | AROUND_KEYS)) as renderer:
        frame = renderer.render("fast")
        found = renderer.measured(frame)
        assert np.array_equal(renderer.render("fast"), frame)  # the sky is back
    assert len(alone.bows) == 2
    assert found.bows == alone.bows
    assert found.left_out == ()
    assert found.mean_luminance_cd_m2 > 1.5 * alone.mean_luminance_cd_m2


@pytest.mark.slow
def test_of_a_split_picture_each_side_has_its_own_bows():
    keys = {**SMALL, "compare": {"right": {"atmosphere.sky": True, "ground.albedo": 0.3}}}
    with rtbow.Renderer(rtbow.load_scene("uniform", keys)) as renderer:
        found = renderer.measured(renderer.render("fast"))
    left, right = ([bow for bow in found.bows if bow.part == part] for part in (0, 1))
    assert [bow.bow for bow in left] == [bow.bow for bow in right] == ["primary", "secondary"]
    for one, other in zip(left, right, strict=True):
        assert one.radius_deg == pytest.approx(other.radius_deg, abs=0.05)


@pytest.mark.parametrize("changes", [AROUND_KEYS, {"ground.albedo": 0.3}], ids=["sky", "ground"])
def test_frames_that_hold_more_than_the_drops_light_say_so(tmp_path, changes):
    scene = rtbow.load_scene("uniform", RINGS | changes)
    frame = rings(scene, (41.6, 0.8, 1.0))
    path = str(tmp_path / "frame.exr")
    write_frame(path, frame, frame_metadata(scene, "rtbow render", "fast", "llvmpipe"))
    found = stored_frame(path).measured()
    assert found.bows == ()
    (said,) = found.left_out
    assert "a frame on file and method reference do not tell apart" in said
    assert numbers(scene, frame, drops=frame).bows[0].radius_deg == pytest.approx(41.6, abs=0.03)


def test_lamps_before_a_ground_have_one_note():
    scene = rtbow.load_scene("street-lamp", {"ground.albedo": 0.3, "camera.size_px": [320, 180]})
    found = numbers(scene, np.zeros((180, 320, 3), np.float32))
    assert found.left_out == ("bows of lamps are not circles about a point and are not measured",)


@pytest.mark.slow
def test_the_reference_tells_no_light_apart():
    small = {"camera.size_px": [16, 9], "render.wavelength_step_nm": 40.0, "ground.albedo": 0.3}
    with rtbow.Renderer(rtbow.load_scene("uniform", small)) as renderer:
        assert "method reference" in renderer.measured(renderer.render("reference")).left_out[0]
