"""Where a sequence goes: names of its frames and films, and what stands there already."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rtbow.errors import InputError
from rtbow.files import check_suffix, check_writable
from rtbow.film import FILM_SUFFIXES
from rtbow.image import FRAME_SUFFIXES, frame_texts

SEQUENCE_TEXT = "animation"
"""The text of a frame that only sequences write: the command that made all of it."""

_NUMBER = re.compile(r"%%|%(0[1-9][0-9]?)?d")


@dataclass(frozen=True)
class Pattern:
    """Names of frames by their numbers, such as ``out/frame_%04d.exr``."""

    text: str

    def path(self, number: int) -> str:
        """Give the name of a frame, counted from 0."""

        def put(found: re.Match[str]) -> str:
            return "%" if found[0] == "%%" else found[0] % number

        return _NUMBER.sub(put, self.text)

    def beyond(self, count: int) -> list[str]:
        """Give the frames that are there with numbers of ``count`` or more, by number."""
        name = os.path.basename(self.text)
        digits, at = "", 0
        for found in _NUMBER.finditer(name):
            field = "%" if found[0] == "%%" else "([0-9]{1,15})"
            digits += re.escape(name[at : found.start()]) + field
            at = found.end()
        digits += re.escape(name[at:])
        try:
            there = os.listdir(os.path.dirname(self.path(0)) or ".")
        except OSError:  # nothing can be told of it
            return []
        numbers = {int(fit[1]) for one in there if (fit := re.fullmatch(digits, one))}
        paths = (self.path(number) for number in sorted(numbers) if number >= count)
        return [path for path in paths if os.path.lexists(path)]  # 07 is no %d

    @property
    def suffix(self) -> str:
        """The files' ending, in lower case."""
        return Path(self.text).suffix.lower()


@dataclass(frozen=True)
class Outputs:
    """Where a sequence goes.

    Attributes:
        frames: names of frames.
        films: names of films.
    """

    frames: tuple[Pattern, ...]
    films: tuple[str, ...]

    @property
    def shown(self) -> bool:
        """Whether displayed pictures are asked for, which need an exposure."""
        return bool(self.films) or any(one.suffix == ".png" for one in self.frames)


def parse_outputs(texts: Sequence[str]) -> Outputs:
    """Tell frames from films, and check that all can be written.

    Raises:
        InputError: a name that says neither, or a file that cannot be written there.
    """
    frames, films = [], []
    for text in dict.fromkeys(texts):
        if Path(text).suffix.lower() in FILM_SUFFIXES:
            check_writable(text, FILM_SUFFIXES)
            films.append(text)
            continue
        check_suffix(text, FRAME_SUFFIXES + FILM_SUFFIXES, _numbered(text, FRAME_SUFFIXES[0]))
        _check_number(text)
        pattern = Pattern(text)
        check_writable(pattern.path(0), FRAME_SUFFIXES)
        frames.append(pattern)
    return Outputs(tuple(frames), tuple(films))


def _check_number(text: str) -> None:
    """Raise InputError unless a pattern's file name holds the frame's number once."""
    path = Path(text)
    if not _numbers_once(path.name):
        raise InputError(
            f"{text}: a file name must hold the frame's number once, as %04d; write for example"
            f" {_numbered(text, path.suffix)}"
        )


def _numbers_once(name: str) -> bool:
    """Whether a file name holds the frame's number once, and no other percent sign."""
    numbers = [found for found in _NUMBER.finditer(name) if found[0] != "%%"]
    return len(numbers) == 1 and "%" not in _NUMBER.sub("", name)


def _numbered(text: str, suffix: str) -> Path:
    """Give a name for frames that is near the one that was typed."""
    path = Path(text)
    if os.path.isdir(path):  # so is no name at all
        return path / f"frame_%04d{suffix}"
    stem = path.stem.rstrip(".")
    if not _numbers_once(stem):
        stem = re.sub(r"%[^.]*", "", stem) + "%04d"
    return path.with_name(stem + suffix)


# --- What is there -----------------------------------------------------------------------------


def refuse_foreign(outputs: Outputs, count: int) -> None:
    """Raise InputError if frames would take the place of files that no sequence left there.

    Args:
        outputs: where a sequence goes.
        count: of its frames.
    """
    paths = [one.path(number) for one in outputs.frames for number in range(count)]
    foreign = [path for path in paths if _is_foreign(path)]
    if foreign:
        several = len(foreign) > 1
        raise InputError(
            f"{foreign[0]}: is there, and rtbow animate did not write it"
            f"{f' ({len(foreign)} such files)' if several else ''}; choose another folder or name,"
            f" remove {'them' if several else 'it'}, or let --overwrite replace"
            f" {'them' if several else 'it'}"
        )


def _is_foreign(path: str) -> bool:
    """Whether something stands at a frame's place that no sequence wrote; a device may stay."""
    return os.path.isdir(path) or (os.path.isfile(path) and SEQUENCE_TEXT not in frame_texts(path))


def frames_beyond(outputs: Outputs, count: int) -> list[str]:
    """Give the frames that are there with numbers that a sequence of ``count`` frames lacks."""
    return [path for one in outputs.frames for path in one.beyond(count)]
