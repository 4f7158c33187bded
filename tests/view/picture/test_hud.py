"""What stands over the picture: labels that give way."""

import pytest
from imgui_bundle import imgui

from panel_driver import staged
from rtbow.view.picture.hud import draw_label, overlap

AREA = (10.0, 20.0, 300.0, 200.0)
WHITE = imgui.ImVec4(1.0, 1.0, 1.0, 1.0)


@pytest.fixture
def canvas(egl):
    """A list that can be drawn to, within a frame of ImGui."""
    with staged(egl, "uniform", height=300) as stage:
        stage.frames(1)
        imgui.new_frame()
        yield imgui.get_foreground_draw_list()
        imgui.end_frame()


@pytest.mark.parametrize("at", [(150.0, 100.0), (299.0, 199.0), (-50.0, -50.0), (299.0, 0.0)])
def test_labels_at_one_point_lie_apart_and_inside_the_picture(canvas, at):
    taken = []
    for number in range(8):
        draw_label(canvas, AREA, at, f"primary {number}", WHITE, taken)
    assert len(taken) == 8
    for k, one in enumerate(taken):
        assert AREA[0] <= one[0]
        assert one[0] + one[2] <= AREA[0] + AREA[2]
        assert AREA[1] <= one[1]
        assert one[1] + one[3] <= AREA[1] + AREA[3]
        assert not any(overlap(one, other) for other in taken[:k])


def test_labels_give_way_to_boxes(canvas):
    box = (10.0, 20.0, 200.0, 120.0)
    taken = [box]
    draw_label(canvas, AREA, (20.0, 30.0), "horizon", WHITE, taken)
    assert not overlap(taken[1], box)


def test_a_label_with_no_room_is_written_where_it_belongs(canvas):
    taken = [AREA]
    draw_label(canvas, AREA, (50.0, 60.0), "horizon", WHITE, taken)
    assert taken[1][0] == pytest.approx(64.0)


def test_areas_that_touch_do_not_meet():
    assert overlap((0.0, 0.0, 2.0, 2.0), (1.0, 1.0, 2.0, 2.0))
    assert not overlap((0.0, 0.0, 2.0, 2.0), (2.0, 0.0, 2.0, 2.0))
    assert not overlap((0.0, 0.0, 2.0, 2.0), (0.0, 2.0, 2.0, 2.0))
