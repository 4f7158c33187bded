"""Drawn over the picture: overlays, the split bar, messages, and what is under the cursor."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from imgui_bundle import imgui, implot

from rtbow.base.arrays import Array, Float32
from rtbow.scene.model import Scene
from rtbow.view.document.state import ViewState
from rtbow.view.picture.overlays import Overlay, overlays
from rtbow.view.picture.projection import part_views, whole_size
from rtbow.view.picture.readout import (
    PixelReadout,
    Profile,
    number_text,
    profile,
    read_pixel,
    text_of,
)
from rtbow.view.window import look
from rtbow.world.rain.box import box_of

if TYPE_CHECKING:
    from rtbow.view.document.edits import Edits

Area = tuple[float, float, float, float]
"""Left, top, width and height in the window's units."""

_FLAGS = (
    imgui.WindowFlags_.no_decoration
    | imgui.WindowFlags_.no_inputs
    | imgui.WindowFlags_.no_saved_settings
    | imgui.WindowFlags_.no_focus_on_appearing
    | imgui.WindowFlags_.no_nav
    | imgui.WindowFlags_.always_auto_resize
)
_BAR_REACH = 6.0
"""Half width of the split bar's handle."""
_PLOT_SIZE = (20.0, 10.0)
"""Largest size of a plot, in letters' heights; a small picture has smaller ones."""
_PLOT_SHARE = 0.32
"""Largest share of the picture's width and height that a plot takes."""
_PROFILE_POINTS = 256
_SETTLING = 4
"""Frames that ImGui takes to find a window's size."""
_FIT = implot.AxisFlags_.auto_fit
_NO_LEGEND = implot.Flags_.no_legend
_LEGEND = (12.0, 0.8)
"""Size of the false colours' legend, in letters' heights."""
_COLOURS = {
    "bow": (0.55, 0.85, 1.0, 0.9), "horizon": (1.0, 0.9, 0.5, 0.9), "grid": (1.0, 1.0, 1.0, 0.28),
    "box": (0.6, 1.0, 0.6, 0.7), "light": (1.0, 0.9, 0.4, 1.0), "antisolar": (1.0, 1.0, 1.0, 0.9),
}  # fmt: skip
_RED_NM = 600.0
_RED_LINE = (1.0, 0.45, 0.4, 0.9)
_VIOLET_LINE = (0.6, 0.6, 1.0, 0.9)


class Host(Protocol):
    """What the overlays need of the window."""

    edits: Edits
    state: ViewState

    @property
    def frame_rgb(self) -> Float32 | None:
        """The picture, cd/m², float32 (h, w, 3); None before the first."""

    def change(self, changes: dict[str, object], gesture: object = None) -> str:
        """Replace values of the scene."""

    def take_spectrum(self, scene: Scene, direction: tuple[float, float, float]) -> int:
        """Have the spectrum along a direction computed; give the request's number."""

    def false_range(self) -> tuple[float, float] | None:
        """Give log10 of the luminances at the ends of the false colours."""


@dataclass
class _Mark:
    """A chosen direction, which stays where it is in the scene while the camera turns.

    Attributes:
        direction: unit vector (3,).
        scene: that is seen there, when its spectrum was asked for.
        number: of the request for the spectrum.
    """

    direction: Array
    scene: Scene
    number: int


class Hud:
    """Draws over the picture; all places are the window's, from its upper left corner."""

    def __init__(self) -> None:
        self._dragging = False
        self._mark: _Mark | None = None
        self._lines: tuple[object, list[Overlay]] = (None, [])
        self._read: tuple[object, PixelReadout | None] = (None, None)
        self._cuts: tuple[object, Profile | None] = (None, None)
        self._plotted = 0
        self._plots_px = (0.0, 0.0)
        self._boxes: list[Area] = []

    def box_m(self, scene: Scene) -> Array:
        """Give the rain's corners (2, 3), m; a box about the eye where its file has none."""
        box = box_of(scene.droplets)
        if box is not None:
            return box
        eye = np.array(scene.camera.position_m)
        return np.stack([eye - 500.0, eye + 500.0])

    def drag_bar(self, host: Host, area: Area, inside: bool) -> bool:
        """Let the mouse drag the split bar; give whether it is being dragged."""
        compare = host.edits.scene.compare
        if compare is None:
            self._dragging = False
            return False
        mouse = imgui.get_io().mouse_pos
        near = abs(mouse.x - (area[0] + compare.split * area[2])) <= _BAR_REACH and inside
        if near or self._dragging:
            imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ew)
        if near and imgui.is_mouse_clicked(0):
            self._dragging = True
        if not self._dragging:
            return False
        if not imgui.is_mouse_down(0):
            self._dragging = False
            host.edits.end_gesture()
            return True
        split = min(max((mouse.x - area[0]) / area[2], 0.0), 1.0)
        host.change({"compare.split": split}, "split")
        return True

    def mark(self, host: Host, area: Area) -> None:
        """Mark the point under the mouse: its spectrum and the cut through it are shown."""
        frame = host.state.frame
        if frame is None or host.frame_rgb is None:
            return
        mouse = imgui.get_io().mouse_pos
        place = mouse.x - area[0], mouse.y - area[1]
        reading = read_pixel(host.frame_rgb, frame.scene, whole_size(area), place)
        self._take(host, reading.scene, reading.direction)

    def _take(self, host: Host, scene: Scene, direction: Array) -> None:
        east, north, up = (float(x) for x in direction)
        number = host.take_spectrum(scene, (east, north, up))
        self._mark = _Mark(direction, scene, number)
        self._plotted = 0

    def unmark(self) -> bool:
        """Remove the mark; give whether there was one."""
        marked, self._mark = self._mark is not None, None
        return marked

    def draw(self, host: Host, area: Area) -> None:
        """Draw everything that is on."""
        canvas = imgui.get_background_draw_list()
        low = imgui.ImVec2(area[0], area[1])
        high = imgui.ImVec2(area[0] + area[2], area[1] + area[3])
        canvas.push_clip_rect(low, high, True)
        frame = host.state.frame
        if frame is not None:
            self._draw_overlays(canvas, host, frame.scene, area)
        self._draw_bar(canvas, host, area)
        self._draw_mark(canvas, host, area)
        canvas.pop_clip_rect()
        self._boxes.clear()
        self._draw_legend(host, area)
        below = self._draw_notes(host, area)
        if frame is not None and host.state.readout_open:
            self._draw_readout(host, area, below)
        if self._mark is not None:
            self._draw_plots(host, area)

    # --- over the picture ---------------------------------------------------------------------

    def _draw_overlays(
        self, canvas: imgui.ImDrawList, host: Host, scene: Scene, area: Area
    ) -> None:
        names = host.state.overlays & {"circles", "grid", "box"}
        if not names:
            return
        size, orders = whole_size(area), host.state.circle_orders
        key = scene, size, frozenset(names), orders
        if self._lines[0] != key:
            self._lines = key, overlays(scene, size, names, orders=orders)
        origin = np.array(area[:2])
        for overlay in self._lines[1]:
            colour = imgui.get_color_u32(_line_colour(overlay))
            for line in overlay.lines:
                points: list[Any] = [imgui.ImVec2(x, y) for x, y in (line + origin).tolist()]
                canvas.add_polyline(points, colour, 1.2, 0)
        taken = list(self._boxes)  # where they were in the last picture
        for overlay in self._lines[1]:
            if overlay.at is not None and overlay.label:
                draw_label(canvas, area, overlay.at, overlay.label, _line_colour(overlay), taken)

    def _draw_bar(self, canvas: imgui.ImDrawList, host: Host, area: Area) -> None:
        compare = host.edits.scene.compare
        if compare is None:
            return
        x = area[0] + compare.split * area[2]
        middle = area[1] + 0.5 * area[3]
        white = imgui.get_color_u32(imgui.ImVec4(1.0, 1.0, 1.0, 0.8))
        canvas.add_line(imgui.ImVec2(x, area[1]), imgui.ImVec2(x, area[1] + area[3]), white, 1.5)
        canvas.add_circle_filled(imgui.ImVec2(x, middle), _BAR_REACH, white)

    def _marked(self, host: Host, area: Area) -> tuple[Scene, tuple[float, float]] | None:
        """Give the part of the frame's scene where the mark is seen, and its place in the view."""
        frame = host.state.frame
        if self._mark is None or frame is None:
            return None
        for part, view in part_views(frame.scene, whole_size(area)):
            (x, y), seen = view.pixels(self._mark.direction)
            if seen:
                return part, (float(x), float(y))
        return None

    def _draw_mark(self, canvas: imgui.ImDrawList, host: Host, area: Area) -> None:
        marked = self._marked(host, area)
        if marked is None:
            return
        at = imgui.ImVec2(area[0] + marked[1][0], area[1] + marked[1][1])
        canvas.add_circle(at, 5.0, imgui.get_color_u32(imgui.ImVec4(1.0, 1.0, 1.0, 1.0)))

    def _draw_legend(self, host: Host, area: Area) -> None:
        ends = host.false_range()
        if ends is None:
            return
        unit = imgui.get_font_size()
        width, height = _LEGEND[0] * unit, _LEGEND[1] * unit

        def content() -> None:
            imgui.text("luminance, cd/m²")
            canvas, at = imgui.get_window_draw_list(), imgui.get_cursor_screen_pos()
            for k in range(int(width)):
                colour = implot.sample_colormap(k / (width - 1.0), implot.Colormap_.viridis)
                low = imgui.ImVec2(at.x + k, at.y)
                high = imgui.ImVec2(at.x + k + 1.0, at.y + height)
                canvas.add_rect_filled(low, high, imgui.get_color_u32(colour))
            imgui.dummy(imgui.ImVec2(width, height))
            imgui.text(number_text(10.0 ** ends[0], 3))
            top = number_text(10.0 ** ends[1], 3)
            imgui.same_line(width - imgui.calc_text_size(top).x)
            imgui.text(top)

        at = area[0] + 8.0, area[1] + area[3] - 8.0
        self._boxes.append(_box("##legend", at, (0.0, 1.0), content))

    def _draw_notes(self, host: Host, area: Area) -> float:
        """Draw problems of the scene, progress and notices at the top of the picture.

        While the panel is open, it has progress and errors.

        Returns:
            The y below them.
        """
        state = host.state
        alone = not state.panel_open
        notices = [n for n in state.notices if alone or n.severity == "info"]

        def content() -> None:
            imgui.push_text_wrap_pos(max(area[2] - 40.0, 100.0))
            if state.stale:
                imgui.text_colored(look.ERROR, state.stale)
            if alone and state.progress is not None:
                share, what = state.progress
                imgui.progress_bar(share, imgui.ImVec2(220.0, 0.0), f"{what}: {share:.0%}")
            for notice in notices:
                colour = look.ERROR if notice.severity == "error" else look.TEXT
                imgui.text_colored(colour, notice.text)
            imgui.pop_text_wrap_pos()

        top = area[1] + 8.0
        if not (state.stale or notices or (alone and state.progress is not None)):
            return top
        box = _box("##notes", (area[0] + 0.5 * area[2], top), (0.5, 0.0), content)
        self._boxes.append(box)
        return top + box[3] + 4.0

    # --- what is under the cursor -------------------------------------------------------------

    def _draw_readout(self, host: Host, area: Area, top: float) -> None:
        io, frame = imgui.get_io(), host.state.frame
        place = io.mouse_pos.x - area[0], io.mouse_pos.y - area[1]
        over = 0.0 <= place[0] < area[2] and 0.0 <= place[1] < area[3]
        if io.want_capture_mouse or not over or frame is None or host.frame_rgb is None:
            return
        key = frame.number, place
        if self._read[0] != key:
            self._read = key, read_pixel(host.frame_rgb, frame.scene, whole_size(area), place)
        reading = self._read[1]
        if reading is None:
            return
        lines = text_of(reading)

        widest = max(imgui.calc_text_size(name).x for name, _ in lines)

        def content() -> None:
            for name, value in lines:
                imgui.text_colored(look.DIM, name)
                imgui.same_line(widest + 1.5 * imgui.get_font_size())
                imgui.text(value)

        self._boxes.append(_box("##readout", (area[0] + 8.0, top), (0.0, 0.0), content))

    def _draw_plots(self, host: Host, area: Area) -> None:
        mark, marked = self._mark, self._marked(host, area)
        assert mark is not None
        at = imgui.ImVec2(area[0] + area[2] - 8.0, area[1] + area[3] - 8.0)
        # Its size is known after some frames; from then on the user may move it.
        self._plotted += 1
        when = imgui.Cond_.always if self._plotted <= _SETTLING else imgui.Cond_.appearing
        imgui.set_next_window_pos(at, when, imgui.ImVec2(1.0, 1.0))
        flags = imgui.WindowFlags_.always_auto_resize | imgui.WindowFlags_.no_saved_settings
        _, kept = imgui.begin("at the marked point", True, flags)
        unit = imgui.get_font_size()
        width, height = (
            min(side * unit, _PLOT_SHARE * room)
            for side, room in zip(_PLOT_SIZE, area[2:], strict=True)
        )
        earlier = marked is not None and not _alike(marked[0], mark.scene)
        self._draw_spectrum(host, imgui.ImVec2(width, height), earlier=earlier)
        cut = self._cut(host, area, marked[1]) if marked is not None else None
        if cut is not None:
            imgui.same_line()
            if implot.begin_plot("luminance through the point", (width, height), _NO_LEGEND):
                implot.setup_axes("degrees from the antisolar point", "cd/m²", _FIT, _FIT)
                implot.plot_line("cut", _contiguous(cut.angle_deg), _contiguous(cut.luminance))
                implot.end_plot()
        if marked is not None and earlier and imgui.button("compute it for the scene as it is now"):
            self._take(host, marked[0], mark.direction)
        size = imgui.get_window_size()
        if (size.x, size.y) != self._plots_px:  # a button has come or gone
            self._plots_px, self._plotted = (size.x, size.y), 0
        imgui.end()
        if not kept:
            self.unmark()

    def _draw_spectrum(self, host: Host, size: imgui.ImVec2, *, earlier: bool) -> None:
        """Draw the spectrum at the mark, whose title says if the scene has changed since."""
        mark, state = self._mark, host.state
        assert mark is not None
        if state.spectrum is None or state.spectrum_number != mark.number:
            imgui.begin_child("spectrum", size)
            imgui.text_wrapped(state.spectrum_problem or "computing the spectrum …")
            imgui.end_child()
            return
        title = f"spectral radiance{' before the change' if earlier else ''}###spectral radiance"
        if implot.begin_plot(title, size, _NO_LEGEND):
            implot.setup_axes("nm", "W/(m² sr nm)", _FIT, _FIT)
            nm, radiance = state.spectrum
            implot.plot_line("spectrum", _contiguous(nm), _contiguous(radiance))
            implot.end_plot()

    def _cut(self, host: Host, area: Area, place: tuple[float, float]) -> Profile | None:
        """Give the cut through the mark; it changes with the frame and the mark's place."""
        frame = host.state.frame
        assert frame is not None
        key = frame.number, place, whole_size(area)
        if self._cuts[0] != key and host.frame_rgb is not None:
            cut = profile(host.frame_rgb, frame.scene, whole_size(area), place, _PROFILE_POINTS)
            self._cuts = key, cut
        return self._cuts[1]


def _alike(scene: Scene, other: Scene) -> bool:
    """Whether two scenes send the same light to the eye, whatever the direction of view."""
    eye = {"camera": other.camera, "compare": other.compare, "render": other.render}
    same_eye = scene.camera.position_m == other.camera.position_m
    same_filter = scene.camera.polarizer_deg == other.camera.polarizer_deg
    return same_eye and same_filter and scene.model_copy(update=eye) == other


def _contiguous(values: Array) -> Array:
    return np.ascontiguousarray(values, dtype=np.float64)


def _line_colour(overlay: Overlay) -> imgui.ImVec4:
    if overlay.kind == "bow" and overlay.wavelength_nm is not None:
        return imgui.ImVec4(*(_RED_LINE if overlay.wavelength_nm > _RED_NM else _VIOLET_LINE))
    return imgui.ImVec4(*_COLOURS[overlay.kind])


def draw_label(
    canvas: imgui.ImDrawList,
    area: Area,
    at: tuple[float, float],
    text: str,
    colour: imgui.ImVec4,
    taken: list[Area],
) -> None:
    """Write a label with a shadow beside a point, inside the picture.

    It avoids the areas in ``taken``, downwards and then upwards, and is added to them.
    """
    size = imgui.calc_text_size(text)
    low, high = area[1] + 2.0, max(area[1] + area[3] - size.y - 2.0, area[1] + 2.0)
    x = min(max(area[0] + at[0] + 4.0, area[0] + 2.0), area[0] + area[2] - size.x - 2.0)
    first = min(max(area[1] + at[1] - size.y - 2.0, low), high)
    down = (first + k * size.y for k in range(int((high - first) / size.y) + 1))
    up = (first - k * size.y for k in range(1, int((first - low) / size.y) + 1))
    places = ((x, y, size.x, size.y) for y in chain(down, up))
    free = (place[1] for place in places if not any(overlap(place, other) for other in taken))
    y = next(free, first)
    taken.append((x, y, size.x, size.y))
    shadow = imgui.get_color_u32(imgui.ImVec4(0.0, 0.0, 0.0, 0.8))
    canvas.add_text(imgui.ImVec2(x + 1.0, y + 1.0), shadow, text)
    bright = imgui.ImVec4(colour.x, colour.y, colour.z, 1.0)
    canvas.add_text(imgui.ImVec2(x, y), imgui.get_color_u32(bright), text)


def overlap(a: Area, b: Area) -> bool:
    """Whether two areas overlap."""
    return all(a[k] < b[k] + b[k + 2] and b[k] < a[k] + a[k + 2] for k in (0, 1))


def _box(
    name: str, at: tuple[float, float], pivot: tuple[float, float], content: Callable[[], None]
) -> Area:
    """Draw a small box of text over the picture; give its area, known from its second frame."""
    imgui.set_next_window_pos(imgui.ImVec2(*at), imgui.Cond_.always, imgui.ImVec2(*pivot))
    imgui.set_next_window_bg_alpha(0.85)
    imgui.begin(name, None, _FLAGS)
    content()
    place, size = imgui.get_window_pos(), imgui.get_window_size()
    imgui.end()
    return float(place.x), float(place.y), float(size.x), float(size.y)
