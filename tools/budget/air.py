"""What straight rays through a model atmosphere leave: the sun's column against observation."""

from __future__ import annotations

import numpy as np

from budget.error_budget import Measurement, Row, Stage
from budget.strips import strip_angles, strip_scene, table_strip
from rtbow.base.arrays import Array, Values, floats
from rtbow.frames.difference import Spread, frame_difference
from rtbow.physics.air.rayleigh import rayleigh_depth, sun_column
from rtbow.world.optics import scene_optics

ALTITUDES_DEG = (0.0, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0)


def kasten_young(altitude_deg: Values) -> Array:
    """Give the relative air mass, with refraction.

    Args:
        altitude_deg: of the sun above the horizon, as it is seen.

    Source: Kasten and Young, Applied Optics 28, 4735 (1989), equation 3.
    """
    a = floats(altitude_deg)
    return floats(1.0 / (np.sin(np.radians(a)) + 0.50572 * (a + 6.07995) ** -1.6364))


def measure() -> Measurement:
    """Compare columns, and the bows of their light."""
    theta = strip_angles()
    scene = strip_scene({})
    depth = rayleigh_depth(scene_optics(scene).wavelength_nm)
    for altitude in ALTITUDES_DEG:
        ours = float(sun_column(0.0, np.radians(altitude)))
        theirs = float(kasten_young(altitude))
        error = abs(ours / theirs - 1.0)
        label = f"sun at {altitude:g}°"
        yield Row(
            f"{label}, column {ours:.3f} against {theirs:.3f}", "of the column",
            relative=Spread(error, error, error),
        )  # fmt: skip
        strips = [table_strip(scene, theta, passed=np.exp(-depth * c)) for c in (ours, theirs)]
        headline = altitude == 20.0
        yield Row(
            f"{label}, the bow", "strip, 300 µm", frame_difference(*strips), headline=headline
        )
    yield (
        "Both in units of a vertical column. Kasten and Young's includes refraction and a standard"
        " atmosphere's temperature; this one is isothermal (scale height 7994 m) and its rays are"
        " straight. Their altitude is the one that is seen, as is that of a scene's sun."
    )


AIR = Stage(
    "Atmosphere: the column towards the sun",
    "The model's air column from sea level against Kasten and Young (1989), and strips "
    "(Airy, 300 µm, 5 nm) lit through either. Air between drops and eye, the same in "
    "both, is left out.",
    measure,
)
