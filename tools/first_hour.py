"""Run the recipes of docs/howto.md from an empty folder, and print how long each takes.

    python tools/first_hour.py [--size 96x54] [--pictures docs/howto] [NAME ...]

NAME is a part of a recipe's title. ``--pictures`` copies the pictures that the page shows into a
folder; it goes with the size that the page has.
"""

from __future__ import annotations

import argparse
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "howto.md"
PAGE_SIZE = "480x270"
"""The size of frames that the commands of the page have."""

_BLOCK = re.compile(r"(?ms)^```(sh|python)\n(.*?)^```$")
_PICTURE = re.compile(r"!\[[^\]]+\]\(howto/([^)]+)\)")
_OUTPUT = re.compile(r"(?:-o|export) ([\w.%-]+)|\.save(?:z)?\(\s*\"([^\"]+)\"|--json ([\w.]+)")


@dataclass(frozen=True)
class Block:
    """What is typed at once.

    Attributes:
        language: ``sh`` or ``python``.
        text: the lines.
    """

    language: str
    text: str


@dataclass(frozen=True)
class Recipe:
    """A section of the page.

    Attributes:
        title: its heading.
        blocks: what is typed, in order.
        pictures: names of the files that the page shows, made by the blocks.
    """

    title: str
    blocks: tuple[Block, ...]
    pictures: tuple[str, ...]

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of all files that the blocks write; of numbered ones the first."""
        named = (m for block in self.blocks for m in _OUTPUT.findall(block.text))
        return tuple("".join(names).replace("%04d", "0000") for names in named)


def recipes(page: Path = PAGE) -> tuple[Recipe, ...]:
    """Read the recipes of a page: its sections of the second level."""
    sections = re.split(r"(?m)^## ", page.read_text(encoding="utf-8"))[1:]
    return tuple(
        Recipe(
            title=section.split("\n", 1)[0],
            blocks=tuple(Block(*found) for found in _BLOCK.findall(section)),
            pictures=tuple(_PICTURE.findall(section)),
        )
        for section in sections
    )


def environment(commands: Path) -> dict[str, str]:
    """Make ``rtbow`` this checkout's, in a folder for commands; give the environment for it."""
    commands.mkdir(parents=True, exist_ok=True)
    command = commands / "rtbow"
    command.write_text(f'#!/bin/sh\nexec {shlex.quote(sys.executable)} -m rtbow "$@"\n')
    command.chmod(0o755)
    search = os.pathsep.join([str(commands), os.environ.get("PATH", os.defpath)])
    return {**os.environ, "PATH": search, "PYTHONPATH": str(ROOT)}


def run(recipe: Recipe, folder: Path, env: dict[str, str], size: str = PAGE_SIZE) -> str:
    """Run the blocks of a recipe in a folder, with frames of another size.

    Returns:
        What the blocks printed, stderr included.

    Raises:
        subprocess.CalledProcessError: a block failed; ``output`` is what it printed.
    """
    printed = []
    for block in recipe.blocks:
        text = block.text.replace(PAGE_SIZE, size)
        start = ["sh", "-e", "-c"] if block.language == "sh" else [sys.executable, "-c"]
        done = subprocess.run(
            [*start, text], cwd=folder, env=env, check=True, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
        )  # fmt: skip
        printed.append(done.stdout)
    return "".join(printed)


def timed(wanted: list[str], size: str, pictures: Path | None) -> Iterator[tuple[str, float]]:
    """Run recipes in an empty folder, and yield the title and seconds of each."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place, "work")
        folder.mkdir()
        env = environment(Path(place, "commands"))
        for recipe in recipes():
            if wanted and not any(name.lower() in recipe.title.lower() for name in wanted):
                continue
            start = time.perf_counter()
            run(recipe, folder, env, size)
            yield recipe.title, time.perf_counter() - start
            if pictures:
                pictures.mkdir(parents=True, exist_ok=True)
                for name in recipe.pictures:
                    shutil.copyfile(folder / name, pictures / name)


def main() -> int:
    """Read the command line, and print a line for each recipe; give the exit status."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--size", default=PAGE_SIZE, metavar="WxH")
    parser.add_argument("--pictures", type=Path, metavar="DIR")
    options = parser.parse_args()
    total = 0.0
    try:
        for title, seconds in timed(options.names, options.size, options.pictures):
            print(f"{seconds:7.1f} s  {title}", flush=True)
            total += seconds
    except subprocess.CalledProcessError as error:
        print(error.output, file=sys.stderr)
        return 1
    print(f"{total:7.1f} s  together")
    return 0


if __name__ == "__main__":
    sys.exit(main())
