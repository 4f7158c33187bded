"""Shader files to driver and back: includes, defines, and messages that name file and line.

A shader file starts with neither ``#version`` nor defines; both come from here, so that constants
have one source. ``#include "name.glsl"`` takes a file once per program stage, however often it is
named.
"""

from __future__ import annotations

import math
import numbers
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from rtbow.base.errors import RtbowError

if TYPE_CHECKING:
    import moderngl

Define = bool | int | float | str
NO_DEFINES: Mapping[str, Define] = MappingProxyType({})

VERSION_LINE = "#version 330 core"
HEADER_NAME = "(defines)"

_INCLUDE = re.compile(r'\s*#\s*include\s+"([^"]+)"\s*(?://.*)?$')
_DIRECTIVE = re.compile(r"\s*#\s*(\w+)")
_IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
# Comments, in which a directive says nothing; "//" first, since it hides a "/*" after it.
_COMMENT = re.compile(r"//[^\n]*|/\*.*?(?:\*/|\Z)", re.DOTALL)

# Mesa "0:41(12): error: text"; NVIDIA "0(41) : error C0000: text"; AMD, Intel, Apple
# "ERROR: 0:41: text". The 0 is the number of the source string, of which there is one.
_LOCATIONS = (
    re.compile(r"^0:(?P<line>\d+)\(\d+\): (?P<text>.*)$"),
    re.compile(r"^0\((?P<line>\d+)\) : (?P<text>.*)$"),
    re.compile(r"^(?P<kind>ERROR|WARNING): 0:(?P<line>\d+): ?(?P<text>.*)$"),
)
_STAGE_HEADING = re.compile(r"(vertex|fragment)(?:_shader$| info$)", re.IGNORECASE)


class ShaderError(RtbowError):
    """A shader that cannot be put together, compiled or linked; names file and line."""

    exit_code = 1


@dataclass(frozen=True)
class ShaderSource:
    """What the driver compiles, and where each of its lines came from.

    ``files`` names the files in the order in which they begin; ``places[n]`` is the file and line
    of line ``n + 1`` of ``text``. No ``#line`` is used for this: Mesa (22.3) forgets the file
    number in its semantic errors, and what ``#line`` counts from differs between versions of GLSL.
    """

    text: str
    files: tuple[str, ...]
    places: tuple[tuple[str, int], ...]

    def locate(self, compiler_message: str) -> str:
        """Rewrite a driver's message so that its places read ``rain/march.glsl:41: error …``."""
        return "\n".join(self._locate_line(line) for line in compiler_message.splitlines())

    def _locate_line(self, message: str) -> str:
        for pattern in _LOCATIONS:
            match = pattern.match(message)
            if match and 1 <= int(match["line"]) <= len(self.places):
                file, line = self.places[int(match["line"]) - 1]
                kind = match.groupdict().get("kind")
                prefix = f"{kind.lower()}: " if kind else ""
                return f"{file}:{line}: {prefix}{match['text']}"
        return message


def load_program_source(
    main: str, defines: Mapping[str, Define] = NO_DEFINES, directory: Path | None = None
) -> ShaderSource:
    """Put one program stage together from files.

    Args:
        main: name of the stage's file in ``directory``.
        defines: name to value. A bool becomes 1 or 0, a float a literal of full float32
            precision, a str is taken as it stands.
        directory: where the files are; left out: the package's shaders.

    Raises:
        ShaderError: a missing or circular include, a directive that belongs to the host, a value
            that GLSL cannot hold.
    """
    directory = _shader_directory() if directory is None else directory
    return _Assembly(directory, defines).source(main, _read(directory, main, "the program"))


def assemble(
    text: str,
    defines: Mapping[str, Define] = NO_DEFINES,
    directory: Path | None = None,
    name: str = "(text)",
) -> ShaderSource:
    """Put one program stage together from a text that may include files.

    Args:
        text: the stage's own text.
        defines: as for :func:`load_program_source`.
        directory: as for :func:`load_program_source`.
        name: what messages call the text.

    Raises:
        ShaderError: as :func:`load_program_source`.
    """
    directory = _shader_directory() if directory is None else directory
    return _Assembly(directory, defines).source(name, text)


def compile_program(
    ctx: moderngl.Context,
    vertex: str | ShaderSource,
    fragment: str | ShaderSource,
    defines: Mapping[str, Define] = NO_DEFINES,
    directory: Path | None = None,
) -> moderngl.Program:
    """Compile and link a vertex and a fragment stage in the context that is current.

    Args:
        ctx: the current context.
        vertex: file name of the stage, or its source.
        fragment: file name of the stage, or its source.
        defines: for both stages, where they are given by file name.
        directory: as for :func:`load_program_source`.

    Raises:
        ShaderError: with the driver's messages, each at its file and line.
    """
    import moderngl

    sources = {
        stage: source
        if isinstance(source, ShaderSource)
        else load_program_source(source, defines, directory)
        for stage, source in (("vertex", vertex), ("fragment", fragment))
    }
    try:
        return ctx.program(
            vertex_shader=sources["vertex"].text, fragment_shader=sources["fragment"].text
        )
    except moderngl.Error as error:
        title = " + ".join(source.files[0] for source in sources.values())
        raise ShaderError(f"{title}: {_locate_stages(str(error), sources)}") from error


def _locate_stages(message: str, sources: Mapping[str, ShaderSource]) -> str:
    """Locate each line of a message by the stage whose heading stands above it.

    moderngl heads a compiler's message with "fragment_shader", NVIDIA's linker its parts with
    "Fragment info". Above any heading a place could be in either stage and is left as it is.
    """
    source: ShaderSource | None = None
    lines = []
    for line in message.strip().splitlines():
        heading = _STAGE_HEADING.match(line)
        if heading:
            source = sources[heading[1].lower()]
        lines.append(line if source is None else source.locate(line))
    return "\n".join(lines)


def glsl_literal(value: Define) -> str:
    """Write a value as GLSL reads it back: floats as the nearest float32, never as an int.

    Raises:
        ShaderError: not finite, or outside of GLSL's int or float.
    """
    if isinstance(value, str):
        if "\n" in value or "\r" in value:
            raise ShaderError(f"{value!r} has more than one line; a define has one")
        return value
    if isinstance(value, bool | np.bool_):
        return "1" if value else "0"
    if isinstance(value, numbers.Integral):
        number = int(value)
        # The literal of the smallest int would be a minus before a number that is too large.
        if not -(2**31) < number < 2**31:
            raise ShaderError(f"{number} does not fit into a GLSL int; must be ±2147483647")
        return f"({number})" if number < 0 else str(number)
    with np.errstate(over="ignore"):  # refused below
        number32 = float(np.float32(value))
    if not math.isfinite(number32):
        raise ShaderError(f"{value} does not fit into a GLSL float; must be finite, up to 3.4e38")
    digits = f"{number32:.9g}"  # nine digits tell every float32 from its neighbours
    if not re.search(r"[.e]", digits):
        digits += ".0"
    return f"({digits})" if digits.startswith("-") else digits


def _shader_directory() -> Path:
    from rtbow.base.resources import resource_dir

    return resource_dir("shaders")


def _header(defines: Mapping[str, Define]) -> list[str]:
    lines = [VERSION_LINE]
    for name in sorted(defines):
        if not _IDENTIFIER.fullmatch(name) or name.startswith("gl_") or "__" in name:
            raise ShaderError(f"{name!r} is no name for a define: letters, digits and single _")
        try:
            lines.append(f"#define {name} {glsl_literal(defines[name])}".rstrip())
        except ShaderError as error:
            raise ShaderError(f"define {name}: {error}") from None
    return lines


def _read(directory: Path, name: str, asked_by: str) -> str:
    try:
        return (directory / name).read_text(encoding="utf-8-sig")
    except OSError as error:
        reason = error.strerror or error
        raise ShaderError(f"{asked_by}: cannot read shader file {name!r}: {reason}") from error


def _blank_comments(text: str) -> str:
    """Return the text without comments, with as many lines as before."""
    return _COMMENT.sub(lambda match: " " + "\n" * match[0].count("\n"), text)


class _Assembly:
    """One stage in the making: which files it has so far, and which are open."""

    def __init__(self, directory: Path, defines: Mapping[str, Define]) -> None:
        self._directory = directory
        self._lines = _header(defines)
        self._places = [(HEADER_NAME, n) for n in range(1, len(self._lines) + 1)]
        self._files: list[str] = []
        self._taken: set[Path] = set()
        self._open: list[tuple[Path, str]] = []

    def source(self, name: str, text: str) -> ShaderSource:
        self._add(name, text)
        text = "\n".join(self._lines) + "\n"
        return ShaderSource(text, tuple(self._files), tuple(self._places))

    def _add(self, name: str, text: str) -> None:
        path = (self._directory / name).resolve()
        self._files.append(name)
        self._taken.add(path)
        self._open.append((path, name))
        conditions = 0
        code_lines = _blank_comments(text).split("\n")
        # Some compilers stop at a character beyond ASCII even in a comment.
        lines = text.encode("ascii", "replace").decode("ascii").split("\n")
        for index, (line, code) in enumerate(zip(lines, code_lines, strict=True), start=1):
            directive = _DIRECTIVE.match(code)
            kind = directive[1] if directive else ""
            where = f"{name}:{index}"
            if kind in ("version", "line"):
                raise ShaderError(f"{where}: #{kind} is the host's business; remove it here")
            conditions += (kind in ("if", "ifdef", "ifndef")) - (kind == "endif")
            if kind != "include":
                self._lines.append(line)
                self._places.append((name, index))
                continue
            match = _INCLUDE.match(line)
            if match is None:
                raise ShaderError(f'{where}: must read #include "name.glsl"')
            if conditions > 0:
                # Taken once, it would be missing wherever else it is named if this were not met.
                raise ShaderError(f"{where}: an #include may not stand inside #if; move it out")
            self._include(match[1], where)
        self._open.pop()

    def _include(self, name: str, where: str) -> None:
        path = (self._directory / name).resolve()
        open_paths = [open_path for open_path, _ in self._open]
        if path in open_paths:
            cycle = [open_name for _, open_name in self._open[open_paths.index(path) :]]
            raise ShaderError(f"{where}: circular #include: {' -> '.join([*cycle, name])}")
        if path not in self._taken:
            self._add(name, _read(self._directory, name, where))
