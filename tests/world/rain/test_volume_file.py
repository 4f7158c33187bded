"""Volume files of any bytes: memory follows what is there, and each refusal is an InputError."""

import io
import os
import struct
import tracemalloc
import zipfile

import numpy as np
import pytest

from rtbow.base.errors import InputError
from rtbow.world.rain.volume_file import read_volume_file

BOX = np.array([[-50.0, 10.0, 0.0], [50.0, 90.0, 70.0]])
SHAPE = (5, 4, 3)
MIB = 1 << 20


def npy(array):
    buffer = io.BytesIO()
    np.save(buffer, array, allow_pickle=True)
    return buffer.getvalue()


def described(descr, shape, data=b"", version=(1, 0), fortran=False):
    """An array with a header of one's own."""
    text = f"{{'descr': {descr}, 'fortran_order': {fortran}, 'shape': {shape}, }}".encode("latin1")
    length = struct.pack("<H" if version == (1, 0) else "<I", len(text))
    return b"\x93NUMPY" + bytes(version) + length + text + data


RADIUS, NUMBER = np.full(SHAPE, 300.0, np.float32), np.full(SHAPE, 20.0, np.float32)
GOOD = {"radius_um.npy": npy(RADIUS), "number_per_m3.npy": npy(NUMBER), "box_m.npy": npy(BOX)}


def packed(members, way=zipfile.ZIP_DEFLATED):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", way) as archive:
        for name, data in members.items() if isinstance(members, dict) else members:
            archive.writestr(name, data)
    return buffer.getvalue()


@pytest.fixture
def read(tmp_path):
    def read(content):
        path = tmp_path / "rain.npz"
        path.write_bytes(content)
        return read_volume_file(path)

    return read


@pytest.fixture
def refused(read):
    """Read what must be refused; give the message, the memory that was taken being next to none."""

    def refused(content):
        tracemalloc.start()
        try:
            with pytest.raises(InputError) as caught:
                read(content)
            assert tracemalloc.get_traced_memory()[1] < 4 * MIB
        finally:
            tracemalloc.stop()
        assert len(str(caught.value)) < 700
        return str(caught.value)

    return refused


LARGE = b"\0" * (8 * MIB)


@pytest.mark.parametrize(
    ("descr", "version", "suffix", "name"),
    [
        ("'<f4'", (1, 0), ".npy", "radius_um"),
        ("'>f8'", (2, 0), "", "number_per_m3"),
        ("'<f16'", (3, 0), ".npy", "number_per_m3"),
        ("'|i1'", (3, 0), "", "radius_um"),
        ("'<f8'", (3, 0), "", "box_m"),
        ("'<U4000'", (1, 0), ".npy", "box_m"),
        ("'|S90000'", (3, 0), ".npy", "radius_um"),
    ],
)
def test_no_header_takes_memory(refused, descr, version, suffix, name):
    large = described(descr, (2000, 2000, 50), LARGE, version)
    members = {n.removesuffix(".npy"): data for n, data in GOOD.items()} | {name: large}
    assert name in refused(packed({n + suffix: data for n, data in members.items()}))


@pytest.mark.parametrize("way", [zipfile.ZIP_LZMA, zipfile.ZIP_BZIP2])
def test_unusual_compression_is_refused(refused, way):
    assert "numpy.savez_compressed" in refused(packed(GOOD, way))


def test_length_in_the_directory_is_not_believed(refused):
    content = bytearray(packed(GOOD))
    at = content.index(b"PK\x01\x02")
    content[at + 24 : at + 28] = struct.pack("<I", 0xF0000000)
    header = described("'<f4'", (1000, 1000, 100))
    assert "damaged" in refused(bytes(content))
    assert "damaged" in refused(packed(GOOD | {"radius_um.npy": header}))


def test_a_directory_longer_than_that_of_arrays_is_not_read(refused):
    members = [(f"{n:06d}" * 20, b"") for n in range(8000)]
    assert "directory" in refused(packed([*GOOD.items(), *members]))


@pytest.mark.parametrize(
    ("shape", "data"),
    [(SHAPE, 239), (SHAPE, 241), (SHAPE, 0), ((-5, -4, 3), 240), ("(5, 4, 3", 240),
     ("(5L, 4L, 3L, 10L)", 240), ("(10**9,)", 240), ((99999999999999999999, 1, 1), 240)],
)  # fmt: skip
def test_data_must_be_as_long_as_the_header_says(refused, shape, data):
    assert "radius_um" in refused(
        packed(GOOD | {"radius_um.npy": described("'<f4'", shape, b"\0" * data)})
    )


@pytest.mark.parametrize(
    "descr",
    ["'<c8'", "'|O'", "'<M8[s]'", "[('a', '<f4')]", "'<f4' * 2", "None", "'<z9'", "'|V0'", "1",
     "__import__('os')", "'<f3'", "'float128'"],
)  # fmt: skip
@pytest.mark.parametrize("version", [(1, 0), (3, 0), (4, 0), (0, 1)])
def test_types_that_are_no_numbers(refused, descr, version):
    array = described(descr, SHAPE, b"\0" * 240, version)
    assert "radius_um" in refused(packed(GOOD | {"radius_um.npy": array}))


@pytest.mark.parametrize(
    "header", ["", "{", "}", "(" * 9000, "-" * 9000 + "1", "{" * 9000, "\0\0", "'''", "\\", "$",
               "  if\n x", "{'a': 1}", "x" * 60000, "{'descr': '<f4', 'descr': '<f4', 'shape': ()}"]
)  # fmt: skip
def test_damaged_headers(refused, header):
    start = b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header))
    assert "header" in refused(packed(GOOD | {"radius_um.npy": start + header.encode()}))


@pytest.mark.parametrize("content", [b"", b"\x93NUM", b"no array at all", b"\x93NUMPY\x01"])
def test_members_that_are_no_arrays(refused, content):
    assert "radius_um" in refused(packed(GOOD | {"radius_um.npy": content}))


def test_members_must_be_there_once(refused):
    assert "radius_um 2 times" in refused(packed({**GOOD, "radius_um": GOOD["radius_um.npy"]}))


def test_encrypted(refused):
    content = bytearray(packed(GOOD))
    for magic, flags in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        at = -1
        while (at := content.find(magic, at + 1)) >= 0:
            content[at + flags] |= 1
    assert "password" in refused(bytes(content))


@pytest.mark.parametrize(
    "array",
    [
        RADIUS.astype(">f4"),
        RADIUS.astype(np.float64),
        RADIUS.astype(np.longdouble),
        RADIUS.astype(np.float16),
        RADIUS.astype(np.int64),
        RADIUS.astype(np.uint16),
        np.asfortranarray(RADIUS * np.arange(1, 6).reshape(5, 1, 1)),
    ],
    ids=lambda array: array.dtype.str,
)
def test_every_type_of_real_numbers_is_read(read, array):
    box, radius, number = read(packed(GOOD | {"radius_um.npy": npy(array)}))
    np.testing.assert_array_equal(radius, array.astype(np.float32), strict=True)
    np.testing.assert_array_equal(number, NUMBER, strict=True)
    np.testing.assert_array_equal(box, BOX, strict=True)


@pytest.mark.parametrize("version", [(1, 0), (2, 0), (3, 0)])
def test_every_version_and_other_programs_headers(read, version):
    for descr, shape in (("'<f4'", "(5, 4, 3)"), ('"<f4"', "(5,4,3)"), ("'<f4'", "(5L, 4L, 3L)")):
        array = described(descr, shape, RADIUS.tobytes(), version)
        assert np.all(read(packed(GOOD | {"radius_um.npy": array}))[1] == 300.0)


@pytest.mark.parametrize(
    "box",
    [
        np.array([[-(2**63)] * 3, [1, 2, 3]]),
        np.array([[-(2**63)] * 3, [2**63 - 1] * 3]),
        np.array([[0, 0, 0], [2**64 - 1] * 3], np.uint64),
        np.array([[0.0] * 3, [5e-324] * 3]),
        np.array([[0.0] * 3, [1e-5, 1.0, 1.0]]),
        np.array([[0.0] * 3, [np.inf] * 3], np.float16),
        np.array([[0.0] * 3, [1e300] * 3], np.longdouble),
        np.array([[250, 0, 0], [1, 1, 1]], np.uint8),
        np.array([[-1e8] * 3, [1e8] * 3]),
    ],
)
def test_boxes(refused, box):
    assert "box_m = [[" in refused(packed(GOOD | {"box_m.npy": npy(box)}))


@pytest.mark.parametrize(
    ("start", "what"),
    [(b"\x89HDF\r\n\x1a\n", "NetCDF or HDF5"), (b"CDF\x02", "NetCDF"), (b" BDV\0\0", "OpenVDB")],
)
def test_other_formats_are_named_with_a_way_out(refused, start, what):
    message = refused(start + b"\0" * 100)
    assert what in message
    assert "numpy.savez_compressed(" in message
    assert "tools/" not in message


def test_what_is_no_file(tmp_path):
    pipe = tmp_path / "pipe.npz"
    os.mkfifo(pipe)
    for path in (pipe, tmp_path, tmp_path / ("x" * 300), tmp_path / "a\0b.npz"):
        with pytest.raises(InputError) as caught:
            read_volume_file(path)
        assert "\0" not in str(caught.value)


def test_memory_of_a_million_points(tmp_path):
    shape = (128, 128, 64)
    path = tmp_path / "rain.npz"
    radius = np.random.default_rng(1).uniform(100.0, 900.0, shape)  # float64: twice as large
    np.savez(path, radius_um=radius, number_per_m3=np.ones(shape), box_m=BOX)
    tracemalloc.start()
    try:
        read_volume_file(path)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 8 * radius.size + 3 * MIB
