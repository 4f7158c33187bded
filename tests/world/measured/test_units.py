"""Units of spectrum files: converted as their headers say, or refused."""

import numpy as np
import pytest
from scipy import constants

from lamp_samples import FILE_NM, FILE_VALUES, FILE_VISIBLE, rows
from rtbow.base.errors import InputError
from rtbow.world.measured.spectra import load_measured, load_spectrum
from rtbow.world.measured.units import UnitError, abscissa_unit, value_unit

WAVENUMBER = 1e7 / FILE_NM
THZ = constants.c / FILE_NM * 1e-3
EV = constants.h * constants.c / (FILE_NM * 1e-9) / constants.e
PHOTON_J = constants.h * constants.c / (FILE_NM * 1e-9)
MOLES = FILE_VALUES / PHOTON_J / constants.N_A
# Per interval of x = K / λ: a density per nm times |dλ/dx| = λ² / K.
PER_WAVENUMBER = FILE_VALUES * FILE_NM**2 / 1e7
PER_THZ = FILE_VALUES * FILE_NM**2 / (constants.c * 1e-3)
PER_EV = FILE_VALUES * FILE_NM**2 * 1e-9 / (constants.h * constants.c / constants.e)

CONVERTED = [
    ("wavelength_um,value", FILE_NM / 1e3, FILE_VALUES, "relative"),
    ("Wavelength (µm),value", FILE_NM / 1e3, FILE_VALUES, "relative"),
    ("Wavelength (microns),E-490 W/m2/micron", FILE_NM / 1e3, FILE_VALUES * 1e3, "irradiance"),
    ("λ / µm,value", FILE_NM / 1e3, FILE_VALUES, "relative"),
    ("# wavelengths in micrometres\nx,y", FILE_NM / 1e3, FILE_VALUES, "relative"),
    ("wavelength,irradiance\num,W/m2/um", FILE_NM / 1e3, FILE_VALUES * 1e3, "irradiance"),
    ("Wavelength [Å],flux", FILE_NM * 10.0, FILE_VALUES, "relative"),
    ("lambda (Angstrom),W m-2 A-1", FILE_NM * 10.0, FILE_VALUES * 0.1, "irradiance"),
    ("wavelength (m),irradiance (W m-3)", FILE_NM * 1e-9, FILE_VALUES * 1e9, "irradiance"),
    ("wavelength_nm,irradiance_w_m2_nm", FILE_NM, FILE_VALUES, "irradiance"),
    ("nm,mW cm^-2 nm^-1", FILE_NM, FILE_VALUES * 0.1, "irradiance"),
    ("nm,Irradiance (uW/cm^2/nm)", FILE_NM, FILE_VALUES * 100.0, "irradiance"),
    ("nm,W m⁻² µm⁻¹", FILE_NM, FILE_VALUES * 1e3, "irradiance"),
    ("nm,Radiance [W/(m2 sr um)]", FILE_NM, FILE_VALUES * 1e3, "radiance"),
    ("nm,W/nm", FILE_NM, FILE_VALUES, "flux"),
    ("nm,mW/sr/nm", FILE_NM, FILE_VALUES * 1e3, "intensity"),
    ("nm,erg s-1 cm-2 nm-1", FILE_NM, FILE_VALUES * 1e3, "irradiance"),
    ("wavenumber (cm-1),W/(m2 sr cm-1)", WAVENUMBER, PER_WAVENUMBER, "radiance"),
    ("wavenumber [1/cm],W m-2 (cm-1)-1", WAVENUMBER, PER_WAVENUMBER, "irradiance"),
    ("wavenumber_cm-1,W/m2/nm", WAVENUMBER, FILE_VALUES, "irradiance"),
    ("frequency (THz),W/m2/THz", THZ, PER_THZ, "irradiance"),
    ("frequency (Hz),W m-2 Hz-1", THZ * 1e12, PER_THZ * 1e-12, "irradiance"),
    ("nm,Jy", FILE_NM, PER_THZ * 1e-12 * 1e26, "irradiance"),
    ("energy (eV),W/m2/eV", EV, PER_EV, "irradiance"),
    ("nm,photons s-1 m-2 nm-1", FILE_NM, FILE_VALUES / PHOTON_J, "irradiance"),
    ("nm,PFD [µmol m-2 s-1 nm-1]", FILE_NM, MOLES * 1e6, "irradiance"),
    ("nm,Intensity (a.u.)", FILE_NM, FILE_VALUES, "relative"),
    ("nm,Intensity (counts)", FILE_NM, FILE_VALUES, "relative"),
]


@pytest.mark.parametrize(("header", "x", "y", "quantity"), CONVERTED)
def test_units_are_converted(tmp_path, header, x, y, quantity):
    path = tmp_path / "lamp.csv"
    path.write_text(f"{header}\n{rows(x, y)}")
    got = load_measured(str(path))
    ends = got.spectrum.wavelength_nm[[0, -1]]  # rounding may add points at both
    np.testing.assert_allclose(ends, [380.0, 780.0], rtol=1e-12)
    at_points = np.interp(FILE_NM, got.spectrum.wavelength_nm, got.spectrum.value)
    np.testing.assert_allclose(at_points, FILE_VALUES, rtol=1e-8)
    assert got.unit.quantity == quantity


def test_relative_values_over_wavenumbers_are_per_wavenumber(tmp_path):
    path = tmp_path / "lamp.csv"
    path.write_text("cm-1,intensity\n" + rows(WAVENUMBER, PER_WAVENUMBER))
    got = load_measured(str(path))
    assert got.spectrum.visible == pytest.approx(FILE_VISIBLE)
    assert got.notes == ("lamp.csv: its values are taken as per cm⁻¹",)


@pytest.mark.parametrize(
    ("header", "words"),
    [
        ("wavelength (furlong),value", "a unit that is not known"),
        ("pixel,counts", "pixel, no wavelength"),
        ("frequency,value", "without its unit"),
        ("nm,power (dBm)", "decibels"),
        ("nm,log10 irradiance", "logarithms"),
        ("nm,reflectance", "no light"),
        ("nm,lm/nm", "weighted for the eye"),
        ("nm,Irradiance [W/s/K]", "cannot be converted"),
        ("# wavelengths in um, once in nm\nx,y", "several units"),
    ],
)
def test_units_that_cannot_be_converted(tmp_path, header, words):
    path = tmp_path / "lamp.csv"
    path.write_text(f"{header}\n{rows()}")
    with pytest.raises(InputError, match=words):
        load_spectrum(str(path))


E490 = """\
0.1195,0.0619
0.2195,46.92
0.2945,508.8
0.3195,710.5
0.3445,795.7
0.3695,1226
0.3945,1026
0.4195,1701
0.4445,1973
0.4695,1990
0.4945,2058
0.5195,1828
0.5445,1879
0.5695,1860
0.5945,1773
0.6195,1707
0.659,1549
0.709,1384
0.759,1240
0.809,1095
1.008,733.5
2.008,115.4
5.25,2.85
10,0.234
50,0.00037
100,0.000025
1000,0.0000000025
"""
"""Some of ASTM E-490's coarser figures, µm and W m⁻² µm⁻¹: their numbers span 380-780."""


def test_micrometres_are_not_taken_for_nanometres(tmp_path):
    path = tmp_path / "e490.csv"
    path.write_text(E490)
    with pytest.raises(InputError, match="looks like µm, not nm") as caught:
        load_spectrum(str(path))
    assert "such as wavelength_um,value" in str(caught.value)
    path.write_text("wavelength_nm,value\n" + E490)
    with pytest.raises(InputError, match="looks like µm, not nm"):
        load_spectrum(str(path))
    path.write_text("wavelength_um,W m-2 um-1\n" + E490)
    got = load_measured(str(path))
    # The finer table, which is built in, has 654.95 W/m².
    assert got.spectrum.visible == pytest.approx(load_spectrum("E490").visible, rel=2e-3)


@pytest.mark.parametrize(
    ("x", "words"),
    [
        (FILE_NM / 1e3, "µm"),
        (FILE_NM * 10.0, "Å"),
        (WAVENUMBER, "cm⁻¹"),
        (FILE_NM * 1e-9, "wavelength_m"),
        (np.linspace(100.0, 10_000.0, 500), "Å"),
        (np.linspace(100.0, 50_000.0, 500), "cm⁻¹"),
    ],
)
def test_numbers_without_a_unit_that_look_like_another(tmp_path, x, words):
    path = tmp_path / "lamp.csv"
    path.write_text("x,y\n" + rows(x, np.ones(len(x))))
    with pytest.raises(InputError, match=words):
        load_spectrum(str(path))


@pytest.mark.parametrize(
    "x",
    [
        np.array([0.0, 1000.0]),
        np.arange(1.0, 1001.0),
        np.arange(280.0, 4000.0),
        np.concatenate([np.arange(119.5, 2500.0), [1e4, 1e5, 1e6]]),
    ],
)
def test_nanometres_without_a_unit_stay_nanometres(tmp_path, x):
    path = tmp_path / "lamp.csv"
    path.write_text(rows(x, np.ones(len(x))))
    assert load_spectrum(str(path)).visible == pytest.approx(400.0)


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("nm", "nm"),
        ("Wvlgth nm", "nm"),
        ("wavelength", ""),
        ("wavelength [air]", ""),
        ("Wavelength/nm", "nm"),
        ("WAVELENGTH_UM", "µm"),
        ("wavelengthnm", "nm"),
        ("wavenumber_1/cm", "cm⁻¹"),
        ("1/cm", "cm⁻¹"),
        ("Wavenumber", "cm⁻¹"),
        ("Wavenumber (cm⁻¹)", "cm⁻¹"),
        ("ångström", "Å"),
    ],
)
def test_names_of_the_abscissa(text, unit):
    assert abscissa_unit(text) == unit


@pytest.mark.parametrize(
    ("name", "quantity", "per"),
    [
        ("W/m2/nm", "irradiance", "nm"),
        ("W m-2", "irradiance", "µm"),
        ("kW/(m^2 µm)", "irradiance", "µm"),
        ("value [W m^{-2} nm^{-1}]", "irradiance", "nm"),
        ("E", "relative", "nm"),
        ("LED 3000 K", "relative", "nm"),
        ("", "relative", "nm"),
    ],
)
def test_names_of_values(name, quantity, per):
    got = value_unit(name, "", "µm")
    assert (got.quantity, got.per) == (quantity, per)


def test_it_must_be_clear_what_values_are_per():
    with pytest.raises(UnitError, match="unclear"):
        value_unit("[W m-2 cm-1]", "", "cm⁻¹")
