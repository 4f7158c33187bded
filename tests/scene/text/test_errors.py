"""What is said about wrong values in a scene file."""

import pytest

from rtbow.scene.text.file import scene_from_text
from scene_samples import BASE, FROM_FILE, problems

# --- wrong values: (what to replace in BASE, by what, the whole message after "storm.toml: ")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "radius_um = 500.0",
            "radius_um = -3",
            "droplets.radius.radius_um = -3; must be 1..5000 µm",
        ),
        (
            "radius_um = 500.0",
            "radius_um = 5001",
            "droplets.radius.radius_um = 5001; must be 1..5000 µm",
        ),
        (
            "radius_um = 500.0",
            "radius_um = true",
            "droplets.radius.radius_um = true; must be a number, 1..5000 µm",
        ),
        (
            "radius_um = 500.0",
            'radius_um = "500"',
            'droplets.radius.radius_um = "500"; must be a number, 1..5000 µm',
        ),
        (
            "radius_um = 500.0",
            "radius_um = nan",
            "droplets.radius.radius_um = nan; must be a finite number, 1..5000 µm",
        ),
        (
            "radius_um = 500.0",
            "",
            "droplets.radius.radius_um is missing; give a number, 1..5000 µm",
        ),
        (
            "radius_um = 500.0",
            "radius_um = 5\nmin_um = 3",
            'droplets.radius.min_um does not belong to distribution = "constant", '
            "which takes radius_um; leave it out or change the distribution "
            'to one of "uniform", "marshall-palmer"',
        ),
        (
            "[droplets.radius]",
            "[droplets.radus]",
            "unknown key droplets.radus; did you mean droplets.radius?",
        ),
        (
            'distribution = "constant"',
            'distribution = "konstant"',
            'droplets.radius.distribution = "konstant"; '
            'must be one of "constant", "uniform", "normal", "lognormal", "gamma", '
            '"modified-gamma", "marshall-palmer", "table"',
        ),
        (
            'distribution = "constant"',
            "",
            "droplets.radius.distribution is missing; "
            'must be one of "constant", "uniform", "normal", "lognormal", "gamma", '
            '"modified-gamma", "marshall-palmer", "table"',
        ),
        ("[[light]]", "[[lights]]", "unknown key lights; did you mean light?"),
        (
            "[[light]]",
            "[light]",
            'light = { type = "sun", altitude_deg = 20.0 }; '
            "must be one or more tables: write [[light]], in double brackets",
        ),
        (
            "[camera]",
            "[[camera]]",
            "camera = [{ size_px = [64, 36] }]; must be a table: write [camera]",
        ),
        (
            "altitude_deg = 20.0",
            "altitude_deg = 91",
            "light.0.altitude_deg = 91; must be -90..90 deg",
        ),
        (
            "altitude_deg = 20.0",
            "azimuth_deg = inf",
            "light.0.azimuth_deg = inf; must be a finite number",
        ),
        (
            "altitude_deg = 20.0",
            "irradiance_w_m2 = 0",
            "light.0.irradiance_w_m2 = 0; must be greater than 0 and up to 1e12 W/m²",
        ),
        (
            "altitude_deg = 20.0",
            "angular_diameter_deg = 5.1",
            "light.0.angular_diameter_deg = 5.1; must be 0..5 deg",
        ),
        ("altitude_deg = 20.0", 'spectrum = ""', 'light.0.spectrum = ""; must not be empty'),
        (
            "altitude_deg = 20.0",
            "spectrum = 2024-01-01",
            "light.0.spectrum = 2024-01-01; must be text in quotes",
        ),
        ('"sun"', '"lamp"', 'light.0.type = "lamp"; must be one of "sun", "point"'),
        (
            '"sun"',
            '"sun"\nposition_m = [0, 0, 4]',
            'light.0.position_m does not belong to type = "sun", which takes altitude_deg, '
            "azimuth_deg, spectrum, beyond, angular_diameter_deg, visible, irradiance_w_m2, time, "
            "latitude_deg, longitude_deg, moon_phase_deg, moon_distance_km; leave it out or "
            'change the type to "point"',
        ),
        (
            "size_px = [64, 36]",
            "size_px = [64, 0]",
            "camera.size_px.1 = 0; must be 1..16384 px",
        ),
        (
            "size_px = [64, 36]",
            "size_px = [64]",
            "camera.size_px = [64]; "
            "must be a list of 2 whole numbers, each 1..16384 px, such as [1280, 720]",
        ),
        (
            "size_px = [64, 36]",
            "size_px = [64, 36, 3]",
            "camera.size_px = [64, 36, 3]; "
            "must be a list of 2 whole numbers, each 1..16384 px, such as [1280, 720]",
        ),
        (
            "size_px = [64, 36]",
            "size_px = [64, 36.0]",
            "camera.size_px.1 = 36.0; must be a whole number, 1..16384 px",
        ),
        (
            "size_px = [64, 36]",
            "fov_deg = 180",
            "camera.fov_deg = 180; must be 1e-06 or more and less than 180 deg",
        ),
        (
            "size_px = [64, 36]",
            "position_m = [1e8, 0, 0]",
            "camera.position_m.0 = 100000000.0; must be -1e7..1e7 m",
        ),
        (
            "1200.0, 1100.0]]",
            "1200.0, -5.0]]",
            "droplets.box_m = [[-1500.0, 200.0, 0.0], [1500.0, 1200.0…; the second corner "
            "must exceed the first on each axis: it is turned inside out along up (0 to -5)",
        ),
        (
            "[[-1500.0, 200.0, 0.0], [1500.0, 1200.0, 1100.0]]",
            "[[0, 9, 0], [0, 1, 1]]",
            "droplets.box_m = [[0, 9, 0], [0, 1, 1]]; the second corner must exceed the first on "
            "each axis: it is flat along east (0 to 0), it is turned inside out along north "
            "(9 to 1)",
        ),
        (
            "[droplets.radius]",
            "grid = [1, 8, 8]\n[droplets.radius]",
            "droplets.grid.0 = 1; must be 2..1024",
        ),
        (
            "[droplets.radius]",
            "seed = -1\n[droplets.radius]",
            "droplets.seed = -1; must be 0 or more",
        ),
        (
            "[droplets.radius]",
            "extinction = 1\n[droplets.radius]",
            "droplets.extinction = 1; must be true or false",
        ),
        (
            "[droplets.radius]",
            "extinction_efficiency = -1\n[droplets.radius]",
            "droplets.extinction_efficiency = -1; must be 0..5",
        ),
        (
            "number_per_m3 = 1000.0",
            "number_per_m3 = -1",
            "droplets.density.number_per_m3 = -1; must be 0..1e12 per m³",
        ),
        (
            "number_per_m3 = 1000.0",
            "",
            'droplets.density.number_per_m3 is missing; distribution = "constant" needs it, '
            "such as 1000",
        ),
        (
            "number_per_m3 = 1000.0",
            "number_per_m3 = 1\nrain_rate_mm_h = 5",
            'droplets.density.rain_rate_mm_h does not go with distribution = "constant"; '
            "give number_per_m3 instead",
        ),
        (
            "[camera]",
            "[atmosphere]\nrayleigh = 1\n[camera]",
            "atmosphere.rayleigh = 1; must be true or false",
        ),
        (
            "[camera]",
            "[scattering]\nsize_spread = 2\n[camera]",
            "scattering.size_spread = 2; must be 0.01..0.2",
        ),
        (
            "[camera]",
            '[scattering]\ntheory = "ariy"\n[camera]',
            'scattering.theory = "ariy"; must be one of "airy", "mie"',
        ),
        (
            "[camera]",
            "[scattering]\norders = []\n[camera]",
            "scattering.orders = []; "
            "must be a list of one or more whole numbers, each 1..2, such as [1, 2]",
        ),
        (
            "[camera]",
            "[scattering]\norders = [1, 1]\n[camera]",
            "scattering.orders = [1, 1]; must name each order once, such as [1, 2]",
        ),
        (
            "[camera]",
            "[scattering]\norders = [1, 3]\n[camera]",
            "scattering.orders.1 = 3; must be 1..2",
        ),
        (
            "[camera]",
            "[scattering]\norders = [true]\n[camera]",
            "scattering.orders.0 = true; must be a whole number, 1..2",
        ),
        (
            "[camera]",
            "[scattering]\nwater_temperature_c = 61\n[camera]",
            "scattering.water_temperature_c = 61; must be -12..60 °C",
        ),
        (
            "[camera]",
            "[render]\nwavelength_step_nm = 3\n[camera]",
            "render.wavelength_step_nm = 3; must divide 380-780 nm evenly, as 2.5 and 3.125 do",
        ),
        (
            "[camera]",
            "[render]\nwavelength_step_nm = 0\n[camera]",
            "render.wavelength_step_nm = 0; must be 0.05..40 nm",
        ),
        ("[camera]", "[render]\nsteps = 0\n[camera]", "render.steps = 0; must be 1..100000"),
        ("[camera]", "seed = 4\n[camera]", "unknown key seed; did you mean droplets.seed?"),
        (
            "[camera]",
            '"a\\nb" = 4\n[camera]',
            'unknown key "a\\nb"; known here: camera, light, '
            "droplets, atmosphere, ground, scattering, render, compare",
        ),
    ],
)
def test_a_wrong_value_is_named_with_what_is_allowed(old, new, message):
    assert old in BASE
    assert problems(BASE.replace(old, new, 1)) == [f"storm.toml: {message}"]


LAMP = 'type = "point"\nposition_m = [0, 0, 4]\nluminous_flux_lm = 800.0\ndiameter_m = 0.1\n'


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "luminous_flux_lm = 800.0",
            "luminous_flux_lm = 0",
            "light.0.luminous_flux_lm = 0; must be greater than 0 and up to 1e12 lm",
        ),
        (
            "luminous_flux_lm = 800.0",
            "luminous_flux_lm = -800.0",
            "light.0.luminous_flux_lm = -800.0; must be greater than 0 and up to 1e12 lm",
        ),
        (
            "luminous_flux_lm = 800.0",
            "luminous_flux_lm = nan",
            "light.0.luminous_flux_lm = nan; must be a finite number, greater than 0 and up to "
            "1e12 lm",
        ),
        (
            "luminous_flux_lm = 800.0",
            "",
            "light.0.luminous_flux_lm is missing; give a number, greater than 0 and up to 1e12 lm",
        ),
        (
            "[0, 0, 4]",
            "[0, inf, 4]",
            "light.0.position_m.1 = inf; must be a finite number, -1e7..1e7 m",
        ),
        (
            "[0, 0, 4]",
            "[nan, 0, 4]",
            "light.0.position_m.0 = nan; must be a finite number, -1e7..1e7 m",
        ),
        ("[0, 0, 4]", "[0, 2e7, 4]", "light.0.position_m.1 = 20000000.0; must be -1e7..1e7 m"),
        (
            "[0, 0, 4]",
            "[0, 4]",
            "light.0.position_m = [0, 4]; must be a list of 3 numbers, each -1e7..1e7 m",
        ),
        (
            "position_m = [0, 0, 4]",
            "",
            "light.0.position_m is missing; give a list of 3 numbers, each -1e7..1e7 m",
        ),
        ("diameter_m = 0.1", "diameter_m = -0.1", "light.0.diameter_m = -0.1; must be 0..10 m"),
        ("diameter_m = 0.1", "diameter_m = 11", "light.0.diameter_m = 11; must be 0..10 m"),
        (
            "diameter_m = 0.1",
            "diametre_m = 1",
            "unknown key light.0.diametre_m; did you mean light.0.diameter_m?",
        ),
        (
            "diameter_m = 0.1",
            "altitude_deg = 20.0",
            'light.0.altitude_deg does not belong to type = "point", which takes position_m, '
            "spectrum, beyond, luminous_flux_lm, diameter_m; leave it out or change the type to "
            '"sun"',
        ),
        (
            "diameter_m = 0.1",
            "irradiance_w_m2 = 20.0",
            'light.0.irradiance_w_m2 does not belong to type = "point", which takes position_m, '
            "spectrum, beyond, luminous_flux_lm, diameter_m; leave it out or change the type to "
            '"sun"',
        ),
        ('type = "point"\n', "", None),
    ],
)
def test_a_wrong_lamp_is_named_with_what_is_allowed(old, new, message):
    base = BASE.replace('type = "sun"\naltitude_deg = 20.0\n', LAMP)
    scene_from_text(base)
    assert old in base
    got = problems(base.replace(old, new, 1))
    if message is None:  # without a type the light is a sun, to which none of the keys belongs
        assert len(got) == 3
        assert all('does not belong to type = "sun"' in line for line in got)
    else:
        assert got == [f"storm.toml: {message}"]


def test_all_problems_are_reported_at_once():
    text = BASE.replace("radius_um = 500.0", "radius_um = -3").replace("20.0", "99", 1)
    assert problems(f"{text}[rendr]\n") == [
        "storm.toml: light.0.altitude_deg = 99; must be -90..90 deg",
        "storm.toml: droplets.radius.radius_um = -3; must be 1..5000 µm",
        "storm.toml: unknown key rendr; did you mean render?",
    ]


def test_a_scene_needs_a_light_and_drops():
    assert problems("") == [
        "storm.toml: light is missing; a scene needs at least one light: add [[light]] with "
        'type = "sun"',
        "storm.toml: droplets is missing; add [droplets] with box_m, radius and density, "
        "or with file",
    ]


def test_an_empty_list_of_lights_is_no_light():
    assert problems("light = []\n" + FROM_FILE.replace("[[light]]\n", "")) == [
        "storm.toml: light = []; must be one or more tables: write [[light]], in double brackets"
    ]


def test_what_a_volume_file_replaces_cannot_stand_beside_it():
    assert problems(f"{FROM_FILE}grid = [4, 4, 4]\n") == [
        "storm.toml: droplets.grid cannot be given together with droplets.file: "
        "the volume file carries its own grid; leave one of the two out"
    ]


def test_min_must_be_less_than_max():
    text = BASE.replace(
        'distribution = "constant"\nradius_um = 500.0',
        'distribution = "uniform"\nmin_um = 600\nmax_um = 600.0',
    )
    assert problems(text) == [
        "storm.toml: droplets.radius.max_um = 600.0; must be greater than min_um = 600"
    ]


def test_long_values_are_cut():
    (line,) = problems(BASE.replace("[64, 36]", f"[{', '.join('7' * 90)}]"))
    assert len(line) < 200
    assert "…" in line
