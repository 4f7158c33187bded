"""The camera's rays."""

import numpy as np
import pytest

from rtbow.scene.model import Camera
from rtbow.world.camera import camera_basis, pixel_directions, view_of


@pytest.mark.parametrize("size_px", [(64, 36), (9, 40), (1, 1)])
@pytest.mark.parametrize("fov_deg", [2.0, 84.0, 150.0])
def test_a_cone_through_the_corners_holds_the_picture(size_px, fov_deg):
    camera = Camera(size_px=size_px, fov_deg=fov_deg, azimuth_deg=70.0, altitude_deg=-30.0)
    axis, half = view_of(camera).cone
    assert np.linalg.norm(axis) == pytest.approx(1.0)
    angles = np.arccos(np.clip(pixel_directions(camera) @ axis, -1.0, 1.0))
    assert angles.max() < half
    forward, right, up = camera_basis(camera)
    for corner in (forward + right + up, forward - right + up, forward + right - up):
        assert np.arccos(corner @ axis / np.linalg.norm(corner)) == pytest.approx(half)
