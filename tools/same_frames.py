"""Check that two commits draw every built-in scene by every method alike, to the last bit.

    python tools/same_frames.py HEAD~10 HEAD
    python tools/same_frames.py v0.1 . --method fast --scene shower --scene default

Each commit is checked out into a worktree of its own under --work, where its frames are kept, so
that an interrupted comparison resumes, and a comparison with another commit draws only the new
frames. ``.`` is the working tree as it stands; its frames are always drawn anew.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

CHECKOUT = Path(__file__).resolve().parent.parent
METHODS = ("fast", "spectral", "reference")

# Runs inside each commit, through the names of the public interface alone.
DRAW = """
import sys, time
from pathlib import Path
import numpy as np
import rtbow
folder, size = Path(sys.argv[1]), [int(n) for n in sys.argv[2].split("x")]
for name in sys.argv[4].split(","):
    missing = [m for m in sys.argv[3].split(",") if not (folder / name / f"{m}.npy").exists()]
    if not missing:
        continue
    scene = rtbow.load_scene(name, overrides={"camera.size_px": size})
    (folder / name).mkdir(parents=True, exist_ok=True)
    with rtbow.Renderer(scene) as renderer:
        for method in missing:
            start = time.perf_counter()
            try:
                frame = renderer.render(method=method)
            except rtbow.InputError as error:  # a method that does not draw this scene
                frame = np.array(str(error))
            part = folder / name / f"{method}.part.npy"
            np.save(part, frame)
            part.rename(folder / name / f"{method}.npy")
            print(f"  {name} {method} {time.perf_counter() - start:.1f} s", flush=True)
"""


def git(*words: str) -> str:
    """Return what a git command prints."""
    done = subprocess.run(
        ["git", "-C", CHECKOUT, *words], check=True, capture_output=True, text=True
    )
    return done.stdout.strip()


def tree_of(commit: str, work: Path) -> tuple[Path, Path]:
    """Return the checkout of a commit, made where it is missing, and the folder of its frames."""
    if commit == ".":
        return CHECKOUT, Path(tempfile.mkdtemp(prefix="tree-", dir=work))
    digest = git("rev-parse", "--short=12", f"{commit}^{{commit}}")
    tree = work / f"{digest}-tree"
    if not tree.exists():
        git("worktree", "prune")
        git("worktree", "add", "--detach", str(tree), digest)
    return tree, work / f"{digest}-frames"


def draw(tree: Path, frames: Path, size: str, methods: list[str], scenes: list[str]) -> None:
    """Draw the frames that a commit lacks."""
    words = [str(frames), size, ",".join(methods), ",".join(scenes)]
    # The worktree's own package comes first, whichever one is installed.
    environment = {**os.environ, "PYTHONPATH": str(tree)}
    subprocess.run([sys.executable, "-c", DRAW, *words], check=True, cwd=tree, env=environment)


def compare(first: Path, second: Path, name: str, method: str) -> str:
    """Return what differs between two commits' frames, or nothing."""
    a, b = (np.load(folder / name / f"{method}.npy") for folder in (first, second))
    if a.dtype.kind == "U" or b.dtype.kind == "U":
        refusals = [str(x) if x.dtype.kind == "U" else "a frame" for x in (a, b)]
        return "" if refusals[0] == refusals[1] else " / ".join(refusals)
    if a.shape != b.shape:
        return f"sizes {a.shape} and {b.shape}"
    differs = np.ascontiguousarray(a).view(np.uint32) != np.ascontiguousarray(b).view(np.uint32)
    if not differs.any():
        return ""
    scale = max(float(np.abs(a).max()), 1e-30)
    worst = float(np.abs(a - b).max()) / scale
    return f"{differs.any(axis=-1).mean():.1%} of pixels, by at most {worst:.2g} of the peak"


def main() -> None:
    """Draw and compare; the exit code is 1 where anything differs."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("before", help="a commit")
    parser.add_argument("after", help="another one, or . for the working tree")
    parser.add_argument("--size", default="160x90")
    parser.add_argument("--method", action="append", choices=METHODS, help="default: all three")
    parser.add_argument("--scene", action="append", help="default: all built-in ones")
    default_work = Path(tempfile.gettempdir()) / "rtbow-same-frames"
    parser.add_argument("--work", type=Path, default=default_work, help=f"default: {default_work}")
    given = parser.parse_args()
    work = given.work.resolve()
    work.mkdir(parents=True, exist_ok=True)
    methods = given.method or list(METHODS)
    built_in = CHECKOUT / "scenes"
    scenes = given.scene or sorted(
        str(path.relative_to(built_in).with_suffix("")) for path in built_in.rglob("*.toml")
    )
    folders = []
    for commit in (given.before, given.after):
        tree, frames = tree_of(commit, work)
        frames = frames / given.size
        start = time.perf_counter()
        print(f"{commit}:", flush=True)
        draw(tree, frames, given.size, methods, scenes)
        print(f"  drawn in {time.perf_counter() - start:.0f} s", flush=True)
        folders.append(frames)
    found = {
        (name, method): compare(folders[0], folders[1], name, method)
        for name in scenes
        for method in methods
    }
    for (name, method), what in found.items():
        if what:
            print(f"{name} {method}: {what}")
    same = sum(not what for what in found.values())
    print(f"{same} of {len(found)} frames are the same, bit for bit")
    sys.exit(same != len(found))


if __name__ == "__main__":
    main()
