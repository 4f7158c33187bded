"""Fuzzes volume files: archives of arrays of any type and shape, and with bytes exchanged."""

from __future__ import annotations

import io
import struct
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from fuzz.harness import refusal
from rtbow import RtbowError
from rtbow.world.rain.volume import load_volume

suffix = ".npz"
seconds = 20.0
mebibytes = 512

Rng = np.random.Generator

_TYPES = ("<f4", ">f4", "<f8", "<f2", "<i2", ">u4", "|u1", "<i8", "<u8", "|b1", "<c8", "<U3", "|S5",
          "<M8[s]", "|V4", "<f16")  # fmt: skip
_ODD = (np.nan, np.inf, -np.inf, -1.0, -1e-30, 0.0, 1e-45, 1e12, 1.0000001e12, 1e38, 5e3, 0.9)
_DESCRIPTIONS = ("'|O'", "[('a', '<f4')]", "'<f4' * 9", "None", "'<U9999999'", "'|V2147483647'")
_SHAPES = ("(2, 2", "(-1, 2, 2)", "(99999, 99999, 99999)", "(1024, 1024, 1024)", "(True, 2, 2)",
           "(18446744073709551616, 1, 1)", "(512, 512, 512)", "((2, 2), 2)", "()",
           "(0, 0, 0)")  # fmt: skip


def sound_volume(rng: Rng) -> bytes:
    """Make a volume as people make them: showers, holes, far and near, of few points."""
    shape = tuple(int(n) for n in rng.integers(2, 9, 3))
    number = 10.0 ** rng.uniform(0.0, 6.0) * rng.random(shape)
    number[rng.random(shape) < rng.choice([0.0, 0.5, 0.95])] = 0.0
    radius = rng.uniform(1.0, 10.0 ** rng.uniform(0.5, 3.6), shape)
    low = rng.uniform(-2000.0, 2000.0, 3)
    buffer = io.BytesIO()
    np.savez_compressed(
        buffer,
        radius_um=radius.astype(np.float32),
        number_per_m3=number.astype(np.float32),
        box_m=np.array([low, low + 10.0 ** rng.uniform(-1.0, 4.0, 3)]),
    )
    return buffer.getvalue()


def make(seed: int) -> bytes:
    """Make an archive, sound or odd, and damage some of its bytes."""
    rng = np.random.default_rng([seed, 73])
    data = sound_volume(rng) if rng.random() < 0.3 else _odd_volume(rng)
    for _ in range(int(rng.choice([0, 1, 1, 2, 8]))):
        data = _damaged(rng, data)
    return data


def attempt(path: Path) -> str:
    """Read a volume, which must have finite moments."""
    try:
        volume = load_volume(path)
    except RtbowError as error:
        return refusal(error, 1, 1200)
    assert np.all(np.isfinite(volume.moments())), "its moments are not finite"
    assert np.all(np.isfinite(volume.box_m)), "its box is not finite"
    return "read"


def _odd_volume(rng: Rng) -> bytes:
    shape = [int(n) for n in rng.integers(1 if rng.random() < 0.1 else 2, 6, 3)]
    radius = rng.uniform(1.0, 2000.0, shape)
    number = rng.uniform(0.0, 1e4, shape)
    box: Any = np.array([[-50.0, 10.0, 0.0], [50.0, 90.0, 70.0]])
    for array in (radius, number, box):
        if rng.random() < 0.3:
            array.flat[rng.integers(array.size)] = rng.choice(_ODD)
    arrays = {"radius_um": radius, "number_per_m3": number, "box_m": box}
    members = [(name, _npy(rng, array)) for name, array in arrays.items()]
    if rng.random() < 0.1:
        members.append(members[rng.integers(3)])
    if rng.random() < 0.1:
        members.pop(int(rng.integers(len(members))))
    way = int(rng.choice([zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_DEFLATED,
                          zipfile.ZIP_BZIP2]))  # fmt: skip
    suffix = "" if rng.random() < 0.05 else ".npy"
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", way) as archive:
        for name, data in dict(members).items():
            archive.writestr(name + suffix, data)
    return buffer.getvalue()


def _npy(rng: Rng, array: np.ndarray[Any, Any]) -> bytes:
    """Write an array, of another type at times, or with a header that does not fit."""
    if rng.random() < 0.4:
        with np.errstate(all="ignore"):
            array = array.astype(_TYPES[rng.integers(len(_TYPES))])
    if rng.random() < 0.2:
        array = np.asfortranarray(array)
    if rng.random() < 0.7:
        buffer = io.BytesIO()
        np.save(buffer, array)
        return buffer.getvalue()
    descr, shape = repr(array.dtype.descr[0][1]), str(array.shape)
    if rng.random() < 0.5:
        descr = _DESCRIPTIONS[rng.integers(len(_DESCRIPTIONS))]
    else:
        shape = _SHAPES[rng.integers(len(_SHAPES))]
    text = f"{{'descr': {descr}, 'fortran_order': {rng.random() < 0.3}, 'shape': {shape}, }}"
    version = ((1, 0), (2, 0), (3, 0), (1, 1), (9, 9))[rng.integers(5)]
    length = struct.pack("<H" if version[0] == 1 else "<I", len(text))
    return b"\x93NUMPY" + bytes(version) + length + text.encode() + array.tobytes()


def _damaged(rng: Rng, data: bytes) -> bytes:
    changed = bytearray(data)
    # Headers and directory are where the readers decide; they lie at both ends.
    near = int(rng.integers(min(200, len(data)))) if data else 0
    at = [near, len(data) - 1 - near, int(rng.integers(len(data) or 1))][rng.integers(3)]
    kind = rng.random()
    if not data or kind < 0.1:
        return bytes(changed[:at])
    if kind < 0.2:
        return bytes(changed[:at] + changed[at + int(rng.integers(1, 40)) :])
    if kind < 0.3:
        return bytes(changed[:at] + rng.bytes(int(rng.integers(1, 40))) + changed[at:])
    if kind < 0.5:
        width = int(rng.choice([1, 2, 4, 8]))
        changed[at : at + width] = bytes([int(rng.choice([0, 255, 127, 128]))]) * width
    else:
        changed[at] ^= 1 << int(rng.integers(8))
    return bytes(changed)
