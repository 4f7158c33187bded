"""Scenes with lamps that the tests take apart, and a lamp's spectrum as files hold it."""

import numpy as np

from rtbow.scene.model import Scene

STEP_NM = 40.0
NM = np.arange(380.0, 781.0, STEP_NM)
FLUX_LM = 1000.0
NUMBER = 1000.0
BOX = ((-20.0, 0.0, 0.0), (20.0, 40.0, 20.0))
EYE = (0.0, -5.0, 2.0)
INSIDE = (0.0, 20.0, 5.0)
"""A lamp among the drops."""


def lamp(position=INSIDE, **changes):
    """Give a lamp's table, with some keys changed."""
    parts = {"type": "point", "position_m": list(position), "luminous_flux_lm": FLUX_LM}
    return parts | {"spectrum": "equal-energy"} | changes


def make(camera=None, lights=None, droplets=None, render=None, **changes):
    """Make a scene of lamps, some keys of its tables changed."""
    parts = {
        "camera": {"position_m": list(EYE), "altitude_deg": 10.0, "size_px": [32, 18]}
        | (camera or {}),
        "light": lights or [lamp()],
        "droplets": {
            "box_m": [list(corner) for corner in BOX],
            "radius": {"distribution": "constant", "radius_um": 300.0},
            "density": {"number_per_m3": NUMBER},
        }
        | (droplets or {}),
        "render": {"wavelength_step_nm": STEP_NM} | (render or {}),
    }
    return Scene.model_validate(parts | changes)


FILE_NM = np.arange(380.0, 781.0, 5.0)
FILE_VALUES = np.exp(-0.5 * ((FILE_NM - 560.0) / 80.0) ** 2)
"""A lamp's spectrum for files: a Gaussian."""
FILE_VISIBLE = float(np.sum(2.5 * (FILE_VALUES[1:] + FILE_VALUES[:-1])))
"""Its integral along straight lines from point to point."""


def rows(x=FILE_NM, y=FILE_VALUES, separator=",", decimal="."):
    """Give lines of two numbers, with all their digits."""
    lines = (f"{float(a)!r}{separator}{float(b)!r}\n" for a, b in zip(x, y, strict=True))
    return "".join(lines).replace(".", decimal)
