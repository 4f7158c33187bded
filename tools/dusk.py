"""Measure frames about sunset, where the edge of the Earth's shadow crosses the rain.

    python tools/dusk.py --work WORK --document docs/accuracy.md
    python tools/dusk.py --work WORK --box 3 --eye in --from 0 --to -1 --step 0.1

Each frame of methods ``auto`` and ``spectral`` is compared with the reference, and its lit pixels
with plain geometry: places sampled along each ray, looked at one by one. What is measured is kept
in WORK, so that an interrupted run resumes. Prints a table of all that was asked for; with
``--document``, measures the whole set instead and replaces the document's section on it.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

import rtbow
from budget.error_budget import DUSK_BEGIN, DUSK_END, with_section
from markup import bullets, paragraph, table
from rtbow.base.arrays import Array, floats
from rtbow.base.files import write_atomic
from rtbow.frames.difference import frame_difference
from rtbow.physics.light.colour import luminance, rgb_to_xyz
from rtbow.render.renderer import MethodName
from rtbow.scene.model import Scene
from rtbow.scene.text.file import load_scene
from rtbow.world.world import World, resolve

EYES = ("ground", "in", "above")
"""Where the eye is: on the ground before the rain, in it at half its height, over its top."""
RAINS = ("even", "dense", "mixture", "curtain", "shower")
"""Even drops; the same with extinction; a mixture; the volumes of two built-in scenes."""
BOXES_KM = (0.3, 1.2, 3.0, 6.0, 12.0)
_METHODS: tuple[MethodName, ...] = ("auto", "spectral")
_EARTH_M = 6_371_000.0
_NEAR_EDGE_M = 1.0
"""Rays whose lit length is less than this but not nothing count for neither side."""


@dataclass(frozen=True)
class Case:
    """A scene about sunset.

    Attributes:
        altitude_deg: of the sun.
        box_km: height of the box of rain; a built-in volume has its own.
        eye: one of ``EYES``.
        rain: one of ``RAINS``.
        size_px: of the picture.
    """

    altitude_deg: float
    box_km: float = 1.2
    eye: str = "ground"
    rain: str = "even"
    size_px: tuple[int, int] = (48, 27)

    @property
    def name(self) -> str:
        """The name of its measurement's file."""
        size = "x".join(map(str, self.size_px))
        return f"{self.rain}-{self.box_km:g}-{self.eye}-{self.altitude_deg:+.2f}-{size}.json"

    def scene(self) -> Scene:
        """Give the scene."""
        sun = {"light.0.altitude_deg": self.altitude_deg, "light.0.azimuth_deg": 180.0}
        picture = {"camera.size_px": list(self.size_px)}
        if self.rain in ("curtain", "shower"):
            name = self.rain
            return load_scene(name, {**sun, **picture})
        height = 1000.0 * self.box_km
        near, far = 0.4 * height, 2.5 * height
        place, view = {
            "ground": ([0.0, 0.0, 1.6], 25.0),
            "in": ([0.0, 0.8 * height, 0.5 * height], 10.0),
            "above": ([0.0, 0.0, 1.25 * height], -20.0),
        }[self.eye]
        radius: dict[str, object] = {"distribution": "constant", "radius_um": 400.0}
        density: dict[str, object] = {"number_per_m3": 300.0}
        if self.rain == "mixture":
            radius = {"distribution": "marshall-palmer", "min_um": 100.0, "max_um": 1500.0,
                      "mixing": "local"}  # fmt: skip
            density = {"rain_rate_mm_h": 5.0}
        return Scene.model_validate(
            {
                "camera": {"position_m": place, "altitude_deg": view, "fov_deg": 90.0,
                           "size_px": list(self.size_px)},
                "light": [{"altitude_deg": self.altitude_deg, "azimuth_deg": 180.0}],
                "droplets": {"box_m": [[-far, near, 0.0], [far, far, height]],
                             "extinction": self.rain == "dense",
                             "radius": radius, "density": density},
                "atmosphere": {"rayleigh": True},
            }
        )  # fmt: skip


@dataclass(frozen=True)
class Measured:
    """What a case gave.

    Attributes:
        used: the method that ``auto`` chose.
        p99: ΔE2000 at the 99th percentile of each method; none where the reference is black.
        worst: the greatest.
        lit: pixels that geometry says are lit.
        wrong: pixels of each method, reference included, that are lit or black against it.
        brightest: of the reference, cd/m².
    """

    used: str
    p99: dict[str, float]
    worst: dict[str, float]
    lit: int
    wrong: dict[str, int]
    brightest: float


def lit_lengths(world: World, samples: int = 2001) -> Array:
    """Give how much of each pixel's ray the sun reaches, by looking at places along it, one by one.

    Args:
        world: with one sun.
        samples: places along a ray.

    Returns:
        Lit length (h, w), m.
    """
    low, high = world.volume.box_m
    eye, sun = world.view.eye_m, world.optics.suns[0].direction
    width, height = world.view.size_px
    lit = np.zeros((height, width))
    for row, rays in enumerate(world.view.pixel_directions(slice(0, height))):
        with np.errstate(divide="ignore"):
            first, second = (low - eye) / rays, (high - eye) / rays
        begin = np.maximum(np.minimum(first, second).max(axis=-1), 0.0)
        length = np.maximum(np.maximum(first, second).min(axis=-1) - begin, 0.0)
        along = (np.arange(samples) + 0.5) / samples
        t = begin[:, None] + along * length[:, None]
        place = eye + t[..., None] * rays[:, None, :]
        # From the centre of an Earth that touches sea level below the eye.
        from_centre = place - np.array([eye[0], eye[1], -_EARTH_M])
        towards = from_centre @ sun
        nearest = np.linalg.norm(from_centre - towards[..., None] * sun, axis=-1)
        lit[row] = np.mean((towards >= 0.0) | (nearest >= _EARTH_M), axis=-1) * length
    return lit


def measure(case: Case) -> Measured:
    """Draw a case by every method, and compare."""
    scene = case.scene()
    lengths = lit_lengths(resolve(scene))
    sure = (lengths == 0.0) | (lengths > _NEAR_EDGE_M)
    with rtbow.Renderer(scene) as renderer:
        frames = {"reference": floats(renderer.render("reference"))}
        for method in _METHODS:
            frames[method] = floats(renderer.render(method))
            if method == "auto":
                used = renderer.method_used
    wrong = {
        name: int(np.sum(((frame != 0.0).any(axis=-1) != (lengths > 0.0)) & sure))
        for name, frame in frames.items()
    }
    exact = frames["reference"]
    p99: dict[str, float] = {}
    worst: dict[str, float] = {}
    if luminance(exact).max() > 0.0:
        for method in _METHODS:
            error = frame_difference(rgb_to_xyz(frames[method]), rgb_to_xyz(exact)).delta_e
            p99[method], worst[method] = float(error.p99), float(error.worst)
    lit = int(np.sum(lengths > 0.0))
    return Measured(str(used), p99, worst, lit, wrong, float(luminance(exact).max()))


def kept(case: Case, work: Path) -> Measured:
    """Measure a case, unless that was done before."""
    path = work / case.name
    if not path.exists():
        print(f"  {case.name}", flush=True)
        write_atomic(path, json.dumps(asdict(measure(case))).encode())
    return Measured(**json.loads(path.read_text("utf-8")))


def altitudes(first: float, last: float, step: float) -> list[float]:
    """Give altitudes from one to another, both included, in degrees."""
    count = round(abs(last - first) / step)
    return [round(float(a), 4) for a in np.linspace(first, last, count + 1)]


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.2f}"


def each(cases: Iterable[Case], work: Path) -> str:
    """Write a row for each case."""
    rows = []
    for case in cases:
        got = kept(case, work)
        errors = [_number(values.get(m)) for m in _METHODS for values in (got.p99, got.worst)]
        rows.append((f"{case.altitude_deg:+.1f}°", str(got.lit), f"{got.brightest:.3g}", got.used,
                     *errors, str(max(got.wrong.values()))))  # fmt: skip
    titles = ("sun", "lit pixels", "brightest, cd/m²", "`auto` takes", "ΔE 99 % of `auto`",
              "worst", "ΔE 99 % of `spectral`", "worst", "pixels wrongly lit or black")  # fmt: skip
    return table(titles, rows)


def summed(groups: Sequence[tuple[str, list[Case]]], work: Path) -> str:
    """Write a row for each group of cases: the worst of them."""
    rows = []
    for name, cases in groups:
        all_of_them = [kept(case, work) for case in cases]
        with_light = [got for got in all_of_them if got.p99]
        fast = sum(got.used == "fast" for got in with_light)
        errors = [_number(max((got.p99[m] for got in with_light), default=None)) for m in _METHODS]
        wrong = sum(max(got.wrong.values()) for got in all_of_them)
        rows.append((name, f"{len(with_light)} of {len(cases)}", str(fast), *errors, str(wrong)))
    titles = ("rain, eye", "frames with light", "of them `fast`", "ΔE 99 % of `auto`, worst frame",
              "of `spectral`", "pixels wrongly lit or black")  # fmt: skip
    return table(titles, rows)


_FINE = altitudes(2.0, -2.0, 0.1)
_COARSE = altitudes(2.0, -2.0, 0.5)
_GRID = altitudes(0.0, -0.75, 0.25)
_SMALL = (32, 18)
_SAID = {"ground": "eye on the ground", "in": "in the rain", "above": "above it"}


def groups() -> list[tuple[str, list[Case]]]:
    """Give the cases of the document's second table."""
    found = [
        (f"even, {box:g} km high, {_SAID[eye]}",
         [Case(a, box, eye, "even", _SMALL) for a in _COARSE])
        for box in BOXES_KM for eye in EYES
    ]  # fmt: skip
    for rain, said in (("dense", "even, with extinction"), ("mixture", "mixture of sizes")):
        found.append((f"{said}, 1.2 km high", [Case(a, rain=rain, size_px=_SMALL) for a in _GRID]))
    for rain, scene in (("curtain", "curtain"), ("shower", "shower")):
        found.append((f"scene `{scene}`", [Case(a, rain=rain, size_px=_SMALL) for a in _GRID]))
    return found


def section(work: Path) -> Iterator[str]:
    """Give the paragraphs of the document's section."""
    yield "## The edge of the Earth's shadow"
    yield paragraph(
        "Frames about sunset in Rayleigh's air, against the reference at the same wavelengths (5"
        " nm). A pixel is lit where places sampled along its ray, one by one, are not all in the"
        f" shadow (rays with less than {_NEAR_EDGE_M:g} m of light left out). Where the shadow does"
        " not reach the rain, frames are drawn as ever."
    )
    yield "`python tools/dusk.py --work WORK --document docs/accuracy.md`"
    yield paragraph("Even rain 1.2 km high and 0.5 to 3 km away, eye on the ground, 48×27 pixels:")
    yield each([Case(a) for a in _FINE], work)
    yield paragraph(
        "Other rain, at 32×18 pixels: sun from +2° to -2° in steps of half a degree; with"
        " extinction, mixtures and grids from 0° to -0.75° in quarters."
    )
    yield summed(groups(), work)
    yield bullets(
        [
            "The sun's disc is a point at the shadow's edge, and rays are straight;"
            " [limitations.md](limitations.md) says what both leave out.",
        ]
    )


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--work", type=Path, required=True, help="folder of what was measured")
    parser.add_argument("--document", type=Path, help="Markdown whose section is replaced")
    parser.add_argument("--box", type=float, default=1.2, help="height of the rain, km")
    parser.add_argument("--eye", choices=EYES, default="ground")
    parser.add_argument("--rain", choices=RAINS, default="even")
    parser.add_argument("--size", default="48x27")
    parser.add_argument("--from", dest="first", type=float, default=2.0, help="altitude, degrees")
    parser.add_argument("--to", dest="last", type=float, default=-2.0, help="altitude, degrees")
    parser.add_argument("--step", type=float, default=0.1, help="degrees")
    given = parser.parse_args()
    given.work.mkdir(parents=True, exist_ok=True)
    if given.document is not None:
        text = "\n\n".join((DUSK_BEGIN, *section(given.work), DUSK_END))
        document = given.document.read_text("utf-8")
        write_atomic(given.document, with_section(document, text).encode())
        return
    width, height = (int(side) for side in given.size.split("x"))
    cases = [
        Case(altitude, given.box, given.eye, given.rain, (width, height))
        for altitude in altitudes(given.first, given.last, given.step)
    ]
    print(each(cases, given.work))


if __name__ == "__main__":
    main()
