"""One pixel of the reference worked out by hand: its scene, its drops and its colour."""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import trapezoid

from rtbow.physics.drop.water import relative_index
from rtbow.physics.light.colour import colour_matching
from rtbow.reference.render import render_reference
from rtbow.scene.model import Scene
from rtbow.world.rain.volume import DropletVolume, save_volume
from rtbow.world.world import resolve
from textbook import RGB_TO_XYZ, cross_section, mean_on_sphere, towards

STEP_NM = 40.0
NM = np.arange(380.0, 781.0, STEP_NM)
IRRADIANCE = 650.0  # W/m² over 380-780 nm, the same at each wavelength
BOX = np.array([[-1500.0, 200.0, 0.0], [1500.0, 1200.0, 1100.0]])
EYE = np.array([0.0, 0.0, 1.6])


def colour_of(per_nm):
    """X, Y, Z of radiance per irradiance (len(NM),), each value standing for its bin."""
    nm, cmf = colour_matching()
    edges = np.concatenate([[380.0], 0.5 * (NM[:-1] + NM[1:]), [780.0]])
    xyz = np.zeros(3)
    for value, low, high in zip(per_nm, edges[:-1], edges[1:], strict=True):
        fine = np.linspace(low, high, 4001)
        for k in range(3):
            xyz[k] += value * trapezoid(np.interp(fine, nm, cmf[:, k]), fine)
    return xyz * IRRADIANCE / 400.0


@dataclass(frozen=True)
class Pixel:
    """One pixel's ray towards an azimuth and an altitude, with the sun in the south."""

    azimuth: float = 30.0
    altitude: float = 12.0
    sun_altitude: float = 15.0
    disc_deg: float = 0.533
    radius_um: float = 80.0
    orders: tuple[int, ...] = (1, 2)

    @property
    def ray(self):
        return towards(self.azimuth, self.altitude)

    @property
    def theta(self):
        # Light travels away from the sun, then against the ray, into the eye.
        return np.arccos(-towards(180.0, self.sun_altitude) @ -self.ray)

    def span(self, box=BOX):
        """Distances at which the ray crosses the box, face by face."""
        crossings = []
        for axis in range(3):
            for face in box[:, axis]:
                t = (face - EYE[axis]) / self.ray[axis]
                at = EYE + t * self.ray
                others = [a for a in range(3) if a != axis]
                if t > 0.0 and all(box[0, a] <= at[a] <= box[1, a] for a in others):
                    crossings.append(t)
        assert len(crossings) == 2
        return sorted(crossings)

    def section(self, nm, radius_m):
        """Cross-section of a drop at this pixel's angle, averaged over the sun's disc."""
        index = float(relative_index(np.array([nm]), 20.0)[0])
        # The shader and the reference take the wavelength in air as that in vacuum: 3e-4.
        return sum(
            mean_on_sphere(
                lambda t, k=order: cross_section(index, nm * 1e-9, radius_m, t, k),
                self.theta,
                np.radians(0.5 * self.disc_deg),
                rings=40,
                spokes=96,
            )
            for order in self.orders
        )

    def scene(self, **changes):
        parts = {
            "camera": {
                "position_m": list(EYE),
                "azimuth_deg": self.azimuth,
                "altitude_deg": self.altitude,
                "fov_deg": 1.0,
                "size_px": [1, 1],
            },
            "light": [
                {
                    "altitude_deg": self.sun_altitude,
                    "spectrum": "equal-energy",
                    "irradiance_w_m2": IRRADIANCE,
                    "angular_diameter_deg": self.disc_deg,
                }
            ],
            "droplets": {
                "box_m": BOX.tolist(),
                "radius": {"distribution": "constant", "radius_um": self.radius_um},
                "density": {"number_per_m3": 1000.0},
            },
            "scattering": {"orders": list(self.orders)},
            "render": {"wavelength_step_nm": STEP_NM},
        }
        return Scene.model_validate(parts | changes)


def xyz_of(scene):
    """X, Y, Z of the reference's frame of one pixel."""
    frame = render_reference(resolve(scene))
    assert frame.shape == (1, 1, 3)
    assert frame.dtype == np.float64
    return RGB_TO_XYZ @ frame[0, 0]


def saved(tmp_path, radius_um, number, box=BOX):
    """Write a volume, and give the table of droplets that names its file."""
    path = tmp_path / "volume.npz"
    save_volume(DropletVolume(box, np.float32(radius_um), np.float32(number)), path)
    return {"file": str(path)}


def along_north(shape, values):
    """A field that depends on the distance north alone."""
    return np.broadcast_to(np.asarray(values)[None, :, None], shape)
