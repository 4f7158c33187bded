"""Which key a message proposes: the one that was meant, and none rather than another thing."""

from __future__ import annotations

import pytest

from rtbow.scene.text.nearest import nearest
from rtbow.scene.text.schema import ROOT, Node


def keys(table: str) -> list[str]:
    node: Node | None = ROOT
    for part in table.split(".") if table else ():
        assert node is not None
        node = node.child(int(part) if part.isdigit() else part)
    assert node is not None
    return list(node.fields)


@pytest.mark.parametrize(
    ("table", "typed", "meant"),
    [
        ("camera", "azimut_deg", "azimuth_deg"),
        ("camera", "fov", "fov_deg"),
        ("camera", "fov_degg", "fov_deg"),
        ("camera", "polarizer", "polarizer_deg"),
        ("camera", "polariser_deg", "polarizer_deg"),
        ("camera", "Position_m", "position_m"),
        ("camera", "pos_m", "position_m"),
        ("camera", "size", "size_px"),
        ("camera", "sizepx", "size_px"),
        ("camera", "heading_deg", "azimuth_deg"),
        ("camera", "elevation_deg", "altitude_deg"),
        ("light.0", "spectrm", "spectrum"),
        ("light.0", "diameter", "diameter_m"),
        ("light.0", "angular_diameter_rad", "angular_diameter_deg"),
        ("droplets", "extinct", "extinction"),
        ("droplets", "files", "file"),
        ("droplets.density", "rate_mm_h", "rain_rate_mm_h"),
        ("droplets.density", "number_per_cm3", "number_per_m3"),
        ("scattering", "temperature_c", "water_temperature_c"),
        ("scattering", "order", "orders"),
        ("render", "step", "steps"),
        ("render", "delta_e", "max_delta_e"),
        ("", "lights", "light"),
        ("", "raindrops", "droplets"),
        ("", "air", "atmosphere"),
    ],
)
def test_what_was_meant(table, typed, meant):
    assert nearest(typed, keys(table)) == meant


@pytest.mark.parametrize(
    ("table", "typed"),
    [
        ("camera", "latitude_deg"),  # not altitude_deg, for all its letters
        ("camera", "longitude_deg"),
        ("light.0", "date"),
        ("light.0", "radius_m"),
        ("camera", "altitude_m"),  # a height is no angle
        ("camera", "exposure_ev"),
        ("droplets", "size"),  # not seed
        ("droplets.density", "mass_per_m3"),
        ("", "backdrop"),
        ("", "water"),
    ],
)
def test_nothing_rather_than_another_thing(table, typed):
    assert nearest(typed, keys(table)) is None
