"""What moves in a sequence, and the scenes that its plan makes."""

from __future__ import annotations

from datetime import date

import pytest

from rtbow.physics.light.sun_position import sun_path
from rtbow.scene.text.file import load_scene
from rtbow.sequence.animation import Move, parse_move, plan_animation

pytestmark = pytest.mark.slow


class TestMove:
    def test_even_steps_with_exact_ends(self):
        move = Move("camera.azimuth_deg", 0.1, 0.7)
        values = [move.at(k, 7) for k in range(7)]
        assert values == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7])
        assert (values[0], values[-1]) == (0.1, 0.7)

    def test_the_end_is_exact(self):
        assert 0.2 + (0.9 - 0.2) != 0.9
        assert Move("k", 0.2, 0.9).at(4, 5) == 0.9

    def test_downwards(self):
        assert [Move("k", 10.0, -10.0).at(k, 5) for k in range(5)] == [10.0, 5.0, 0.0, -5.0, -10.0]

    def test_one_frame_has_the_start(self):
        assert Move("k", 3.0, 9.0).at(0, 1) == 3.0

    def test_whole_numbers_stay_whole(self):
        values = [Move("k", 1, 4).at(k, 7) for k in range(7)]
        assert values == [1, 2, 2, 3, 3, 4, 4]
        assert all(isinstance(value, int) for value in values)
        assert [Move("k", 4, 1).at(k, 4) for k in range(4)] == [4, 3, 2, 1]
        large = 10**30
        assert Move("k", large, large + 4).at(1, 3) == large + 2

    @pytest.mark.parametrize(
        ("text", "move"),
        [
            ("light.0.altitude_deg=2:40", Move("light.0.altitude_deg", 2.0, 40.0)),
            (" camera.position_m.2 = 1.6 : 1e3 ", Move("camera.position_m.2", 1.6, 1000.0)),
            ("droplets.seed=1:9", Move("droplets.seed", 1, 9)),
            ("compare.right.camera.fov_deg=-1:5", Move("compare.right.camera.fov_deg", -1.0, 5.0)),
        ],
    )
    def test_as_typed(self, text, move):
        parsed = parse_move(text)
        assert parsed == move
        assert type(parsed.start) is type(move.start)


class TestPlan:
    def test_scenes_are_those_that_set_would_make(self):
        moves = [parse_move("light.0.altitude_deg=2:40"), parse_move("camera.position_m.0=0:-8")]
        overrides = {"camera.size_px": [32, 18], "light.0.spectrum": "FL2"}
        plan = plan_animation("uniform", overrides, 3, moves)
        for number, altitude, east in ((0, 2.0, 0.0), (1, 21.0, -4.0), (2, 40.0, -8.0)):
            changes = {"light.0.altitude_deg": altitude, "camera.position_m.0": east}
            alone = load_scene("uniform", overrides | changes)
            assert plan.at(number) == alone
            assert plan.at(number).source_text == alone.source_text
            assert plan.at(number).source_name == alone.source_name

    def test_both_sides_of_a_comparison(self):
        moves = [parse_move("compare.right.scattering.size_spread=0.02:0.06")]
        right = {"compare.right": {"scattering.theory": "mie"}}
        plan = plan_animation("uniform", right, 3, moves)
        assert plan.at(1).parts()[1][0].scattering.size_spread == pytest.approx(0.04)
        assert plan.at(1).parts()[1][0].scattering.theory == "mie"

    @pytest.mark.parametrize(
        "day", [(48.1, 11.6, date(2024, 12, 21)), (69.65, 18.96, date(2024, 6, 21))]
    )
    def test_the_sun_on_its_path(self, day):
        path = sun_path(*day, 5)
        plan = plan_animation("uniform", {}, 5, sun=path)
        for number, sun in enumerate(path):
            light = plan.at(number).light[0]
            assert light.altitude_deg == pytest.approx(sun.altitude_deg, abs=1e-6)
            assert light.azimuth_deg == pytest.approx(sun.azimuth_deg, abs=1e-6)

    @pytest.mark.parametrize(
        ("key", "places"),
        [
            ("light.0.altitude_deg=1:2", True),
            ("camera.fov_deg=40:50", True),
            ("camera.position_m.1=0:2", True),
            ("camera.polarizer_deg=0:90", False),
            ("droplets.radius.radius_um=100:200", False),
            ("light.0.angular_diameter_deg=0.5:1", False),
        ],
    )
    def test_what_only_moves_places(self, key, places):
        assert plan_animation("uniform", {}, 2, [parse_move(key)]).only_places is places

    @pytest.mark.parametrize(
        ("key", "keeps"),
        [("light.0.altitude_deg=1:2", False), ("camera.fov_deg=40:50", True),
         ("camera.position_m.1=0:2", False)],
    )  # fmt: skip
    def test_tables_behind_ozone_are_of_one_place(self, key, keeps):
        moves = [parse_move(key)]
        assert plan_animation("uniform", {}, 2, moves).keeps_tables
        ozone = {"atmosphere.ozone_du": 300.0}
        assert plan_animation("uniform", ozone, 2, moves).keeps_tables is keeps

    @pytest.mark.parametrize(
        ("key", "widest"),
        [
            ("camera.fov_deg=40:50", 4),
            ("camera.fov_deg=50:40", 0),
            ("camera.azimuth_deg=0:9", None),
        ],
    )
    def test_the_frame_of_the_widest_pixels(self, key, widest):
        assert plan_animation("uniform", {}, 5, [parse_move(key)]).widest == widest
