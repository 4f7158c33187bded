"""Draws the scene's tables: every key of its models, each by its kind."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import lru_cache
from typing import Any

from imgui_bundle import imgui
from pydantic import BaseModel

from rtbow.base.errors import InputError
from rtbow.scene.air import FREE_AEROSOL
from rtbow.scene.droplets import BY_PARTS, Density, Droplets
from rtbow.scene.lights import PointLight, SunLight
from rtbow.scene.model import Scene
from rtbow.scene.radius import GammaRadius, density_key
from rtbow.scene.text.file import parse_set
from rtbow.scene.text.overrides import flat, plain
from rtbow.scene.text.schema import Node, toml_text
from rtbow.view.document.proposals import RIGHT, Proposals, plain_value, split_path, value_at
from rtbow.view.panel import kinds, widgets
from rtbow.view.panel.drafts import Set
from rtbow.view.panel.kinds import left_out_of
from rtbow.view.panel.layout import Rows
from rtbow.view.panel.rows import Row, own_row, rows_of
from rtbow.view.panel.unused import unused_keys

_BY_PARTS = ("box_m", "radius", "density")
"""Keys that droplets need without a file."""
_TABLES = ("radius", "density")
_AEROSOL_MODEL = "atmosphere.aerosol.model"
_SHARED = ("camera.size_px",)
"""Keys that both sides of a split picture have in common."""
_SOURCE = own_row(
    "droplets.source",
    "drops from",
    "where the drops come from: described by their distributions, or read from a volume file",
    "A file has the rain's own shape; a description can be changed here.",
    "choice",
    choices=("a description", "a file"),
)
_WORDS = {"point": "lamp"}
"""Names of kinds on buttons, where they differ."""
_CORNERS = ("from", "to")
_TALL = ("vector", "corners", "boxes")
"""Kinds of value that take several lines."""


class Tables:
    """Draws tables of the scene and proposes changes.

    Args:
        rows: of the panel.
        proposals: takes changes.
    """

    def __init__(self, rows: Rows, proposals: Proposals) -> None:
        self._rows, self._proposals = rows, proposals
        rows.tips.on_reset = self.reset

    # --- any table ----------------------------------------------------------------------------

    def table(
        self,
        path: str,
        table: BaseModel,
        *,
        only: Collection[str] = (),
        hidden: Collection[str] = (),
        needed: Collection[str] = (),
        kinds: tuple[type[BaseModel], ...] = (),
    ) -> None:
        """Draw all rows of a table.

        Args:
            path: of the table; empty for the scene.
            table: its values.
            only: keys to show; empty for all.
            hidden: keys that are not shown.
            needed: keys that may not be left out here, though the model allows it.
            kinds: all classes that it might have.
        """
        origin = self._origin(path)
        alike = type(origin) is type(table)
        for row in rows_of(path, type(table), kinds):
            if row.name not in hidden and (not only or row.name in only):
                value = getattr(table, row.name)
                # For another kind of table, only the kind can be reset.
                comparable = alike or (row.kind == "tag" and origin is not None)
                before = getattr(origin, row.name) if comparable else value
                row = left_out_of(row, table)
                self.row(row, value, before, needed=row.name in needed)

    def _unused(self, path: str, table: BaseModel) -> set[str]:
        """Give the keys that are left out; none whose value was refused and still waits."""
        waits, unused = self._rows.drafts.messages, unused_keys(table, self._proposals.method)
        return {key for key in unused if not any(waits(f"{path}.{key}"))}

    def _origin(self, path: str) -> Any:
        return value_at(self._proposals.origin, split_path(path)) if path else None

    def row(self, row: Row, value: Any, before: Any, *, needed: bool = False) -> None:
        """Draw one key.

        Args:
            row: what is known of it.
            value: as it is.
            before: as it was opened.
            needed: whether it may not be left out here.
        """
        if row.kind == "table":
            self._table_in(row, value, before, needed=needed)
            return
        if row.kind == "tables":
            self._list(row, value)
            return
        rows = self._rows
        differs = value != before
        if not rows.begin_row(row, differs):
            return
        shared = self._proposals.right and row.path in _SHARED
        if shared:
            imgui.begin_disabled()
        resets = differs and not shared
        # Beside the label of a value that takes several lines, not beside its last part.
        first = resets and row.kind in _TALL
        pressed = first and rows.reset_button(row, first=True)
        rows.label(row.label)
        if row.optional and not needed:
            self._on_off(row, value)
            if value is not None:
                imgui.same_line(0.0, rows.gap)
        if value is not None or not row.optional:
            self._value(row, value)
        if resets and not first:
            pressed = rows.reset_button(row)
        if pressed:
            self.reset(row)
        if shared:
            imgui.end_disabled()
        rows.end_row()

    def _set(self, row: Row) -> Set:
        def change(value: object, gesture: object) -> str:
            if row.kind in ("path", "spectrum"):
                value = value.strip() if isinstance(value, str) else value
                problem = kinds.problem_of_file(row.path, value, self._proposals.scene)
                if problem:
                    return problem
            return self._proposals.change(self._change(row, value), gesture)

        return change

    def _set_item(self, path: str) -> Set:
        return lambda value, gesture: self._proposals.change({path: value}, gesture)

    def _change(self, row: Row, value: object) -> dict[str, object]:
        """Give the change of one key, with what it needs beside it."""
        changes = {row.path: value}
        if value is None:
            changes |= kinds.kept_in_place(self._proposals.scene, row.path)
        if row.path == _AEROSOL_MODEL and value != "custom":
            place = row.path.rpartition(".")[0]
            changes |= {f"{place}.{key}": None for key in FREE_AEROSOL}
        drops = self._proposals.scene.droplets
        if row.path == "droplets.radius.mixing" and value == "per-point" and drops.grid is None:
            changes["droplets.grid"] = kinds.GRID
        return changes

    def reset(self, row: Row) -> None:
        """Reset a row's value; with the kind of a table, the whole table."""
        keys = [row.path]
        if row.kind == "tag":
            keys = [row.path.rpartition(".")[0]]
            if keys == ["droplets.radius"]:
                keys += ["droplets.density", "droplets.grid"]
        self._rows.drafts.forget(row.path)
        self._rows.drafts.answer(row.path, self._proposals.reset(*keys))

    def _on_off(self, row: Row, value: Any) -> None:
        """Draw the box of a value that may be left out, and what holds if it is."""
        rows = self._rows
        text = rows.fitting(row.absent_text, "left out") if value is None else ""
        changed, on = imgui.checkbox(f"{text}##on {row.path}", value is not None)
        rows.note(f"{row.path}/on")
        if changed:
            rows.drafts.choose(row.path, kinds.start_of(row) if on else None, self._set(row))

    def _value(self, row: Row, value: Any) -> None:
        """Draw what stands beside the label."""
        rows = self._rows
        width = rows.reset_x - rows.gap - imgui.get_cursor_pos_x()
        if row.kind == "number":
            widgets.number(rows, row.path, value, width, self._set(row), row.slide, unit=row.unit)
        elif row.kind == "flag":
            widgets.flag(rows, row.path, value, self._set(row))
        elif row.kind == "choice":
            widgets.choice(rows, row.path, value, row.choices, width, self._set(row))
        elif row.kind == "tag":
            widgets.choice(rows, row.path, value, row.choices, width, self._set_kind(row))
        elif row.kind == "spectrum":
            widgets.spectrum(rows, row, value, width, self._set(row))
        elif row.kind in ("text", "path"):
            widgets.text(rows, row.path, value, width, self._set(row))
        elif row.kind == "boxes":
            widgets.boxes(rows, row, value, self._set(row))
        elif row.kind == "vector":
            self._vector(row.path, value, row)
        elif row.kind == "corners":
            self._corners(row, value)
        elif row.kind == "overrides":
            imgui.text_disabled(f"{len(value)} of them" if len(value) > 1 else "")
        else:
            widgets.toml(rows, row.path, value, width, self._set(row))

    def _corners(self, row: Row, corners: Sequence[Any]) -> None:
        """Draw the corners of a box, each with a word before it."""
        rows, x = self._rows, imgui.get_cursor_pos_x()
        for index, corner in enumerate(corners):
            word = _CORNERS[index]
            imgui.set_cursor_pos_x(rows.value_x - rows.gap - imgui.calc_text_size(word).x)
            imgui.align_text_to_frame_padding()
            imgui.text_disabled(word)
            imgui.same_line(x)
            self._vector(row.inside(index), corner, row)

    def _vector(self, path: str, value: Any, row: Row) -> None:
        widgets.vector(
            self._rows, path, value, row, lambda index: self._set_item(f"{path}.{index}")
        )

    # --- tables in tables ---------------------------------------------------------------------

    def _table_in(self, row: Row, value: Any, before: Any, *, needed: bool) -> None:
        """Draw a table that stands in another: its box if it may be left out, and its rows."""
        if row.optional and not needed:
            rows = self._rows
            if not rows.begin_row(row, value != before):
                return
            rows.label(row.label)
            self._on_off(row, value)
            if value != before and rows.reset_button(row):
                self.reset(row)
            rows.end_row()
        if value is not None:
            self.any_table(row.path, value, row.node.models)

    def any_table(self, path: str, table: Any, models: tuple[type[BaseModel], ...] = ()) -> None:
        """Draw a table; some have rows that depend on others."""
        if isinstance(table, Droplets):
            self._droplets(path, table)
        else:
            self.table(path, table, hidden=self._unused(path, table), kinds=models)

    def _droplets(self, path: str, droplets: Droplets) -> None:
        rows = self._rows
        from_file = droplets.file is not None
        if rows.begin_row(_SOURCE, False):
            rows.label(_SOURCE.label)
            width = rows.reset_x - rows.gap - imgui.get_cursor_pos_x()
            chosen = _SOURCE.choices[from_file]
            widgets.choice(rows, _SOURCE.path, chosen, _SOURCE.choices, width, self._set_source)
            rows.end_row()
        needed = {*_BY_PARTS, "file"}
        if from_file:
            self.table(path, droplets, only=("file",), needed=needed)
            self.table(path, droplets, hidden={*BY_PARTS, "file", *self._unused(path, droplets)})
            return
        for part in _TABLES:
            self._part(path, part, droplets)
        hidden = {*_TABLES, "file", *self._unused(path, droplets)}
        self.table(path, droplets, hidden=hidden, needed=needed)

    def _part(self, path: str, part: str, droplets: Droplets) -> None:
        table = getattr(droplets, part)
        if table is None:
            return
        hidden: set[str] = set()
        needed: set[str] = set()
        if part == "density" and droplets.radius is not None:
            # The other key does not suit the distribution.
            radius = droplets.radius
            key = density_key(radius.distribution, radius.model_dump(exclude_none=True))
            needed = set() if key is None else {key}
            hidden = {*Density.model_fields} - needed
        if isinstance(table, GammaRadius):
            # Of its two sets of parameters, the one that is given.
            hidden = {name for name in type(table).model_fields if getattr(table, name) is None}
            needed = {*type(table).model_fields} - hidden
        node = _node(type(self._proposals.scene), "droplets", part)
        self.table(f"{path}.{part}", table, hidden=hidden, needed=needed, kinds=node.models)

    def _set_source(self, value: object, gesture: object) -> str:
        droplets = self._proposals.scene.droplets
        if value == _SOURCE.choices[1]:
            changes = kinds.droplets_of_file()
        else:
            node = _node(type(self._proposals.scene), "droplets", "radius")
            changes = kinds.droplets_of_box(droplets, node)
        return self._proposals.change({f"droplets.{k}": v for k, v in changes.items()}, gesture)

    def _set_kind(self, row: Row) -> Set:
        """Give the function that replaces a table by one of another kind."""
        place = row.path.rpartition(".")[0]
        scene = self._proposals.scene

        def change(value: object, gesture: object) -> str:
            kind = str(value)
            if place == "droplets.radius":
                node = _node(type(scene), "droplets", "radius")
                radius = kinds.radius_table(scene.droplets, kind, node)
                changes = {f"droplets.{key}": item for key, item in radius.items()}
            else:
                path = split_path(place)
                table, node = value_at(scene, path), _node(type(scene), *path)
                if isinstance(table, SunLight | PointLight):
                    changes = {place: kinds.light_table(scene, table, kind, node)}
                else:
                    changes = {place: kinds.other_kind(table, kind, node)}
            return self._proposals.change(changes, gesture)

        return change

    # --- lists of tables ----------------------------------------------------------------------

    def _list(self, row: Row, items: tuple[BaseModel, ...]) -> None:
        """Draw a list of tables, with buttons that add and remove."""
        rows = self._rows
        node = Node.of(row.node.items[0])
        kind_names = _kind_names(node)
        for number, item in enumerate(items):
            if len(items) > 1 and self._heading(row, number, len(items)):
                rest = [plain_value(table) for k, table in enumerate(items) if k != number]
                rows.drafts.answer(row.path, self._proposals.change({row.path: rest}))
            path = row.inside(number)
            self.table(path, item, hidden=self._unused(path, item), kinds=node.models)
        for place, kind in enumerate(kind_names or ("",)):
            if place:
                imgui.same_line()
            if imgui.button(f"Add a {_WORDS.get(kind, kind)}##{row.path}"):
                self._add(row, items, kind, node)
            rows.note(f"{row.path}/add {kind}")
        before = value_at(self._proposals.origin, split_path(row.path))
        if before is not None and len(before) != len(items) and rows.reset_button(row):
            self.reset(row)

    def _add(self, row: Row, items: tuple[BaseModel, ...], kind: str, node: Node) -> None:
        scene = self._proposals.scene
        if row.path == "light":
            new = kinds.light_table(scene, None, kind, node)
        else:
            new = kinds.fresh(node.kind(kind))
        every = [*(plain_value(table) for table in items), new]
        self._rows.drafts.answer(row.path, self._proposals.change({row.path: every}))

    def _heading(self, row: Row, number: int, count: int) -> bool:
        """Draw the heading of an item; give whether it is to be removed."""
        rows = self._rows
        imgui.separator_text(f"{row.label} {number}" if count > 1 else row.label)  # as in keys
        imgui.same_line(rows.reset_x - 3.5 * rows.row_height)
        gone = imgui.small_button(f"Remove##{row.path}{number}")
        rows.note(f"{row.path}.{number}/remove")
        return gone

    # --- what differs on the right ------------------------------------------------------------

    def overrides(self, right: dict[str, Any]) -> None:
        """Draw the keys that differ on the right of a split picture, to change or remove."""
        rows = self._rows
        every = dict(flat(right))
        for key, value in every.items():
            imgui.align_text_to_frame_padding()
            imgui.text_disabled(f"{key} = {toml_text(plain(value))}")
            imgui.same_line(rows.reset_x)
            if imgui.button(f"x##{key}", (rows.row_height, rows.row_height)):
                rest = {k: v for k, v in every.items() if k != key}
                rows.drafts.answer(RIGHT, self._proposals.change({RIGHT: rest}))
            rows.note(f"{RIGHT}/remove {key}")

        def add(text: object, gesture: object) -> str:
            try:
                key, value = parse_set(str(text).removeprefix("--set").strip())
            except InputError as error:
                return str(error)
            problem = kinds.problem_of_file(key, value, self._proposals.scene)
            return problem or self._proposals.change({RIGHT: {**every, key: value}}, gesture)

        width = rows.right_edge - rows.left
        widgets.text(rows, RIGHT, "", width, add, hint="key = value of the right side")


@lru_cache(maxsize=16)
def _node(scene: type[Scene], *path: str | int) -> Node:
    node = Node.of(scene)
    for part in path:
        child = node.child(part)
        assert child is not None
        node = child
    return node


def _kind_names(node: Node) -> tuple[str, ...]:
    """Name the kinds of table that a node may have."""
    return next(
        (row.choices for row in rows_of("", node.models[0], node.models) if row.kind == "tag"), ()
    )
