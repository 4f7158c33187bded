"""A ray that all but meets a lamp, against the integral over the angle at the lamp."""

import numpy as np
import pytest

import rtbow
from lamp_samples import FLUX_LM, NM, NUMBER, lamp, make
from rtbow.physics.drop.water import relative_index
from rtbow.physics.light.colour import colour_matching
from textbook import LUMINANCE, cross_section

BOX = np.array([[-20.0, 5.0, 0.0], [20.0, 40.0, 20.0]])
EYE = np.array([0.0, 0.0, 2.0])
RADIUS_UM = 20.0


def luminance_along(side, along):
    """Luminance of a ray to the north that passes a lamp at a distance, ``along`` metres away.

    The way light turns is from the lamp to the drop and on to the eye: at s past the foot by an
    angle whose cotangent is -s/D, and dt/d² = dtheta/D.
    """
    ends = np.arctan2(side, -(BOX[:, 1] - EYE[1] - along))
    nodes, gauss = np.polynomial.legendre.leggauss(8)
    edges = np.linspace(*ends, 3001)
    half = 0.5 * np.diff(edges)[:, None]
    theta, share = (edges[:-1, None] + half * (1.0 + nodes)).ravel(), (half * gauss).ravel()
    nm, cmf = colour_matching()
    fine = np.linspace(380.0, 780.0, 40_001)
    sight = np.interp(fine, nm, cmf[:, 1])
    edges_nm = np.concatenate([[380.0], 0.5 * (NM[:-1] + NM[1:]), [780.0]])
    total = 0.0
    for at, low, high in zip(NM, edges_nm[:-1], edges_nm[1:], strict=True):
        index = float(relative_index(np.array([at]), 20.0)[0])
        section = sum(cross_section(index, at * 1e-9, RADIUS_UM * 1e-6, theta, k) for k in (1, 2))
        bin_nm = np.linspace(low, high, 4001)
        weight = np.trapezoid(np.interp(bin_nm, nm, cmf[:, 1]), bin_nm)
        total += weight * NUMBER / side * (share @ section)
    return total * FLUX_LM / (4.0 * np.pi * np.trapezoid(sight, fine))


# 3e-8 and 1e-6; fast is at 1 nm, and 2.1e-3 from the sum over 40 nm.
@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "bound"), [("reference", 1e-6), ("spectral", 1e-5), ("fast", 5e-3)]
)
@pytest.mark.parametrize("side", [0.05, 0.005])
def test_a_ray_beside_a_point_lamp(side, method, bound):
    camera = {"position_m": list(EYE), "altitude_deg": 0.0, "fov_deg": 1.0, "size_px": [1, 1]}
    droplets = {
        "box_m": BOX.tolist(),
        "radius": {"distribution": "constant", "radius_um": RADIUS_UM},
    }
    point = lamp((side, 20.0, 2.0), diameter_m=0.0)
    with rtbow.Renderer(make(camera, [point], droplets), "egl") as renderer:
        got = float(renderer.render(method)[0, 0].astype(np.float64) @ LUMINANCE)
    assert got == pytest.approx(luminance_along(side, 20.0), rel=bound)
