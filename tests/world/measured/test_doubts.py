"""Files that are doubtful or no spectra: one message, and little of them in it."""

import contextlib
import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rtbow.world.measured.source as source
from lamp_samples import FILE_NM, FILE_VALUES, FILE_VISIBLE, rows
from rtbow.base.errors import InputError
from rtbow.world.measured.spectra import load_measured, load_spectrum


def refusal(path, **options):
    with pytest.raises(InputError) as caught:
        load_spectrum(str(path), **options)
    return str(caught.value)


SECRET = "correct horse battery staple " * 4
NO_TABLES = {
    "passwd": f"root:x:0:0:root:/root:/bin/sh\nuser:{SECRET}:1000:1000::/home:/bin/sh\n",
    "key": f"-----BEGIN PRIVATE KEY-----\n{SECRET}\n-----END PRIVATE KEY-----\n",
    "settings": f"password = {SECRET}\nport = 5432\n",
    "a row by accident": f"12 {SECRET}\n380 1\n{SECRET}\n500 {SECRET}\n",
    "page": f"<html><body>{SECRET}</body></html>",
    "picture": b"\x89PNG\r\n\x1a\n\x00\x00" + SECRET.encode(),
    "spreadsheet": b"PK\x03\x04" + SECRET.encode(),
    "NUL": b"380,1\n500,\x00" + SECRET.encode() + b"\n780,1\n",
}


@pytest.mark.parametrize("name", NO_TABLES)
def test_nothing_is_quoted_of_what_is_no_table(tmp_path, name):
    path = tmp_path / "file.txt"
    text = NO_TABLES[name]
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    message = refusal(path)
    assert "horse" not in message
    assert message.startswith(f"{path}:")


def test_forty_characters_of_a_table_are_quoted_at_most(tmp_path):
    path = tmp_path / "lamp.csv"
    path.write_text(f"nm,v\n380,1\n500,{SECRET}\n780,1\n")
    message = refusal(path)
    assert message.startswith(f"{path}:3: expected two numbers")
    assert SECRET[:20] in message
    assert SECRET[:40] not in message


def test_columns_names_come_to_forty_characters(tmp_path):
    path = tmp_path / "lamp.csv"
    path.write_text(f"nm,{SECRET},{SECRET}\n" + rows().replace("\n", ",1\n"))
    message = refusal(path)
    assert message.count("horse") == 1


def test_what_is_not_printable_is_escaped():
    assert source.quoted("a\x07\u202eb") == "'a\\x07\\u202eb'"


@pytest.mark.parametrize("break_line", ["395,bad", "395", "395,1,2", "395,"])
def test_a_broken_line_is_named_wherever_the_longer_part_is(tmp_path, break_line):
    path = tmp_path / "lamp.csv"
    lines = ["nm,v", *rows().splitlines()]
    for at in (4, 78):
        path.write_text("\n".join([*lines[:at], break_line, *lines[at:]]))
        assert refusal(path).startswith(f"{path}:{at + 1}: ")


def test_noise_below_zero_is_told(tmp_path):
    path = tmp_path / "lamp.csv"
    noisy = FILE_VALUES - 0.0230
    path.write_text("nm,v\n" + rows(y=noisy))
    got = load_measured(str(path))
    np.testing.assert_array_equal(got.spectrum.value, np.maximum(noisy, 0.0))
    assert got.notes[0].startswith("lamp.csv: 1 of 81 values are below zero, by 0.00021")
    path.write_text("nm,v\n" + rows(y=FILE_VALUES - 0.1))
    assert refusal(path).startswith(f"{path}:82: value -0.07")


@pytest.mark.parametrize("low", [380.0, 400.0, 380.03])
@pytest.mark.parametrize("high", [780.0, 730.0, 779.98])
def test_what_is_beyond_the_range(tmp_path, low, high):
    """Zero adds nothing to the integral over what the file has, hold adds its ends' rectangles."""
    path = tmp_path / "lamp.csv"
    path.write_text(f"nm,v\n{low},2\n{high},3\n")
    own = 2.5 * (high - low)
    held = own + 2.0 * (low - 380.0) + 3.0 * (780.0 - high)
    rounded = low < 380.05 and high > 779.95
    if rounded:
        assert load_spectrum(str(path)).visible == pytest.approx(held)
    else:
        message = refusal(path)
        assert f"covers {low:g}-{high:g} nm" in message
        assert '"zero"' in message
        assert '"hold"' in message
        assert load_spectrum(str(path), "zero").visible == pytest.approx(own, rel=1e-7)
    got = load_spectrum(str(path), "hold")
    assert got.visible == pytest.approx(held)
    assert got.wavelength_nm[0] <= 380.0
    assert got.wavelength_nm[-1] >= 780.0
    assert np.all(np.diff(got.wavelength_nm) > 0.0)


@pytest.mark.parametrize("ends", ["100,1\n300,1\n", "800,1\n900,1\n"])
def test_a_light_that_is_not_visible_is_refused(tmp_path, ends):
    path = tmp_path / "lamp.csv"
    path.write_text("wavelength_nm,v\n" + ends)
    assert "is visible" in refusal(path, beyond="hold")


def test_large_files_are_refused_before_they_are_read(tmp_path, monkeypatch):
    path = tmp_path / "lamp.csv"
    path.write_text("nm,v\n" + rows())
    monkeypatch.setattr(source, "MOST_BYTES", 1000)
    assert "are read as a spectrum" in refusal(path)
    monkeypatch.undo()
    monkeypatch.setattr(source, "MOST_TEXT_BYTES", 1000)
    assert load_spectrum(str(path)).visible == pytest.approx(FILE_VISIBLE)
    path.write_text("nm,v\n" + rows() + "the end of 381\n380,0\n")
    assert "not all rows of numbers alike" in refusal(path)


def test_a_pipe_is_refused(tmp_path):
    path = tmp_path / "pipe.csv"
    os.mkfifo(path)
    assert "is not a regular file" in refusal(path)


NOISE = st.text(alphabet="0123456789.,;:|\t\n \r-+eEdDnm()[]/#µλ\"'", max_size=120)


@settings(max_examples=60, deadline=None)
@given(before=NOISE, after=NOISE, cut=st.integers(0, 81), raw=st.binary(max_size=8))
def test_any_damage_is_read_or_refused(tmp_path_factory, before, after, cut, raw):
    path = tmp_path_factory.mktemp("damaged") / "lamp.csv"
    lines = rows().splitlines(keepends=True)
    text = "nm,v\n" + "".join(lines[:cut]) + before + "".join(lines[cut:]) + after
    path.write_bytes(text.encode() + raw)
    try:
        got = load_spectrum(str(path), "zero")
    except InputError:
        return
    assert np.all(np.isfinite(got.value))
    assert np.all(got.value >= 0.0)
    assert np.all(np.diff(got.wavelength_nm) > 0.0)


def test_regular_expressions_do_not_run_away(tmp_path):
    """Each of these took minutes while a pattern could match its parts in many ways."""
    path = tmp_path / "lamp.txt"
    for text in (
        "400:0.123456789, " * 400 + "x",
        "9" * 20_000 + "x\n380 1\n",
        "-" * 20_000 + "x\n" + rows(FILE_NM, FILE_VALUES, " "),
        "BEGIN_DATA SPECTRAL_\n" + "\n" * 20_000,
        "(" * 20_000 + ",v\n" + rows(),
        "wavelength " + " " * 20_000 + "x\n" + rows(FILE_NM, FILE_VALUES, " "),
    ):
        path.write_text(text)
        with contextlib.suppress(InputError):
            load_spectrum(str(path))
