"""Fall speeds against Gunn and Kinzer's measurements, and rain rates against closed forms."""

import numpy as np
import pytest
from scipy.integrate import quad

from rtbow.physics.drop.fall import fall_speed, rain_rate_mm_h
from rtbow.physics.sizes import marshall_palmer

# Gunn and Kinzer, J. Meteor. 6, 243 (1949), table 2: mm across, m/s.
GUNN_KINZER = {
    0.1: 0.27, 0.2: 0.72, 0.3: 1.17, 0.5: 2.06, 0.7: 2.87, 1.0: 4.03, 1.4: 5.17, 1.8: 6.09,
    2.2: 6.90, 2.6: 7.57, 3.0: 8.06, 3.6: 8.60, 4.2: 8.92, 5.0: 9.09, 5.8: 9.17,
}  # fmt: skip


def test_fall_speeds():
    for diameter_mm, speed in GUNN_KINZER.items():
        got = float(fall_speed(np.array(0.5e-3 * diameter_mm)))
        within = 0.08 if diameter_mm < 0.15 else 0.04 if diameter_mm < 0.25 else 0.022
        assert got == pytest.approx(speed, rel=within), diameter_mm


def test_small_drops_follow_stokes():
    # 2/9 (998.2 - 1.2) 9.80665 (5e-6)² / 1.818e-5, and 1.7 % of slip: 3.04 mm/s.
    assert float(fall_speed(np.array(5e-6))) == pytest.approx(3.04e-3, rel=3e-3)
    # The regimes meet within the errors of the measurements.
    for at in (9.5e-6, 535e-6):
        below, above = fall_speed(np.array([at * 0.9999, at * 1.0001]))
        assert above == pytest.approx(below, rel=0.03)
    assert np.all(np.diff(fall_speed(np.geomspace(1e-6, 3e-3, 500))) > -1e-3)


@pytest.mark.parametrize("rate", [1.0, 5.0, 25.0])
def test_rain_of_marshall_and_palmer(rate):
    diameter = np.linspace(1e-6, 9e-3, 9000)
    number = marshall_palmer(diameter, rate) * (diameter[1] - diameter[0])
    got = rain_rate_mm_h(0.5 * diameter, number)
    # Atlas, Srivastava and Sekhon's v = 9.65 - 10.3 exp(-0.6 D), with which the rain rate is a
    # sum of gamma functions: 0.0006 pi N0 3! (9.65 / Lambda^4 - 10.3 / (Lambda + 0.6)^4).
    slope = 4.1 * rate**-0.21
    atlas = 6e-4 * np.pi * 8000.0 * 6.0 * (9.65 / slope**4 - 10.3 / (slope + 0.6) ** 4)
    assert got == pytest.approx(atlas, rel=0.02)
    # The relation is not quite consistent with itself: known since 1948.
    assert got == pytest.approx(rate, rel=0.2)
    water, _ = quad(lambda d: np.pi / 6.0 * d**3 * 8.0 * np.exp(-slope * d), 0.0, 50.0)
    assert water == pytest.approx(0.089 * rate**0.84, rel=0.01)  # g/m³, Battan (1973)
