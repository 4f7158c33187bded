"""Scenes with lamps that the tests take apart."""

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
