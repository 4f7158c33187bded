"""A number that a sky was measured to have, and the bound that a test holds it to."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Check(NamedTuple):
    """What was measured, as it is compared: a share of what is true, unless ``what`` says more.

    Attributes:
        what: in words.
        found: the number.
        bound: below which its size is to be; None where nothing is asserted of it.
    """

    what: str
    found: float
    bound: float | None = None

    @property
    def holds(self) -> bool:
        return self.bound is None or abs(self.found) < self.bound


def assert_all(checks):
    """Fail with all the numbers where one is beyond its bound."""
    checks = list(checks)
    assert checks
    assert all(check.holds for check in checks), "\n".join(
        f"{check.what}: {check.found:.5f}, bound {check.bound}" for check in checks
    )


def rms(deviation):
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(deviation))))


def worst(deviation):
    """The greatest size."""
    return float(np.max(np.abs(deviation)))
