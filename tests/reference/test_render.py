"""Whole frames of the reference: the order of rows, and the progress over them."""

from one_pixel import EYE, Pixel
from rtbow.reference.render import render_reference
from rtbow.world.world import resolve
from textbook import LUMINANCE


def test_rows_are_from_the_top():
    # A tall narrow picture across the top of the primary: dark above, bright below.
    camera = {"position_m": list(EYE), "altitude_deg": 28.0, "fov_deg": 4.0, "size_px": [2, 24]}
    frame = render_reference(resolve(Pixel(disc_deg=0.0).scene(camera=camera)))
    luminance = (frame @ LUMINANCE).mean(axis=1)
    assert luminance[:6].mean() < 0.3 * luminance[12:].max()


def test_progress_sees_every_row():
    seen = []

    def progress(rows):
        for row in rows:
            seen.append(row)
            yield row

    camera = {"size_px": [2, 5]}
    render_reference(resolve(Pixel().scene(camera=camera)), progress)
    assert seen == list(range(5))
