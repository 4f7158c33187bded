"""Where a sequence goes: the names of its frames and films, and which files are in their way."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rtbow.base.errors import InputError
from rtbow.base.files import check_distinct, check_suffix, check_writable
from rtbow.frames.film import FILM_SUFFIXES, film_texts
from rtbow.frames.image import FRAME_SUFFIXES, frame_texts
from rtbow.sequence.record import RECORD_SUFFIX, is_record

SEQUENCE_TEXT = "animation"
"""Frames of sequences, and no others, carry this text: the command that made the sequence."""
_FILM_TEXT = "rtbowVersion"
"""All films that rtbow makes carry this text; only sequences make films."""

_NUMBER = re.compile(r"%%|%(0[1-9][0-9]?)?d")
_OTHER_FILMS = (".avi", ".m4v", ".mkv", ".mov", ".mpeg", ".mpg", ".ogv", ".webm", ".wmv")
"""Endings of films that rtbow does not make."""


@dataclass(frozen=True)
class Pattern:
    """Names of frames by their numbers, such as ``out/frame_%04d.exr``."""

    text: str

    def path(self, number: int) -> str:
        """Give the name of a frame, counted from 0."""
        name = os.path.basename(self.text)
        name = _NUMBER.sub(lambda field: "%" if field[0] == "%%" else field[0] % number, name)
        return os.path.join(self._folder, name)

    def beyond(self, count: int) -> list[str]:
        """List the files of this pattern with numbers of ``count`` or more, by number."""
        name = re.escape(os.path.basename(self.text))
        name = _NUMBER.sub(lambda field: "%" if field[0] == "%%" else "([0-9]{1,15})", name)
        try:
            entries = os.listdir(self._folder or ".")
        except OSError:
            return []
        numbers = {int(match[1]) for entry in entries if (match := re.fullmatch(name, entry))}
        paths = (self.path(number) for number in sorted(numbers) if number >= count)
        return [path for path in paths if os.path.lexists(path)]  # 07 is no %d

    @property
    def record(self) -> str:
        """The name of the record that lists the frames done (:mod:`rtbow.sequence.record`)."""
        stem = _without_number(Path(self.text).stem).replace("%%", "%")
        return os.path.join(self._folder, (stem or "frames") + RECORD_SUFFIX)

    @property
    def suffix(self) -> str:
        """The files' ending, in lower case."""
        return Path(self.text).suffix.lower()

    @property
    def _folder(self) -> str:
        return os.path.dirname(self.text).replace("%%", "%")  # %d stays: it may be called 50%dry


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

    @property
    def records(self) -> tuple[str, ...]:
        """The names of the frames' records, each once."""
        return tuple(dict.fromkeys(pattern.record for pattern in self.frames))


def parse_outputs(texts: Sequence[str]) -> Outputs:
    """Tell frames from films, and check that all can be written.

    Raises:
        InputError: a name is that of neither, or is given twice, or a file cannot be written
            there.
    """
    check_distinct(texts)
    frames, films = [], []
    for text in texts:
        suffix = Path(text).suffix.lower()
        if suffix in FILM_SUFFIXES:
            if any(field[0] != "%%" for field in _NUMBER.finditer(Path(text).name)):
                raise InputError(
                    f"{text}: a film is one file, without numbers; write for example"
                    f" {_unnumbered(text)}"
                )
            check_writable(text, FILM_SUFFIXES)
            films.append(text)
            continue
        film = suffix in _OTHER_FILMS
        example = _unnumbered(text) if film else _numbered(text, FRAME_SUFFIXES[0])
        check_suffix(text, FRAME_SUFFIXES + FILM_SUFFIXES, example)
        _check_number(text)
        pattern = Pattern(text)
        check_writable(pattern.path(0), FRAME_SUFFIXES)
        check_writable(pattern.record, (Path(RECORD_SUFFIX).suffix,))
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
    numbers = [field for field in _NUMBER.finditer(name) if field[0] != "%%"]
    return len(numbers) == 1 and "%" not in _NUMBER.sub("", name)


def _numbered(text: str, suffix: str) -> Path:
    """Give a name for frames that is near the one that was typed."""
    path = Path(text)
    if os.path.isdir(path):  # an empty name, too
        return path / f"frame_%04d{suffix}"
    stem = path.stem.rstrip(".")
    if not _numbers_once(stem):
        stem = re.sub(r"%[^.]*", "", stem) + "%04d"
    return path.with_name(stem + suffix)


def _unnumbered(text: str) -> Path:
    """Give a name for a film that is near the one that was typed."""
    path = Path(text)
    return path.with_name((_without_number(path.stem) or "film") + FILM_SUFFIXES[0])


def _without_number(stem: str) -> str:
    """Take the frame's number out of a name, with the sign before it that sets it apart."""
    return re.sub(
        rf"[-_. ]?(?:{_NUMBER.pattern})",
        lambda field: field[0] if field[0].endswith("%%") else "",
        stem,
    )


# --- Files in the way --------------------------------------------------------------------------


def check_places(outputs: Outputs, count: int, *, overwrite: bool) -> None:
    """Raise InputError if a sequence would replace a folder, or a file of another origin.

    Args:
        outputs: where the sequence goes.
        count: how many frames it has.
        overwrite: whether files of another origin may be replaced; folders never are.
    """
    frames = [pattern.path(number) for pattern in outputs.frames for number in range(count)]
    folders = [path for path in (*frames, *outputs.records) if os.path.isdir(path)]
    if folders:
        several, it = _counted(folders, "folders")
        raise InputError(
            f"{folders[0]}: is a folder; must be a file{several}; choose another name, or move"
            f" {it} away"
        )
    if overwrite:
        return
    # Devices are written to, not replaced.
    foreign = [
        *(one for one in frames if os.path.isfile(one) and SEQUENCE_TEXT not in frame_texts(one)),
        *(
            one
            for one in outputs.films
            if os.path.isfile(one) and _FILM_TEXT not in film_texts(one)
        ),
        *(one for one in outputs.records if os.path.isfile(one) and not is_record(one)),
    ]
    if foreign:
        several, it = _counted(foreign, "files")
        raise InputError(
            f"{foreign[0]}: is there, and rtbow animate did not write it{several}; choose another"
            f" folder or name, remove {it}, or let --overwrite replace {it}"
        )


def _counted(paths: Sequence[str], what: str) -> tuple[str, str]:
    """Say how many there are where they are several, and what to call them after that."""
    return (f" ({len(paths)} such {what})", "them") if len(paths) > 1 else ("", "it")


def frames_beyond(outputs: Outputs, count: int) -> list[str]:
    """List the files that are named like frames of a sequence of more than ``count`` frames."""
    return [path for pattern in outputs.frames for path in pattern.beyond(count)]
