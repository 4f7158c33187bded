"""Search scenes drawn at random for one that method ``auto`` draws beyond its error.

Each seed's scene is drawn by ``auto``, and some of its pixels by the reference. A line for each:
what drew it, and CIEDE2000 of the sampled pixels, 99 %, with where 99 % of all pixels lie at 95 %
confidence. A scene is over its bound where the lower end of that is; where the sample's own
percentile alone is, a larger sample decides. Ends with the count, and with exit status 1 where one
is over.

    python tools/random_scenes.py 1 300 [--pixels 400] [--longest SIDE] [--log FILE]
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import rtbow
from rtbow.base.errors import RtbowError
from rtbow.bench.error import reference_xyz, sample_difference, sample_pixels
from rtbow.bench.random_scenes import random_scene


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("first", type=int)
    parser.add_argument("last", type=int)
    parser.add_argument("--pixels", type=int, default=400, help="compared with the reference")
    parser.add_argument("--longest", type=int, help="pixels of a longer side, at most")
    parser.add_argument("--log", type=Path, help="add the lines here, too, and skip its seeds")
    given = parser.parse_args()
    lines = given.log.read_text("utf-8").splitlines() if given.log and given.log.exists() else []
    done = {int(line.split()[0]) for line in lines}
    for seed in range(given.first, given.last + 1):
        if seed in done:
            continue
        try:
            lines.append(_line(seed, given.pixels, given.longest))
        except RtbowError as error:
            lines.append(f"{seed} {error} OVER".replace("\n", " "))
        print(lines[-1], flush=True)
        if given.log:
            with given.log.open("a", encoding="utf-8") as log:
                log.write(lines[-1] + "\n")
    over = [line for line in lines if line.endswith("OVER")]
    doubtful = [line.split()[0] for line in lines if line.endswith("perhaps")]
    print(f"{len(lines)} scenes, {len(over)} over their bound; perhaps: {doubtful}")
    sys.exit(1 if over else 0)


def _line(seed: int, pixels: int, longest: int | None) -> str:
    begun = time.perf_counter()
    scene = random_scene(seed, {})
    side = max(scene.camera.size_px)
    if longest and side > longest:
        size = [max(n * longest // side, 1) for n in scene.camera.size_px]
        scene = random_scene(seed, {"camera.size_px": size})
    with rtbow.Renderer(scene) as renderer:
        frame = renderer.render()
        method = renderer.method_used
    sample = sample_pixels(scene.camera.size_px, pixels)
    compared = sample_difference(sample.of(frame), reference_xyz(scene, sample), sample)
    width, height = scene.camera.size_px
    error = "dark"
    if compared.difference is not None:
        spread = compared.difference.delta_e
        low, high = spread.p99_range or (spread.p99, spread.p99)
        error = f"{spread.p99:.3f} ({low:.3f} to {high if high is None else round(high, 3)})"
        if spread.p99 > scene.render.max_delta_e:
            error += " OVER" if low > scene.render.max_delta_e else " perhaps"
    return f"{seed} {width}x{height} {method} {time.perf_counter() - begun:.1f}s {error}"


if __name__ == "__main__":
    main()
