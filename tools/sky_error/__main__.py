"""The command line: ``python tools/sky_error [PART]...``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import get_args

# Python puts this folder there, whose modules are those of a package in the one above.
_TOOLS = Path(__file__).resolve().parents[1]
sys.path[0] = str(_TOOLS)
sys.path.insert(1, str(_TOOLS.parent / "tests" / "support"))

import sky_error  # noqa: E402
from markup import table  # noqa: E402
from rtbow.scene.air import Aerosol  # noqa: E402
from sky_error.row import Rows  # noqa: E402

PARTS = {
    "molecules": "all orders of molecules' light against SASKTRAN2's",
    "polarisation": "its degree, against the same",
    "single": "one scattering against SASKTRAN2's and a quadrature of its own",
    "haze": "ten settings with aerosol, ozone and ground against two programs",
    "measured": "two skies that were measured; --fit",
    "energy": "light that comes in and neither arrives at the ground nor leaves",
    "clear": "fields of clear air that come with the program against those that are solved for",
    "nodes": "what twice as many nodes, rays, azimuths or pieces change",
    "rays": "the shader's tables against the reference, single rays",
    "small": "frames of `uniform` against the reference, all pixels",
    "large": "frames of `curtain` against the reference at 1 nm; --pixels",
    "moved": "the work that a moved sun makes",
    "start": "whole processes, with an empty cache and with a full one",
    "cost": "frames of `curtain` with and without a sky, in turn; --runs",
}

_MODEL = "continental-average"
"""That of ``skies.measured``."""


def rows(part: str, given: argparse.Namespace) -> Rows:
    """Measure a part."""
    # Late: what the parts are is said without all that measures them.
    from sky_error import air, frames, times

    simple = {
        "molecules": air.molecular, "polarisation": air.polarised, "single": air.single,
        "haze": air.haze, "energy": air.energy, "clear": air.clear_fields, "nodes": air.nodes,
        "rays": air.single_rays, "small": frames.small, "moved": times.moved, "start": times.start,
    }  # fmt: skip
    match part:
        case "measured":
            return air.sky_measured(given.fit)
        case "large":
            return frames.large(given.pixels)
        case "cost":
            return times.cost(given.runs)
    return simple[part]()


def main() -> int:
    """Measure what is asked for; give the exit status."""
    parser = argparse.ArgumentParser(
        prog="python tools/sky_error",
        description=sky_error.__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("part", nargs="*", help="of those that --list names; left out: all")
    parser.add_argument("--list", action="store_true", help="name the parts, and end")
    models = get_args(Aerosol.model_fields["model"].annotation)
    parser.add_argument("--fit", nargs="?", const=_MODEL, choices=models, metavar="MODEL",
                        help="fit the aerosol of the measured skies anew: "
                        f"{', '.join(models)}; by itself: {_MODEL}")  # fmt: skip
    parser.add_argument("--pixels", type=int, default=400,
                        help="of large frames that are compared (default 400)")  # fmt: skip
    parser.add_argument("--runs", type=int, default=15, help="of each frame timed (default 15)")
    given = parser.parse_args()
    if given.list:
        print("\n".join(f"{name:14}{said}" for name, said in PARTS.items()))
        return 0
    for name in given.part:
        if name not in PARTS:
            parser.error(f"{name}: no such part; must be one of {', '.join(PARTS)}")
    print(table(("part", "what", "found", "bound"), []), flush=True)
    held = True
    for name in given.part or PARTS:
        for row in rows(name, given):
            held = held and row.holds
            print(f"| {' | '.join((name, *row.cells()))} |", flush=True)
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
