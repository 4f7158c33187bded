"""Files of drop sizes: layouts that mean the same, and what is refused."""

import numpy as np
import pytest

from rtbow.base.errors import InputError
from rtbow.base.resources import resource_dir
from rtbow.physics.size_classes import PARSIVEL_MIDDLES_MM
from rtbow.world.rain.size_file import read_size_file

# Of a shower, log10 of N(D) in m-3 mm-1 in a Parsivel's classes: invented.
LOGARITHMS = [
    -9.999, -9.999, 2.8, 2.9, 2.95, 2.9, 2.85, 2.8, 2.7, 2.6, 2.45, 2.2, 1.95, 1.7, 1.4, 1.0,
    0.5, -0.1, -0.7, *[-9.999] * 13,
]  # fmt: skip
MIDDLES = [f"{int(1000 * d) / 1000:.3f}" for d in PARSIVEL_MIDDLES_MM]  # cut, as OTT prints them
WIDTHS = [0.125] * 10 + [0.25] * 5 + [0.5] * 5 + [1.0] * 5 + [2.0] * 5 + [3.0] * 2
NUMBER = [10.0**value * width if value > -9.0 else 0.0
          for value, width in zip(LOGARITHMS, WIDTHS, strict=True)]  # fmt: skip


def lines(*columns, mark=","):
    return [mark.join(map(str, row)) for row in zip(*columns, strict=True)]


def linear(factor=1.0):
    return [f"{factor * 10.0**v if v > -9.0 else 0.0:.9g}" for v in LOGARITHMS]


PER_UM = linear(1e-3)
UM = [f"{1000 * float(d):g}" for d in MIDDLES]
LAYOUTS = {
    "classes": [
        "class,mid_mm,width_mm,log10_N_per_m3_mm",
        *lines(range(1, 33), MIDDLES, WIDTHS, LOGARITHMS),
    ],
    "documented": ["diameter_um,number_per_m3_um", *lines(UM, PER_UM)],
    "without a header": ["# measured", "", *lines(UM, PER_UM)],
    "semicolons": [
        "Diameter (mm);N(D) (m-3 mm-1)",
        *[line.replace(".", ",") for line in lines(MIDDLES, linear(), mark=";")],
    ],
    "tabs": ["mid_um\twidth_mm\tN_per_cm3_um",
             *lines(UM, WIDTHS, linear(1e-9), mark="\t")],
    "blanks": ["diameter_mm number_per_m3_mm", *lines(MIDDLES, linear(), mark="   ")],
    "telegram": [";".join(map(str, LOGARITHMS)) + ";"],
    "column": [str(value) for value in LOGARITHMS],
    "named column": ["log10_N", *map(str, LOGARITHMS)],
}  # fmt: skip


@pytest.mark.parametrize("layout", LAYOUTS)
def test_layouts_mean_the_same(layout, tmp_path):
    path = tmp_path / "sizes.csv"
    path.write_text("\n".join(LAYOUTS[layout]), encoding="utf-8")
    classes = read_size_file(path)
    filled = [k for k, number in enumerate(NUMBER) if number > 0.0]
    np.testing.assert_allclose(classes.number_per_m3, np.array(NUMBER)[filled], rtol=1e-6)
    np.testing.assert_allclose(classes.middle_um, 500.0 * PARSIVEL_MIDDLES_MM[filled], atol=0.26)
    np.testing.assert_allclose(classes.width_um, 500.0 * np.array(WIDTHS)[filled])


def test_widths_are_half_way_to_the_neighbours(tmp_path):
    path = tmp_path / "probe.csv"
    path.write_text("diameter_um,number_per_m3_um\n10,1e6\n14,2e6\n20,1e6\n", encoding="utf-8")
    classes = read_size_file(path)
    np.testing.assert_allclose(classes.middle_um, [5.0, 7.0, 10.0])
    np.testing.assert_allclose(classes.number_per_m3, [4e6, 1e7, 6e6])


def test_the_sizes_that_ship():
    classes = read_size_file(resource_dir("scenes") / "shower-sizes.csv")
    # N0 Gamma(2.6) / Lambda^2.6 of its own head is 830 drops, of which 0.25 mm cut off a sixth.
    assert 650.0 < classes.total(0) < 830.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty; must hold lines diameter_um,number_per_m3_um"),
        ("diameter_um,number_per_m3_um\n", "holds no numbers"),
        ("diameter_um,number_per_m3_um\n10,1\n20,x\n", ":3: column number_per_m3_um: 'x' is no"),
        ("diameter_um,number_per_m3_um\n10,1\n20,nan\n", ":3: column number_per_m3_um: 'nan'"),
        ("diameter_um,number_per_m3_um\n10,1\n20,-3\n", ":3: column number_per_m3_um: -3 is neg"),
        ("diameter_um,number_per_m3_um\n10,1\n9,1\n", ":3: column diameter_um: 9 does not follow"),
        ("diameter_um,number_per_m3_um\n0,1\n9,1\n", ":2: column diameter_um: 0; must be above 0"),
        ("diameter_um,number_per_m3_um\n10,1\n20,1,5\n", ":3: has 3 columns; expected 2"),
        ("diameter_um,number_per_m3_um\n10,0\n20,0\n", "holds no drops"),
        ("diameter_um,number_per_m3_um\n10,1\n", "holds one diameter"),
        ("diameter_um,number_per_m3_um\n10,1e12\n20,1e12\n", "2e+13 drops per m3; must be up to"),
        ("diameter,number\n10,1\n20,1\n", ":1: column diameter does not say whether it is in um"),
        (
            "speed,number_per_m3_um\n10,1\n20,1\n",
            ":1: the header names speed, number_per_m3_um, and",
        ),
        ("mid_mm,log10_N_per_m3_mm\n1,900\n2,800\n", ":2: column log10_N_per_m3_mm: 900 is no log"),
        ("1\n2\n3\n", "3 lines of 1 numbers without a header"),
        ("log10_N\n1\n2\n", "holds 2 numbers without diameters; a Parsivel has 32"),
        ("\n".join([",".join(["1.0"] * 32)] * 3), "holds 3 spectra of 32 classes"),
    ],
)
def test_what_is_refused(text, message, tmp_path):
    path = tmp_path / "sizes.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_size_file(path)
    assert str(caught.value).startswith(str(path))
    assert message in str(caught.value)


def test_files_that_cannot_be_read(tmp_path):
    for path, message in ((tmp_path, "cannot be read"), (tmp_path / "no.csv", "not found")):
        with pytest.raises(InputError, match=message):
            read_size_file(path)
    binary = tmp_path / "photo.csv"
    binary.write_bytes(bytes(range(256)))
    with pytest.raises(InputError, match="cannot be read as text"):
        read_size_file(binary)


def test_rain_in_mm_without_a_header_is_not_taken_for_fog(tmp_path):
    path = tmp_path / "plain.csv"
    path.write_text("0.062,0.0\n0.312,800\n1.375,120\n4.75,1.5\n24.5,0\n", "utf-8")
    with pytest.raises(InputError, match=r"look like mm; .*diameter_mm,number_per_m3_mm"):
        read_size_file(path)
    path.write_text("2,100\n8,900\n20,300\n30,10\n", "utf-8")  # of a cloud
    assert read_size_file(path).middle_um.max() == 15.0
