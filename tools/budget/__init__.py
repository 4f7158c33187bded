"""The error budget's stages, in the order of the document."""

from __future__ import annotations

from budget.air import AIR
from budget.error_budget import Stage
from budget.float32 import FLOAT32
from budget.march import MARCH
from budget.rain import RAIN
from budget.storage import STORAGE
from budget.tables import TABLE
from budget.theory import THEORY
from budget.wavelength import WAVELENGTH

STAGES: dict[str, Stage] = {
    "theory": THEORY,
    "table": TABLE,
    "wavelength": WAVELENGTH,
    "march": MARCH,
    "air": AIR,
    "float32": FLOAT32,
    "storage": STORAGE,
    "rain": RAIN,
}
