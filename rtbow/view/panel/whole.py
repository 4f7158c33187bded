"""The panel beside the picture: the whole scene and how it is shown, by sections."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

from imgui_bundle import imgui

from rtbow.frames.display import EV_LIMIT
from rtbow.render.renderer import METHODS
from rtbow.scene.lights import MOON
from rtbow.scene.model import Scene
from rtbow.view.document.edits import Edits
from rtbow.view.document.proposals import RIGHT, Proposals
from rtbow.view.document.state import OVERLAYS, Actions, ViewState
from rtbow.view.panel import widgets
from rtbow.view.panel.drafts import Drafts, Set
from rtbow.view.panel.layout import Rows
from rtbow.view.panel.rows import Row, Slide, own_row, rows_of, shown_number
from rtbow.view.panel.sections.gallery import Gallery
from rtbow.view.panel.sections.keep import Keep
from rtbow.view.panel.sections.status import Status
from rtbow.view.panel.sections.sun import SunByDate
from rtbow.view.panel.tables import Tables
from rtbow.view.panel.tips import Tips
from rtbow.view.picture.overlays import ORDERS
from rtbow.view.window import look

_SECTIONS = {
    "light": "Sun", "droplets": "Drops", "atmosphere": "Air", "ground": "Air",
    "scattering": "Theory", "camera": "Camera", "render": "Picture", "compare": "Picture",
}  # fmt: skip
"""Section of each table of the scene; other tables have a section of their own."""
_OPEN = ("Sun", "Drops", "Picture")
"""Sections that are open at first."""
_METHOD = own_row(
    "view.method", "method",
    "how the picture is computed: fast within its stated error, spectral for each wavelength, "
    "reference in float64 on the CPU; auto takes fast wherever that keeps its error",
    kind="choice", choices=METHODS, option=f"--method {'|'.join(METHODS)}",
)  # fmt: skip
_AUTO = own_row(
    "view.exposure", "auto exposure", "the exposure follows the picture's brightest parts",
    option="--exposure auto",
)  # fmt: skip
_EXPOSURE = own_row(
    "view.exposure_ev", "exposure",
    "exposure value for ISO 100: a sunlit scene has about 15, a lamp at night about 4",
    "One more halves the picture's brightness.", "number",
    unit="EV", slide=Slide(-5.0, 20.0), option="--exposure EV",
)  # fmt: skip
_FPS = own_row(
    "view.target_fps", "target rate",
    "frames per second while anything moves, kept by drawing them smaller",
    "A higher rate is smoother and coarser; a picture at rest is drawn in full.", "number",
    unit="fps", slide=Slide(5.0, 120.0, log=True),
)  # fmt: skip
_ORDERS = own_row(
    "view.circle_orders", "circles of", "bows whose circles are drawn, by internal reflections",
    kind="boxes", names=tuple(f"{order} {name}" for order, name in ORDERS.items()),
)  # fmt: skip
_READOUT = own_row(
    "view.readout", "readout under the cursor",
    "angles, luminance, colour and the distance of the rain at the point under the mouse",
)  # fmt: skip
_SPLIT = own_row(
    "view.split", "split the picture",
    "the picture's right side shows the scene with some keys changed (key V)",
    "Drag the bar in the picture to move it.",
)  # fmt: skip
_SIDE = own_row("view.side", "edit", "which side of the split picture the panel shows and changes")


class Panel:
    """Shows the scene and changes it.

    Args:
        actions: what the window does.

    Attributes:
        rows: where its widgets stand.
        sun: a date, time and place for the sun.
    """

    def __init__(self, actions: Actions) -> None:
        self._actions = actions
        self._proposals = Proposals(actions)
        self.rows = Rows(Drafts(self._proposals.undo), Tips(self._proposals))
        self._tables = Tables(self.rows, self._proposals)
        self._status = Status()
        self._gallery = Gallery(actions)
        self._keep = Keep(actions)
        self.sun = SunByDate.now()
        self._scene: Scene | None = None
        self._first: ViewState | None = None

    def close(self) -> None:
        """Forget its pictures, while ImGui's context still exists."""
        self._gallery.close()

    def forget_refused(self) -> bool:
        """Drop refused values that are still shown; give whether there were any."""
        return self.rows.drafts.forget_refused()

    def draw(self, edits: Edits, state: ViewState) -> None:
        """Draw the panel into ImGui's current window; changes go to the actions.

        Args:
            edits: the scene.
            state: how it is shown.
        """
        if self._first is None:
            self._first = ViewState(
                state.method, state.exposure_ev, target_fps=state.target_fps,
                circle_orders=state.circle_orders,
            )  # fmt: skip
        if edits.scene is not self._scene:
            self._scene = edits.scene
            self.rows.drafts.scene_changed()
        self._proposals.look(edits, state)
        rows = self.rows
        rows.begin()
        self._status.draw(rows, state)
        self._keep.draw_question(rows, edits, state)
        self._history(edits)
        right = self._proposals.right
        if right:
            self._side_banner()
        if self._section("Scenes"):
            self._gallery.draw(rows, edits, state)
        for title, keys in _sections(type(edits.scene)).items():
            if self._section(title, self._heading(title)):
                self._scene_section(title, keys, edits, state)
        if self._section("Keep"):
            self._keep.draw(rows, edits, state)
        if right:
            imgui.pop_style_color(len(_RIGHT_COLOURS))
        rows.end()

    # --- head ---------------------------------------------------------------------------------

    def _history(self, edits: Edits) -> None:
        rows = self.rows
        width = (rows.right_edge - rows.left - rows.gap) / 2
        for name, keys, can, do in (
            ("Undo", "Ctrl+Z", edits.can_undo, self._actions.undo),
            ("Redo", "Ctrl+Shift+Z", edits.can_redo, self._actions.redo),
        ):
            if name == "Redo":
                imgui.same_line(0.0, rows.gap)
            imgui.begin_disabled(not can)
            text = f"{name} ({keys})"
            room = width - 2.0 * imgui.get_style().frame_padding.x
            short = text if imgui.calc_text_size(text).x <= room else name
            if imgui.button(f"{short}###{name}", (width, 0.0)):
                rows.drafts.forget()
                do()
            imgui.end_disabled()
            rows.note(name)

    def _side_banner(self) -> None:
        for colour, value in _RIGHT_COLOURS.items():
            imgui.push_style_color(colour, value)
        imgui.push_style_color(imgui.Col_.text, look.RIGHT)
        imgui.text("Changes go to the right side of the picture.")
        imgui.pop_style_color()

    def _section(self, title: str, shown: str = "") -> bool:
        flags = imgui.TreeNodeFlags_.default_open if title in _OPEN else 0
        is_open = imgui.collapsing_header(f"{shown or title}###{title}", flags)
        self.rows.note(f"section/{title}")
        return is_open

    def _heading(self, title: str) -> str:
        """Give a section's heading; that of the lights names their kinds."""
        if title != "Sun":
            return title
        types = {str(light.type) for light in self._proposals.scene.light}
        return "Sun" if types == {"sun"} else "Lamps" if types == {"point"} else "Sun and lamps"

    # --- the scene ----------------------------------------------------------------------------

    def _scene_section(
        self, title: str, keys: tuple[Row, ...], edits: Edits, state: ViewState
    ) -> None:
        scene, origin = self._proposals.scene, self._proposals.origin
        if title == "Sun":
            self._sun(scene)
        if title == "Picture":
            self._view(state)
        for row in keys:
            if row.name == "compare":
                self._compare(edits, state)
            else:
                before = getattr(origin, row.name, None)
                self._tables.row(row, getattr(scene, row.name), before)

    def _sun(self, scene: Scene) -> None:
        for number, light in enumerate(scene.light):
            if light.type == "sun" and light.spectrum != MOON:
                at_deg = light.altitude_deg, light.azimuth_deg
                self.sun.draw(self.rows, f"light.{number}", at_deg, self._proposals.change)
                return

    # --- the picture --------------------------------------------------------------------------

    def _view(self, state: ViewState) -> None:
        """Draw the settings of how the scene is shown, which are not in the scene."""
        rows, first = self.rows, self._first
        assert first is not None

        def set_method(value: object, gesture: object) -> str:
            state.method = next(m for m in METHODS if m == value)
            return ""

        differs = state.method != first.method
        if rows.begin_row(_METHOD, differs):
            rows.label(_METHOD.label)
            widgets.choice(rows, _METHOD.path, state.method, METHODS, rows.value_width, set_method)
            if self._ends_with_reset(_METHOD, differs):
                state.method = first.method
        self._exposure(state, first)

        def set_fps(value: object, gesture: object) -> str:
            if not isinstance(value, int | float) or not 1.0 <= value <= 1000.0:
                return f"{value}; must be a number, 1..1000"
            state.target_fps = float(value)
            return ""

        self._number(_FPS, state.target_fps, first.target_fps, set_fps)
        for name, (key, what) in OVERLAYS.items():
            row = _overlay_row(name, key, what)
            if not rows.begin_row(row, False):
                continue
            changed, on = imgui.checkbox(f"{row.label}##{row.path}", name in state.overlays)
            rows.note(row.path)
            if changed:
                (state.overlays.add if on else state.overlays.discard)(name)
            rows.end_row()
            if name == "circles" and name in state.overlays:
                self._circle_orders(state, first)
        if rows.begin_row(_READOUT, False):
            state.readout_open = imgui.checkbox(_READOUT.label, state.readout_open)[1]
            rows.note(_READOUT.path)
            rows.end_row()

    def _circle_orders(self, state: ViewState, first: ViewState) -> None:
        def set_orders(value: object, gesture: object) -> str:
            state.circle_orders = tuple(value) if isinstance(value, list) else ()
            return ""

        differs = state.circle_orders != first.circle_orders
        if self.rows.begin_row(_ORDERS, differs):
            self.rows.label(_ORDERS.label)
            widgets.boxes(self.rows, _ORDERS, state.circle_orders, set_orders)
            if self._ends_with_reset(_ORDERS, differs):
                state.circle_orders = first.circle_orders

    def _ends_with_reset(self, row: Row, differs: bool) -> bool:
        """End a row; give whether its value is to be reset to what the window was opened with."""
        pressed = differs and self.rows.reset_button(row)
        self.rows.end_row()
        return pressed

    def _exposure(self, state: ViewState, first: ViewState) -> None:
        rows = self.rows
        frame_ev = state.frame.exposure_ev if state.frame is not None else 15.0
        automatic = state.exposure_ev is None

        def set_auto(value: object, gesture: object) -> str:
            state.exposure_ev = None if value else round(frame_ev, 1)
            return ""

        def set_ev(value: object, gesture: object) -> str:
            if not isinstance(value, int | float) or not abs(value) <= EV_LIMIT:
                return f"{value}; must be a number, -{EV_LIMIT:g}..{EV_LIMIT:g} EV"
            state.exposure_ev = float(value)
            return ""

        differs = automatic != (first.exposure_ev is None)
        if rows.begin_row(_AUTO, differs):
            rows.label(_AUTO.label)
            text = f"now {shown_number(round(frame_ev, 1))} EV" if automatic else ""
            widgets.flag(rows, _AUTO.path, automatic, set_auto, text)
            if self._ends_with_reset(_AUTO, differs):
                state.exposure_ev = first.exposure_ev
        if state.exposure_ev is not None:
            self._number(_EXPOSURE, state.exposure_ev, first.exposure_ev, set_ev)

    def _number(self, row: Row, value: float, before: float | None, set_value: Set) -> None:
        """Draw a number that is not the scene's; ``before`` is None if there was none."""
        rows = self.rows
        differs = before is not None and value != before
        if rows.begin_row(row, differs):
            rows.label(row.label)

            def put_back(moved_from: float) -> None:
                set_value(moved_from, None)

            widgets.number(
                rows, row.path, value, rows.value_width, set_value, row.slide, unit=row.unit,
                put_back=put_back,
            )  # fmt: skip
            if self._ends_with_reset(row, differs):
                set_value(before, None)

    def _compare(self, edits: Edits, state: ViewState) -> None:
        rows = self.rows
        compare = edits.scene.compare
        if rows.begin_row(_SPLIT, False):
            changed, on = imgui.checkbox(f"{_SPLIT.label}##split", compare is not None)
            rows.note(_SPLIT.path)
            if changed:
                self._actions.split(on)
            rows.end_row()
        if compare is None:
            return
        if rows.begin_row(_SIDE, False):
            rows.label(_SIDE.label)
            for side in ("left", "right"):
                if imgui.radio_button(f"{side}##side", state.side == side):
                    state.side = "left" if side == "left" else "right"
                rows.note(f"{_SIDE.path}/{side}")
                imgui.same_line()
            imgui.new_line()
            rows.end_row()
        origin = edits.opened.scene.compare
        for row in rows_of("compare", type(compare)):
            value = getattr(compare, row.name)
            before = value if origin is None else getattr(origin, row.name)
            if f"compare.{row.name}" == RIGHT:
                if rows.begin_row(row, False):
                    rows.label(row.label)
                    imgui.text_disabled("differs in" if value else "is like the left")
                    self._tables.overrides(value)
                    rows.end_row()
            else:
                self._tables.row(row, value, before)


_RIGHT_COLOURS = {
    imgui.Col_.header: look.RIGHT_HEADER,
    imgui.Col_.slider_grab: look.RIGHT_GRAB,
    imgui.Col_.slider_grab_active: look.RIGHT,
    imgui.Col_.check_mark: look.RIGHT,
}


@lru_cache(maxsize=16)
def _overlay_row(name: str, key: str, what: str) -> Row:
    short = what.partition(":")[0].partition(",")[0]
    return own_row(f"view.overlays.{name}", f"{short} ({key})", what)


@lru_cache(maxsize=4)
def _sections(model: type[Scene]) -> Mapping[str, tuple[Row, ...]]:
    """Give the scene's rows by section, in the panel's order."""
    lists: dict[str, list[Row]] = {title: [] for title in dict.fromkeys(_SECTIONS.values())}
    for row in rows_of("", model):
        title = _SECTIONS.get(row.name, row.label.capitalize())
        lists.setdefault(title, []).append(row)
    return {title: tuple(rows) for title, rows in lists.items()}
