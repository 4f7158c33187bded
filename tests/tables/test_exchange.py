"""What other renderers get: phase functions and textures that keep the light's total."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from rtbow.base.errors import InputError
from rtbow.tables.exchange import write_mitsuba, write_texture
from rtbow.tables.export import PlainTable, plain_table
from rtbow.tables.phase import over_sphere
from rtbow.world.measured.spectra import load_spectrum


def airy(radius_um=(500.0,), nm=(550.0,), angles=None, disc=0.533):
    return PlainTable("airy", radius_um, nm, angles, disc)


def integral(table):
    """The mean of both components over the sphere (R, W), by straight lines."""
    mean = 0.5 * (table["perpendicular"].astype(float) + table["parallel"])
    return over_sphere(table["theta_rad"], mean)[..., -1]


@pytest.mark.slow
@pytest.mark.parametrize("disc", [0.0, 0.533])
def test_exact_table_holds_its_total(disc):
    """Against the extinction efficiency, which comes from the amplitude forward alone (the optical
    theorem), not from these intensities: 5e-4 off at worst."""
    table = plain_table(PlainTable("mie", (20.0, 500.0), (400.0, 700.0), None, disc))
    np.testing.assert_allclose(integral(table), table["scattering_m2"], rtol=1e-3)
    x = 2.0 * math.pi * 500e-6 / np.array([400e-9, 700e-9])
    limit = (2.0 + 1.9924 * x ** (-2.0 / 3.0)) * math.pi * 500e-6**2
    np.testing.assert_allclose(table["scattering_m2"][1], limit, rtol=1e-3)


@pytest.mark.parametrize("disc", [0.0, 0.533])
def test_airy_table_holds_its_total(disc):
    """With and without a disc, against an integral at angles close enough for every fringe: 1.8e-3
    off at worst."""
    radii, nm = (5.0, 100.0, 1500.0), (400.0, 700.0)
    fine = plain_table(airy(radii, nm, 100_001, disc))
    np.testing.assert_allclose(integral(fine), fine["scattering_m2"], rtol=3e-3)
    # The file's own angles do as well where the disc leaves no fringes between them.
    table = plain_table(airy(radii, nm, disc=disc))
    within = slice(None) if disc else slice(2)
    got, wanted = integral(table)[within], table["scattering_m2"][within]
    np.testing.assert_allclose(got, wanted, rtol=1e-3)


def nodes(path: Path) -> np.ndarray:
    return np.array([float(v) for v in path.read_text().split(",")])


@pytest.mark.parametrize("count", [401, 20_001])
def test_phase_function_is_normalised(tmp_path, count):
    write_mitsuba(tmp_path / "p.txt", airy(angles=count))
    value = nodes(tmp_path / "p.txt")
    step = 2.0 / (count - 1)
    total = 2.0 * math.pi * step * (value.sum() - 0.5 * (value[0] + value[-1]))
    assert total == pytest.approx(1.0, abs=1e-5)
    assert value.min() >= 0.0
    # Backward first: the primary bow, 138 degrees from the forward direction, is the brightest.
    cosine = np.linspace(-1.0, 1.0, count)
    assert cosine[value.argmax()] == pytest.approx(
        math.cos(math.radians(138.0)), abs=1.5 * step + 0.01
    )


def test_phase_function_has_the_mean_cosine_of_the_table(tmp_path):
    write_mitsuba(tmp_path / "p.txt", airy())
    value, cosine = nodes(tmp_path / "p.txt"), np.linspace(-1.0, 1.0, 20_001)
    table = plain_table(airy(angles=40_001))
    mean = 0.5 * (table["perpendicular"].astype(float) + table["parallel"])[0, 0]
    theta = table["theta_rad"]
    wanted = over_sphere(theta, mean * np.cos(theta))[-1] / over_sphere(theta, mean)[-1]
    got = np.sum(value * cosine) / np.sum(value)
    assert got == pytest.approx(wanted, abs=1e-4)


def test_texture_sums_to_its_albedo(tmp_path):
    """In white light the share of the bows, which is nearly the same at all wavelengths."""
    wanted = airy((100.0, 500.0), tuple(np.arange(380.0, 781.0, 20.0)), 500)
    write_texture(tmp_path / "t.exr", wanted, load_spectrum("equal-energy"))
    with OpenEXR.File(str(tmp_path / "t.exr"), separate_channels=True) as file:
        planes = [file.channels()[c].pixels for c in "RGB"]
        albedo = [float(v) for v in file.header()["albedo"].split(",")]
    luminance = np.tensordot([0.2126, 0.7152, 0.0722], np.array(planes), axes=1)
    edge = np.cos(np.linspace(0.0, math.pi, 501))
    np.testing.assert_allclose(luminance @ (2.0 * math.pi * -np.diff(edge)), albedo, rtol=1e-4)
    share = plain_table(airy((100.0, 500.0)))["scattering_m2"][:, 0] / (
        2.05 * math.pi * np.array([100e-6, 500e-6]) ** 2
    )
    np.testing.assert_allclose(albedo, share, rtol=0.05)
    # Red outside, blue inside: the primary's columns, whose angle from the sun is 180 less.
    red, _, blue = planes
    assert red[1].argmax() < blue[1].argmax()


def test_one_size_and_wavelength_for_mitsuba(tmp_path):
    with pytest.raises(InputError, match="--radius-um: gives 2 numbers"):
        write_mitsuba(tmp_path / "p.xml", airy((100.0, 500.0)))
    with pytest.raises(InputError, match="--wavelength-nm: gives 2 numbers"):
        write_mitsuba(tmp_path / "p.xml", airy(nm=(500.0, 600.0)))
    with pytest.raises(InputError, match="380 to 780 at even steps"):
        write_texture(tmp_path / "t.exr", airy(nm=(500.0, 600.0)), load_spectrum("E490"))
    assert not list(tmp_path.iterdir())


SLAB = """\
<scene version="3.0.0">
    <include filename="drops.xml"/>
    <integrator type="volpath"><integer name="max_depth" value="2"/></integrator>
    <emitter type="directional">
        <vector name="direction" x="0" y="0" z="-1"/><rgb name="irradiance" value="1"/>
    </emitter>
    <shape type="cube">
        <transform name="to_world"><scale x="100" y="100" z="0.1"/></transform>
        <bsdf type="null"/>
        <medium type="homogeneous" name="interior">
            <float name="sigma_t" value="0.5"/><float name="albedo" value="1"/><ref id="drops"/>
        </medium>
    </shape>
    <sensor type="perspective">
        <float name="fov" value="8"/>
        <transform name="to_world">
            <lookat origin="{x} 0 {z}" target="0 0 0" up="0 1 0"/>
        </transform>
        <film type="hdrfilm">
            <integer name="width" value="12"/><integer name="height" value="12"/>
            <rfilter type="box"/>
        </film>
        <sampler type="independent"><integer name="sample_count" value="400"/></sampler>
    </sensor>
</scene>
"""


@pytest.mark.parametrize("away_deg", [41.0, 30.0])
def test_mitsuba_draws_the_bow(tmp_path, away_deg):
    """Light scattered once in a thin slab has a closed form; Mitsuba's noise is 1 % of it."""
    mitsuba = pytest.importorskip("mitsuba")
    mitsuba.set_variant("scalar_rgb")
    write_mitsuba(tmp_path / "drops.xml", airy((100.0,)))
    away = math.radians(away_deg)
    scene = SLAB.format(x=3.0 * math.sin(away), z=3.0 * math.cos(away))
    (tmp_path / "scene.xml").write_text(scene)
    frame = np.array(mitsuba.render(mitsuba.load_file(str(tmp_path / "scene.xml"))))[..., 1]
    # The mean over the picture's rays of E p (1 - exp(-tau (1 + 1/mu))) / (1 + mu).
    half = math.tan(math.radians(4.0))
    side = (np.arange(48) + 0.5) / 24.0 - 1.0
    right, up = (v.ravel() * half for v in np.meshgrid(side, side))
    norm = np.sqrt(1.0 + right**2 + up**2)
    mu = (math.cos(away) + right * math.sin(away)) / norm
    table = plain_table(airy((100.0,)))
    mean = 0.5 * (table["perpendicular"].astype(float) + table["parallel"])[0, 0]
    phase = mean / table["scattering_m2"][0, 0]
    at = np.interp(math.pi - np.arccos(mu), table["theta_rad"], phase)
    wanted = at * (1.0 - np.exp(-0.1 * (1.0 + 1.0 / mu))) / (1.0 + mu)
    assert frame.mean() == pytest.approx(wanted.mean(), rel=0.03)
