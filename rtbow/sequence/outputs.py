"""Where a sequence goes: names of its frames and films, and what stands there already."""

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

SEQUENCE_TEXT = "animation"
"""The text of a frame that only sequences write: the command that made all of it."""
_FILM_TEXT = "rtbowVersion"
"""A text of each film that rtbow makes, which sequences alone do."""

_NUMBER = re.compile(r"%%|%(0[1-9][0-9]?)?d")
_OTHER_FILMS = (".avi", ".m4v", ".mkv", ".mov", ".mpeg", ".mpg", ".ogv", ".webm", ".wmv")
"""Endings of films that rtbow does not make."""


@dataclass(frozen=True)
class Pattern:
    """Names of frames by their numbers, such as ``out/frame_%04d.exr``."""

    text: str

    def path(self, number: int) -> str:
        """Give the name of a frame, counted from 0."""

        def put(found: re.Match[str]) -> str:
            return "%" if found[0] == "%%" else found[0] % number

        folder, name = os.path.split(self.text)  # a folder may be called 50%dry
        return os.path.join(folder.replace("%%", "%"), _NUMBER.sub(put, name))

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
        InputError: a name that says neither or is given twice, or a file that cannot be written
            there.
    """
    check_distinct(texts)
    frames, films = [], []
    for text in texts:
        suffix = Path(text).suffix.lower()
        if suffix in FILM_SUFFIXES:
            if any(found[0] != "%%" for found in _NUMBER.finditer(Path(text).name)):
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


def _unnumbered(text: str) -> Path:
    """Give a name for a film that is near the one that was typed."""
    path = Path(text)
    stem = re.sub(rf"[-_. ]?(?:{_NUMBER.pattern})", _percent_sign, path.stem)
    return path.with_name((stem or "film") + FILM_SUFFIXES[0])


def _percent_sign(found: re.Match[str]) -> str:
    return found[0] if found[0].endswith("%%") else ""


# --- What is there -----------------------------------------------------------------------------


def check_places(outputs: Outputs, count: int, *, overwrite: bool) -> None:
    """Raise InputError if a sequence would take the place of what no sequence left there.

    Args:
        outputs: where a sequence goes.
        count: of its frames.
        overwrite: whether files of another origin may be replaced; folders never are.
    """
    paths = [one.path(number) for one in outputs.frames for number in range(count)]
    folders = [path for path in paths if os.path.isdir(path)]
    if folders:
        several, it = _counted(folders, "folders")
        raise InputError(
            f"{folders[0]}: is a folder; must be a file{several}; choose another name, or move"
            f" {it} away"
        )
    if overwrite:
        return
    foreign = [path for path in paths if _is_foreign(path, SEQUENCE_TEXT)]
    foreign += [path for path in outputs.films if _is_foreign(path, _FILM_TEXT)]
    if foreign:
        several, it = _counted(foreign, "files")
        raise InputError(
            f"{foreign[0]}: is there, and rtbow animate did not write it{several}; choose another"
            f" folder or name, remove {it}, or let --overwrite replace {it}"
        )


def _counted(paths: Sequence[str], what: str) -> tuple[str, str]:
    """Tell how many there are where they are several, and what to call them after that."""
    return (f" ({len(paths)} such {what})", "them") if len(paths) > 1 else ("", "it")


def _is_foreign(path: str, text: str) -> bool:
    """Whether a file lacks the text that sequences leave; a device may stay."""
    if not os.path.isfile(path):
        return False
    is_film = Path(path).suffix.lower() in FILM_SUFFIXES
    return text not in (film_texts(path) if is_film else frame_texts(path))


def frames_beyond(outputs: Outputs, count: int) -> list[str]:
    """Give the frames that are there with numbers that a sequence of ``count`` frames lacks."""
    return [path for one in outputs.frames for path in one.beyond(count)]
