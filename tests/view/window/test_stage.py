"""Where picture and panel are in the window, on ordinary and on dense displays."""

from types import SimpleNamespace

import pytest

from rtbow.scene.text.file import load_scene
from rtbow.view.document.edits import Edits, Opened
from rtbow.view.document.state import ViewState
from rtbow.view.window.stage import PANEL_WIDTH, Stage
from rtbow.view.window.system import Window


def stage(size, density=1.0, scale=1.0, picture=(640, 360), panel=True):
    """A stage whose window has no display."""
    window = object.__new__(Window)
    window.size = size
    window.size_px = (round(density * size[0]), round(density * size[1]))
    window._scale = scale
    found = object.__new__(Stage)
    found.window = window
    found._edits = Edits(Opened(load_scene("uniform", {"camera.size_px": list(picture)})))
    found._state = ViewState(panel_open=panel)
    found.input = SimpleNamespace()
    return found


def test_the_picture_fills_what_the_panel_leaves():
    here = stage((980, 600))
    assert here.panel_units() == PANEL_WIDTH
    assert here.view_rect() == (0, 120, 640, 360)
    assert here.view_units() == (0.0, 120.0, 640.0, 360.0)
    assert stage((980, 600), panel=False).view_rect() == (0, 24, 980, 551)


@pytest.mark.parametrize("density", [1.0, 1.5, 2.0])
def test_on_a_dense_display_it_has_more_pixels_in_the_same_place(density):
    """As on a Mac: screen coordinates are points, letters keep their size in these."""
    dense, plain = stage((980, 600), density, scale=density), stage((980, 600))
    assert dense.panel_units() == plain.panel_units()
    assert dense.view_units() == pytest.approx(plain.view_units(), abs=1.0)
    assert dense.view_rect()[2:] == (round(640 * density), round(360 * density))


def test_where_coordinates_are_pixels_letters_and_panel_grow():
    """As on Windows and X11."""
    here = stage((1960, 1200), scale=2.0)
    assert here.panel_units() == 2 * PANEL_WIDTH
    assert here.view_rect()[2:] == (1280, 720)


@pytest.mark.parametrize("size", [(1, 1), (0, 0), (2, 400), (400, 2)])
def test_hardly_any_window_has_hardly_any_picture(size):
    here = stage(size)
    _, _, width, height = here.view_rect()
    assert 0 <= width <= size[0]
    assert 0 <= height <= size[1]
    if min(width, height) < 1:
        assert here.view_units() is None
