"""Write docs/api.md from the docstrings of rtbow's public names.

python tools/make_api.py
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from pathlib import Path

import rtbow

PAGE = Path(__file__).resolve().parent.parent / "docs" / "api.md"
_HEAD = """# Python

Made from the docstrings by `python tools/make_api.py`. What is not named here may change without
notice. Arrays are NumPy's; all errors are subclasses of `rtbow.RtbowError`.
"""
_ORDER = (
    "load_scene", "make_scene", "Volume", "Scene", "Renderer", "show", "tone_map",
    "RtbowError", "InputError", "UnavailableError",
)  # fmt: skip
_SECTION = re.compile(r"(Args|Returns|Raises|Attributes|Example|Source):$")
_ROLE = re.compile(r":(?:func|class|meth|mod|attr):`~?(?:rtbow\.)?([^`]+)`")


def api_page() -> str:
    """Give the page: each public name, with its signature, docstring and methods."""
    return "\n".join([_HEAD, *(line for name in _ORDER for line in _described(name))])


def _described(name: str) -> Iterator[str]:
    thing = getattr(rtbow, name)
    yield f"## `rtbow.{name}`\n"
    if inspect.isclass(thing) and (issubclass(thing, Exception) or name == "Scene"):
        yield _prose(inspect.getdoc(thing) or "")
        if name == "Scene":
            yield "Its tables and keys are those of [scene files](../scenes/README.md).\n"
        return
    yield f"```python\nrtbow.{name}{_signature(thing)}\n```\n"
    yield _prose(inspect.getdoc(thing) or "")
    if inspect.isclass(thing):
        yield from _members(name, thing)


def _members(name: str, thing: type) -> Iterator[str]:
    """Describe the methods and properties that a class of ours has, in their order."""
    for key, member in vars(thing).items():
        text = inspect.getdoc(member)
        if key.startswith("_") or not text:
            continue
        if isinstance(member, property):
            yield f"### `{name}.{key}`\n"
        elif inspect.isfunction(member):
            yield f"### `{name}.{key}`\n"
            yield f"```python\n{key}{_signature(member)}\n```\n"
        else:
            continue
        yield _prose(text)


def _signature(thing: object) -> str:
    """Give a signature without ``self``, and types without the modules that they are from."""
    signature = inspect.signature(thing)  # type: ignore[arg-type]
    parts: list[str] = []
    kinds: list[object] = []
    for one in signature.parameters.values():
        if one.name == "self":
            continue
        if one.kind is one.KEYWORD_ONLY and one.KEYWORD_ONLY not in kinds:
            parts.append("*")
        elif one.kind is not one.POSITIONAL_ONLY and one.POSITIONAL_ONLY in kinds[-1:]:
            parts.append("/")
        kinds.append(one.kind)
        stars = "**" if one.kind is one.VAR_KEYWORD else ""
        default = "" if one.default is one.empty else f" = {_value(one.default)}"
        parts.append(f"{stars}{one.name}: {_type(one.annotation)}{default}")
    result = signature.return_annotation
    end = "" if result in ("None", None, signature.empty) else f" -> {_type(result)}"
    line = f"({', '.join(parts)}){end}"
    return line if len(line) < 80 else "(\n    " + ",\n    ".join(parts) + f",\n){end}"


def _value(default: object) -> str:
    """Write a default; functions by their name, others as they are typed in Python."""
    return getattr(default, "__name__", repr(default))


def _type(annotation: object) -> str:
    text = annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)
    return re.sub(r"\b(?:[a-z_]+\.)+(?=[A-Z])", "", text)


def _prose(text: str) -> str:
    """Give a docstring as Markdown: sections with bold titles, their entries as lists."""
    lines: list[str] = []
    section = ""
    for line in _ROLE.sub(r"``\1``", text).replace("``", "`").splitlines():
        if title := _SECTION.match(line):
            if section == "Example":
                lines.append("```")
            section = title[1]
            lines += [f"**{section}**", "", *(["```pycon"] if section == "Example" else [])]
        elif section == "Example" and not line.strip():
            continue
        elif section == "Example":
            lines.append(line.removeprefix("    "))
        elif entry := re.match(r"    (\S.*?): (.*)", line) if _lists(section) else None:
            lines.append(f"- `{entry[1]}`: {entry[2]}")
        elif _lists(section) and line.startswith("        "):
            lines.append(f"  {line.strip()}")
        else:
            lines.append(line.removeprefix("    ") if section else line)
    if section == "Example":
        lines.append("```")
    return "\n".join(lines) + "\n"


def _lists(section: str) -> bool:
    return section in ("Args", "Raises", "Attributes")


if __name__ == "__main__":
    PAGE.write_text(api_page(), encoding="utf-8")
