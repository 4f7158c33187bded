"""Fuzzes scene texts: sound ones with bytes, pieces and values exchanged."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fuzz.extremes import scene_text as drawn_text
from fuzz.harness import refusal
from rtbow import RtbowError, load_scene
from rtbow.scene.text.file import builtin_scenes, scene_from_text
from rtbow.scene.text.values import scene_text

suffix = ".toml"
seconds = 20.0
mebibytes = 1024

Rng = np.random.Generator

_PIECES = (
    "[[", "]]", "{", "}", '"""', "'''", '"', "'", "=", ".", ",", "#", "\n", "\r\n", "\0", "\x7f",
    "\\u0000", "\\U0010ffff", "\u202e", "\ufeff", "1e400", "-1e400", "nan", "-inf", "0x" + "f" * 99,
    "9" * 400, "9" * 5000, "1_0", "1979-05-27T07:32:00Z", "07:32:00", "true", "[light]",
    "[[light]]", "[droplets]", "compare.right", "a." * 60 + "a", "a." * 3000 + "a", "[" * 90,
    "[" * 5000,
    "{ a = " * 80, "{ a = " * 2000, "x" * 100_000, "'" + "y" * 100_000 + "'", "0.0", "-1", "[]",
    "{}", '""', '"FL2"', "1e-320", "[[1, 2, 3], [4, 5, 6]]", "type = 'point'", "file = 'a\\u0000b'",
)  # fmt: skip


def make(seed: int) -> bytes:
    """Damage a sound text."""
    rng = np.random.default_rng([seed, 72])
    texts = [path.read_bytes() for path in builtin_scenes().values()]
    text = texts[rng.integers(len(texts))]
    if rng.random() < 0.5:
        text = drawn_text(rng, "any").encode()
    for _ in range(int(rng.choice([1, 1, 2, 4, 16]))):
        text = _MUTATIONS[rng.integers(len(_MUTATIONS))](rng, text)
    return text


def attempt(path: Path) -> str:
    """Read a scene; one that is accepted must be the same when written and read again."""
    try:
        scene = load_scene(path)
    except RtbowError as error:
        return refusal(error, 12, 1200)
    assert scene_from_text(scene_text(scene)) == scene, "another scene once written and read again"
    return "read"


def _place(rng: Rng, text: bytes) -> tuple[int, int]:
    start = int(rng.integers(len(text) + 1))
    return start, min(len(text), start + int(2 ** rng.uniform(0.0, 8.0)))


def _flip(rng: Rng, text: bytes) -> bytes:
    data = bytearray(text or b" ")
    data[rng.integers(len(data))] ^= 1 << int(rng.integers(8))
    return bytes(data)


def _byte(rng: Rng, text: bytes) -> bytes:
    data = bytearray(text or b" ")
    data[rng.integers(len(data))] = int(rng.integers(256))
    return bytes(data)


def _remove(rng: Rng, text: bytes) -> bytes:
    start, end = _place(rng, text)
    return text[:start] + text[end:]


def _repeat(rng: Rng, text: bytes) -> bytes:
    start, end = _place(rng, text)
    return text[:start] + text[start:end] * int(rng.choice([2, 2, 2, 200])) + text[end:]


def _insert(rng: Rng, text: bytes) -> bytes:
    start, _ = _place(rng, text)
    return text[:start] + _piece(rng) + text[start:]


def _replace(rng: Rng, text: bytes) -> bytes:
    start, end = _place(rng, text)
    return text[:start] + _piece(rng) + text[end:]


def _value(rng: Rng, text: bytes) -> bytes:
    """Put something else after an equals sign."""
    lines = text.split(b"\n")
    having = [n for n, line in enumerate(lines) if b"=" in line]
    if having:
        at = having[rng.integers(len(having))]
        lines[at] = lines[at].partition(b"=")[0] + b"= " + _piece(rng)
    return b"\n".join(lines)


def _key(rng: Rng, text: bytes) -> bytes:
    """Put something else before an equals sign."""
    lines = text.split(b"\n")
    having = [n for n, line in enumerate(lines) if b"=" in line]
    if having:
        at = having[rng.integers(len(having))]
        lines[at] = _piece(rng) + b" =" + lines[at].partition(b"=")[2]
    return b"\n".join(lines)


def _swap(rng: Rng, text: bytes) -> bytes:
    lines = text.split(b"\n")
    i, j = rng.integers(len(lines), size=2)
    lines[i], lines[j] = lines[j], lines[i]
    return b"\n".join(lines)


def _piece(rng: Rng) -> bytes:
    return _PIECES[rng.integers(len(_PIECES))].encode()


_MUTATIONS = (
    _flip, _byte, _remove, _repeat, _insert, _replace, _value, _value, _key, _swap,
)  # fmt: skip
