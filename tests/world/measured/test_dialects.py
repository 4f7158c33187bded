"""Spectrum files of many programs hold the same lamp."""

import io

import colour
import numpy as np
import pytest

from lamp_samples import FILE_NM, FILE_VALUES, FILE_VISIBLE, rows
from rtbow.base.errors import InputError
from rtbow.world.measured.spectra import load_measured, load_spectrum
from rtbow.world.measured.table import quick_table

HEAD = "wavelength,power\n"
ARGYLL = (
    'SPECT   \n\nDESCRIPTOR "spectral power"\nKEYWORD "MEAS_TYPE"\nMEAS_TYPE "EMISSION"\n'
    'SPECTRAL_BANDS "81"\nSPECTRAL_START_NM "380.000000"\nSPECTRAL_END_NM "780.000000"\n'
    'SPECTRAL_NORM "100.000000"\n\nNUMBER_OF_FIELDS 81\nBEGIN_DATA_FORMAT\n'
    + " ".join(f"SPEC_{nm:.0f}" for nm in FILE_NM)
    + "\nEND_DATA_FORMAT\n\nNUMBER_OF_SETS 1\nBEGIN_DATA\n"
    + " ".join(repr(float(100.0 * value)) for value in FILE_VALUES)
    + "\nEND_DATA\n"
)
X_RITE = (
    "NUMBER_OF_FIELDS\t83\r\nBEGIN_DATA_FORMAT\r\nSampleID\tSAMPLE_NAME\t"
    + "\t".join(f"nm{nm:.0f}" for nm in FILE_NM)
    + "\r\nEND_DATA_FORMAT\r\nBEGIN_DATA\r\n1\tA1\t"
    + "\t".join(repr(float(value)) for value in FILE_VALUES)
    + "\r\nEND_DATA\r\n"
)
OCEAN = (
    "Data from Node\n\nDate: Mon Jan 01 12:00:00 2024\nIntegration Time (sec): 1,000E-1\n"
    "XAxis mode: Wavelengths\nNumber of Pixels in Spectrum: 81\n>>>>>Begin Spectral Data<<<<<\n"
    + rows(separator="\t", decimal=",")
    + ">>>>>End Spectral Data<<<<<\n"
)
TABLES = {
    "commas": HEAD + rows(),
    "no header": rows(),
    "semicolons, decimal comma": "Wellenlänge [nm];Intensität\n" + rows(separator=";", decimal=","),
    "tabs": "nm\tvalue\n" + rows(separator="\t"),
    "tabs, decimal comma": "nm\tvalue\n" + rows(separator="\t", decimal=","),
    "spaces": "# wavelength flux\n" + rows(separator="   "),
    "spaces, decimal comma": rows(separator=" ", decimal=","),
    "bars": "wavelength | power\n" + rows(separator=" | "),
    "bars around": "| nm | power |\n|---|---|\n"
    + "".join(f"| {line} |\n" for line in rows(separator=" | ").splitlines()),
    "quotes": '"wavelength","power"\n'
    + "".join(
        f'"{a}","{b}"\n'.replace(".", ",")
        for a, b in zip(FILE_NM.tolist(), FILE_VALUES.tolist(), strict=True)
    ),
    "falling": HEAD + rows(FILE_NM[::-1], FILE_VALUES[::-1]),
    "lines ended as on Windows": (HEAD + rows()).replace("\n", "\r\n"),
    "lines ended as on an old Mac": (HEAD + rows()).replace("\n", "\r"),
    "a separator behind each row": (HEAD + rows()).replace("\n", ",\n"),
    "a block of header lines": "Maker,Acme\nModel,LED 3000\nDate,2024-01-02\n\n" + HEAD + rows(),
    "a row of units": "wavelength,power\nnm,W/m2/nm\n" + rows(),
    "comments everywhere": "".join(
        f"# a\n// b\n% c\n; d\n! e\n\n{line}\n" for line in rows(separator=" ").splitlines()
    ),
    "an index before": ",wavelength,power\n"
    + "".join(f"{n},{line}\n" for n, line in enumerate(rows().splitlines())),
    "uncertainties": "wavelength,power,uncertainty\n" + rows().replace("\n", ",0.1\n"),
    "Fortran's exponents": "nm,v\n" + rows().replace("e", "D").replace("\n", "D+00\n"),
    "a footer": HEAD + rows() + "end of file\n",
    "Ocean Optics": OCEAN,
    "Argyll": ARGYLL,
    "X-Rite": X_RITE,
    "pairs in a line": rows(separator=":").replace("\n", ", ").rstrip(", "),
    "pairs in lines": rows(separator=" : "),
    "a header longer than is looked ahead": "".join(f"Key: {n}\n" for n in range(5000))
    + HEAD
    + rows(),
}
ENCODED = {
    "UTF-8 with a mark": ("\ufeffλ (nm),power\n" + rows()).encode("utf-8"),
    "Latin-1": ("Wellenlänge [nm],W/m²/nm\n" + rows()).encode("latin-1"),
    "Excel's Unicode text": ("\ufeff" + HEAD + rows()).encode("utf-16-le"),
    "UTF-16, big end first": ("\ufeff" + HEAD + rows()).encode("utf-16-be"),
    "UTF-16 without a mark": (HEAD + rows()).encode("utf-16-le"),
}


@pytest.mark.parametrize("name", [*TABLES, *ENCODED])
def test_the_same_lamp_in_every_dialect(tmp_path, name):
    path = tmp_path / "lamp.dat"
    path.write_bytes(ENCODED[name] if name in ENCODED else TABLES[name].encode())
    got = load_measured(str(path))
    np.testing.assert_allclose(got.spectrum.wavelength_nm, FILE_NM, rtol=1e-12)
    # CGATS says mW.
    scale = 1e-3 if name == "Argyll" else 1.0
    np.testing.assert_allclose(got.spectrum.value, scale * FILE_VALUES, rtol=1e-12)
    assert got.spectrum.visible == pytest.approx(scale * FILE_VISIBLE)
    assert got.notes == ()


def test_colour_science_reads_the_same(tmp_path):
    path = tmp_path / "lamp.csv"
    path.write_text(TABLES["commas"])
    theirs = colour.read_sds_from_csv_file(str(path))["power"]
    np.testing.assert_array_equal(load_spectrum(str(path)).value, theirs.values)


def test_colour_science_reads_the_same_from_x_rite(tmp_path):
    path = tmp_path / "lamp.txt"
    path.write_text(X_RITE, newline="")
    theirs = colour.read_sds_from_xrite_file(str(path))["A1"]
    np.testing.assert_array_equal(load_spectrum(str(path)).value, theirs.values)


def test_ies_tm27(tmp_path):
    path = tmp_path / "lamp.spdx"
    sd = colour.SpectralDistribution_IESTM2714(
        str(path), spectral_quantity="irradiance", data=FILE_VALUES, domain=FILE_NM
    )
    sd.write()
    got = load_measured(str(path))
    np.testing.assert_allclose(got.spectrum.value, FILE_VALUES, rtol=1e-11)  # as written there
    assert (got.format, got.unit.quantity) == ("IES TM-27", "irradiance")


SEKONIC = "Date Saved,01/01/2024\nMeasuring Mode,Ambient\n" + "".join(
    f"Spectral Data {nm:.0f}[nm],{value!r}\n"
    for nm, value in zip(FILE_NM.tolist(), FILE_VALUES.tolist(), strict=True)
)
UPRTEK = "Model Name\tCV600\n" + "".join(
    f"{nm:.0f}nm\t{value!r}\n"
    for nm, value in zip(FILE_NM.tolist(), FILE_VALUES.tolist(), strict=True)
)


@pytest.mark.parametrize(("text", "watts"), [(SEKONIC, 1.0), (UPRTEK, 1e-3)])
def test_hand_held_meters(tmp_path, text, watts):
    path = tmp_path / "meter.csv"
    path.write_text(text)
    got = load_measured(str(path))
    np.testing.assert_allclose(got.spectrum.value, watts * FILE_VALUES, rtol=1e-12)
    assert got.unit.quantity == "irradiance"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("SpectralDistribution_Sekonic", "RANDOM_001_02._3262K.csv"),
        ("SpectralDistribution_UPRTek", "ESPD2021_0104_231446.xls"),
    ],
)
def test_units_of_meters_give_the_illuminance_that_they_show(name, words):
    """Their exports hold the illuminance, too: the samples in colour-science say 30.1 and 695.2."""
    from importlib.util import find_spec
    from pathlib import Path

    from rtbow.physics.light.spectrum import luminous

    folder = Path(find_spec("colour").origin).parent / "io" / "tests" / "resources"
    if not (folder / words).exists():
        pytest.skip("colour-science comes without its samples")
    expected = {"SpectralDistribution_Sekonic": 30.1, "SpectralDistribution_UPRTek": 695.15}[name]
    assert luminous(load_spectrum(str(folder / words))) == pytest.approx(expected, rel=2e-3)


SEVERAL = "ASTM G173,,,\nWvlgth nm,Etr W*m-2*nm-1,Global tilt  W*m-2*nm-1,Direct W*m-2*nm-1\n" + (
    rows().replace("\n", ",2.0,3.0\n")
)


def test_columns_are_chosen_by_name_or_number(tmp_path):
    path = tmp_path / "g173.csv"
    path.write_text(SEVERAL)
    for column, value in {
        "2": FILE_VISIBLE,
        "etr": FILE_VISIBLE,
        "global": 800.0,
        "4": 1200.0,
    }.items():
        got = load_measured(f"{path}#{column}")
        assert got.spectrum.visible == pytest.approx(value)
        assert got.unit.quantity == "irradiance"
    with pytest.raises(InputError, match="3 columns of values; choose one") as caught:
        load_spectrum(str(path))
    assert "g173.csv#2: 2 'Etr W*m-2*nm-1', 3 'Global tilt" in str(caught.value)
    for wrong in ("1", "5", "W*m", "none"):
        with pytest.raises(InputError, match="has no single column"):
            load_spectrum(f"{path}#{wrong}")


def test_columns_with_numbers_for_names_go_by_the_numbers_in_the_message(tmp_path):
    path = tmp_path / "many.csv"
    path.write_text("wavelength,1,2\n380,5,7\n780,5,7\n")
    assert load_spectrum(f"{path}#2").visible == pytest.approx(2000.0)


def test_a_file_may_have_the_mark_of_a_column_in_its_name(tmp_path):
    path = tmp_path / "lamp#2.csv"
    path.write_text(HEAD + rows())
    assert load_spectrum(str(path)).visible == pytest.approx(FILE_VISIBLE)


def test_a_changed_file_is_read_anew(tmp_path):
    path = tmp_path / "lamp.csv"
    path.write_text("380,1\n780,1\n")
    assert load_spectrum(str(path)).visible == pytest.approx(400.0)
    path.write_text("380,2\n780,2\n")
    assert load_spectrum(str(path)).visible == pytest.approx(800.0)


def test_quick_and_careful_reading_agree(tmp_path):
    """Blocks of a long file, by NumPy, and the same with a first row in quotes, line by line."""
    nm = np.linspace(370.0, 790.0, 15_000)
    values = 1.0 + np.sin(nm)
    stream = io.StringIO()
    np.savetxt(stream, np.column_stack([nm, values]), fmt="%.6f", delimiter=";")
    path = tmp_path / "long.csv"
    path.write_text(HEAD + stream.getvalue().replace(".", ","))
    assert quick_table(path) is not None
    quick = load_spectrum(str(path))
    first, rest = stream.getvalue().replace(".", ",").split("\n", 1)
    path.write_text(HEAD + ";".join(f'"{cell}"' for cell in first.split(";")) + "\n" + rest)
    assert quick_table(path) is None
    careful = load_spectrum(str(path))
    np.testing.assert_array_equal(quick.wavelength_nm, careful.wavelength_nm)
    np.testing.assert_array_equal(quick.value, careful.value)
    np.testing.assert_allclose(quick.value, values, atol=1e-6)
