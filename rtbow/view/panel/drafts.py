"""What a person changes by the panel's widgets: gestures, texts being typed, and refused values."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import chain

from imgui_bundle import imgui

from rtbow.view.panel.rows import rounded
from rtbow.view.window import look

Set = Callable[[object, object], str]
"""Takes a new value and its gesture, and gives what is wrong with it, or nothing."""

_LEFT = 0
"""The mouse's left button."""


@dataclass
class Draft:
    """A text that is being typed, or was refused.

    Attributes:
        text: as typed.
        value: in whose place.
        message: what is wrong with it; empty if that is not known yet.
        focus: whether it asks for the keyboard.
        active: whether it has had it.
    """

    text: str
    value: object
    message: str = ""
    focus: bool = True
    active: bool = False


@dataclass
class Refusal:
    """A value that the scene refused and that was not typed; of a drag it goes with the drag."""

    message: str
    dragged: bool


@dataclass
class _Gesture:
    """A drag: its path, its identity, the value before, and whether it changed anything."""

    path: str
    value: object
    name: tuple[str, int]
    changed: bool = False


class Drafts:
    """Hands changes of values over, and remembers those that are not in the scene.

    Args:
        undo: takes the scene's last change back.

    Attributes:
        texts: those being typed or refused, by path.
        refusals: other refused values, by path.
    """

    def __init__(self, undo: Callable[[], None]) -> None:
        self.undo = undo
        self.texts: dict[str, Draft] = {}
        self.refusals: dict[str, Refusal] = {}
        self._gesture: _Gesture | None = None
        self._gestures = 0

    def begin(self) -> None:
        """Take over what the mouse and the keyboard did since the last frame."""
        if imgui.get_mouse_clicked_count(_LEFT) == 1:
            self._gesture = None  # a second click may still have to take back what it did
        clicked = imgui.is_window_hovered() and imgui.is_mouse_clicked(_LEFT)
        twice = imgui.is_mouse_double_clicked(_LEFT) or imgui.get_io().key_ctrl
        self._types = clicked and twice
        self._idle = not imgui.is_any_item_active()
        if not imgui.is_mouse_down(_LEFT):
            self.refusals = {k: r for k, r in self.refusals.items() if not r.dragged}
        if self._idle and imgui.is_key_pressed(imgui.Key.escape, repeat=False):
            self.forget()

    # --- what is not in the scene -------------------------------------------------------------

    def busy(self, path: str) -> bool:
        """Whether a text is being typed anywhere, or something inside a path is being dragged."""
        gesture = self._gesture
        return bool(self.texts) or (gesture is not None and gesture.path.startswith(path))

    def messages(self, path: str) -> Iterator[tuple[str, str]]:
        """Give what is wrong with values at a path and inside it, each with its own path."""
        items: tuple[Mapping[str, Draft | Refusal], ...] = self.texts, self.refusals
        for key, item in chain.from_iterable(kept.items() for kept in items):
            if item.message and f"{key}.".startswith(f"{path}."):
                yield key, item.message

    def forget_refused(self) -> bool:
        """Drop all that was refused; give whether there was anything."""
        wrong = bool(self.refusals) or any(draft.message for draft in self.texts.values())
        if wrong:
            self.forget()
        return wrong

    def forget(self, path: str = "") -> None:
        """Drop texts and refused values, those at a path and inside it or all."""

        def kept(key: str) -> bool:
            return bool(path) and not f"{key}.".startswith(f"{path}.")

        self.texts = {k: d for k, d in self.texts.items() if kept(k)}
        self.refusals = {k: r for k, r in self.refusals.items() if kept(k)}

    def scene_changed(self) -> None:
        """Drop what was refused by a scene that is another now."""
        self.refusals = {k: r for k, r in self.refusals.items() if r.dragged}

    # --- clicks and drags ---------------------------------------------------------------------

    def choose(self, path: str, value: object, set_value: Set) -> None:
        """Hand over what was clicked."""
        self.answer(path, set_value(value, None))

    def answer(self, path: str, message: str, *, dragged: bool = False) -> None:
        """Remember what is wrong with a value; an empty message says that nothing is."""
        if message:
            self.refusals[path] = Refusal(message, dragged)
        else:
            self.refusals.pop(path, None)

    def drag(self, path: str, before: object, value: float, set_value: Set) -> None:
        """Hand over what a slider has come to; one that is refused is tried in fewer digits."""
        gesture = self._gesture
        if gesture is None or gesture.path != path:
            self._gestures += 1
            gesture = self._gesture = _Gesture(path, before, (path, self._gestures))
        if value == before:
            return
        message = set_value(value, gesture.name)
        for digits in (2, 1):
            if not message or isinstance(value, int):
                break
            simpler = rounded(value, digits)
            if simpler == before or not set_value(simpler, gesture.name):
                message = ""
        gesture.changed = gesture.changed or not message
        self.answer(path, message, dragged=True)

    def value_before(self, path: str, value: object) -> object:
        """Give the value before the first of two clicks, which moved a slider; else the value."""
        gesture = self._gesture
        if gesture is None or gesture.path != path or not gesture.changed:
            return value
        gesture.changed = False
        return gesture.value

    # --- typing -------------------------------------------------------------------------------

    def starts_typing(self, width: float) -> bool:
        """Whether the widget that comes next, of a width, was clicked in order to type."""
        if not self._types:
            return False
        corner, mouse = imgui.get_cursor_screen_pos(), imgui.get_io().mouse_pos
        across = corner.x <= mouse.x < corner.x + width
        return across and corner.y <= mouse.y < corner.y + imgui.get_frame_height()

    def type(self, path: str, value: object, text: str) -> Draft:
        """Begin a text in place of a value."""
        self.refusals.pop(path, None)
        draft = self.texts[path] = Draft(text, value)
        return draft

    def text(self, path: str, value: object) -> Draft | None:
        """Give a value's text; one in whose place another value has come is dropped."""
        draft = self.texts.get(path)
        if draft is None:
            return None
        ended = draft.active and not draft.message and not draft.focus
        if draft.value != value or (ended and self._idle):
            del self.texts[path]
            return None
        return draft

    def draw(
        self,
        path: str,
        draft: Draft,
        width: float,
        read: Callable[[str], object],
        set_value: Set,
        *,
        hint: str = "",
        flags: int = 0,
    ) -> None:
        """Draw a text that is being typed; hand it over once it is done.

        Args:
            path: of the value.
            draft: the text.
            width: of the field.
            read: makes the value of the text.
            set_value: takes the value.
            hint: what an empty field shows.
            flags: of ImGui's text fields.
        """
        if draft.focus:
            imgui.set_keyboard_focus_here()
            draft.focus = False
        wrong = bool(draft.message)
        if wrong:
            imgui.push_style_color(imgui.Col_.frame_bg, look.ERROR_FRAME)
        imgui.set_next_item_width(width)
        flags |= imgui.InputTextFlags_.auto_select_all
        _, text = imgui.input_text_with_hint(f"##text {path}", hint, draft.text, flags)
        if wrong:
            imgui.pop_style_color()
        draft.text = text
        draft.active = draft.active or imgui.is_item_active()
        if not imgui.is_item_deactivated():
            return
        if imgui.is_key_pressed(imgui.Key.escape, repeat=False) or not text.strip():
            self.texts.pop(path, None)
            return
        value = read(text)
        message = "" if value == draft.value else set_value(value, None)
        if message:
            draft.message = message
            draft.focus = any(
                imgui.is_key_pressed(key, repeat=False)
                for key in (imgui.Key.enter, imgui.Key.keypad_enter)
            )
        else:
            self.texts.pop(path, None)
