"""What a wavelength step leaves: bins of 5 to 40 nm against 1 nm."""

from __future__ import annotations

from typing import Any

from budget.error_budget import Measurement, Row, Stage
from budget.strips import reference_strip, strip_angles, strip_scene
from rtbow.frames.difference import frame_difference

_STEPS_NM = (5.0, 10.0, 20.0, 40.0)
_LIGHTS: tuple[tuple[str, dict[str, Any], tuple[int, ...]], ...] = (
    ("sun", {}, (100, 300, 1000)),
    ("fluorescent lamp FL2 for a sun", {"light.0.spectrum": "FL2"}, (100, 300, 1000)),
    ("sun without a disc", {"light.0.angular_diameter_deg": 0.0}, (300,)),
)


def measure() -> Measurement:
    """Compare steps with 1 nm, for smooth and for line spectra."""
    theta = strip_angles()
    for label, light, radii in _LIGHTS:
        for radius in radii:
            common = {**light, "droplets.radius.radius_um": float(radius)}
            truth = reference_strip(
                strip_scene({**common, "render.wavelength_step_nm": 1.0}), theta
            )
            for step in _STEPS_NM:
                scene = strip_scene({**common, "render.wavelength_step_nm": step})
                difference = frame_difference(reference_strip(scene, theta), truth)
                headline = label == "sun" and radius == 300 and step == 5.0
                yield Row(
                    f"{step:g} nm, {label}", f"strip, {radius} µm", difference, headline=headline
                )


WAVELENGTH = Stage(
    "Wavelength step",
    "Strips by method `reference` with Airy's theory, against the same at 1 nm. Light "
    "times colour-matching functions is integrated exactly over each bin; only the drop's "
    "scattering is sampled at the step.",
    measure,
)
