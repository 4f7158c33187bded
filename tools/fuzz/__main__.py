"""The command line of the fuzzers: ``python tools/fuzz SUBJECT``."""

from __future__ import annotations

import argparse
import functools
import sys
from pathlib import Path
from typing import get_args

# Python puts this folder there, whose modules are those of a package in the one above.
sys.path[0] = str(Path(__file__).resolve().parents[1])

from fuzz import scenes  # noqa: E402
from fuzz.extremes import Cost  # noqa: E402
from fuzz.harness import SUBJECTS, Fuzzer, subject_of  # noqa: E402


def main() -> None:
    """Fuzz one subject for a while, or try a single seed."""
    parser = argparse.ArgumentParser(
        prog="python tools/fuzz",
        description="Try random inputs; those that end in a defect are kept, and the seed printed.",
        epilog="A later run with the same folder goes on with the next seed.",
    )
    parser.add_argument("subject", choices=SUBJECTS)
    parser.add_argument("--seconds", type=float, default=60.0, help="how long (default 60)")
    parser.add_argument("--seed", type=int, help="first seed; left out: the folder's next one")
    parser.add_argument("-o", "--folder", type=Path, help="default: fuzz-SUBJECT")
    parser.add_argument("--cost", choices=get_args(Cost), default="airy",
                        help="of scenes: quick ones, all but exact theory's, or any")  # fmt: skip
    parser.add_argument("--case", type=int, metavar="SEED", help="try one seed, in this process")
    options = parser.parse_args()
    folder = options.folder or Path(f"fuzz-{options.subject}")
    folder.mkdir(parents=True, exist_ok=True)
    subject = subject_of(options.subject)
    make = subject.make
    if options.subject == "scenes":
        make = functools.partial(scenes.make, cost=options.cost)
    if options.case is not None:
        path = folder / f"{options.case}{subject.suffix}"
        path.write_bytes(make(options.case))
        print(f"{path}: {subject.attempt(path)}")
        return
    report = Fuzzer(options.subject, folder, make).run(options.seconds, options.seed, print)
    print(report.text())
    sys.exit(1 if report.failures else 0)


if __name__ == "__main__":
    main()
