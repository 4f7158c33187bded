"""The paper's figures: renders them, keeps finished frames, and measures the paper's claims."""

from __future__ import annotations

import difflib
import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from rtbow.base.arrays import Float32, Progress, floats, no_progress
from rtbow.base.errors import InputError, RtbowError
from rtbow.base.files import write_atomic
from rtbow.base.version import __version__
from rtbow.frames.display import auto_exposure_ev
from rtbow.frames.image import frame_metadata, read_exr, write_exr, write_frame
from rtbow.render.renderer import Renderer
from rtbow.scene.model import Scene
from rtbow.scene.text.file import builtin_scenes, load_scene
from rtbow.study.claims import Frame, Verdict, judge

if TYPE_CHECKING:
    from rtbow.gl.context import Backend

PREFIX = "figures/"
DEFAULT_SIZE = (480, 270)


def figure_names() -> list[str]:
    """List the figures' scenes without their folder, in the paper's order."""
    names = [n.removeprefix(PREFIX) for n in builtin_scenes() if n.startswith(PREFIX)]
    # Figure 8 goes from the high sun to the low one.
    return sorted(names, key=lambda n: (n[:4], -int(n[5:]) if "-" in n else 0, n))


def chosen_names(only: list[str] | None) -> list[str]:
    """Give the figures to render.

    Raises:
        InputError: a name is no figure's; the message proposes the nearest.
    """
    names = figure_names()
    for name in only or ():
        if name not in names:
            near = difflib.get_close_matches(name, names, n=3, cutoff=0.3) or names
            raise InputError(f"--only {name}: no such figure; did you mean {', '.join(near)}?")
    return [n for n in names if not only or n in only]


def prepare_folder(out: Path) -> None:
    """Make the output folder; InputError if it is a file, or cannot be made."""
    if out.exists() and not out.is_dir():
        raise InputError(f"{out}: is a file; name a folder for the figures")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"{out}: cannot be made ({error.strerror}); name another folder"
        ) from error


def _metadata(scene: Scene, renderer: str) -> dict[str, str]:
    return frame_metadata(scene, "rtbow figures", "spectral", renderer)


def _kept(path: Path, scene: Scene) -> Float32 | None:
    """Give a frame of an earlier run, if it is whole and of this scene, size and version."""
    if not path.is_file():
        return None
    try:
        rgb, texts = read_exr(path)
    except RtbowError:
        return None
    width, height = scene.camera.size_px
    same = texts.get("scene") == scene.source_text and texts.get("rtbowVersion") == __version__
    return rgb if same and rgb.shape[:2] == (height, width) else None


def render_figures(
    out: Path,
    names: list[str],
    size: tuple[int, int],
    backend: Backend = "auto",
    progress: Callable[[str], Progress] = lambda _: no_progress,
) -> dict[str, Frame]:
    """Render figures, and write each as ``.exr`` as soon as it is done; finished ones are kept.

    Args:
        out: the folder.
        names: the figures to render; others are taken along if an earlier run has left them.
        size: width and height in pixels.
        backend: how to get a GL context.
        progress: gives, for a figure's name, the wrapper of its loop over rows.

    Returns:
        The frames by name.
    """
    frames: dict[str, Frame] = {}
    for name in figure_names():
        scene = load_scene(PREFIX + name, {"camera.size_px": list(size)})
        path = out / f"{name}.exr"
        rgb = _kept(path, scene)
        if rgb is None and name in names:
            # Two figures may show one scene.
            same = next((frame for frame in frames.values() if frame.scene == scene), None)
            if same is not None:
                rgb, device = same.rgb.astype("f4"), "as another figure"
            else:
                with Renderer(scene, backend) as renderer:
                    rgb, device = renderer.render("spectral", progress(name)), renderer.gl_renderer
            write_exr(path, rgb, _metadata(scene, device))
        if rgb is not None:
            frames[name] = Frame(scene, floats(rgb))
    return frames


def exposures(frames: dict[str, Frame]) -> dict[str, float]:
    """Give the exposure value (ISO 100) of each figure.

    The pictures of figure 8 compare brightness: all have the value of the first that is there, of
    the highest sun. Every other figure has its own.
    """
    eighth = [n for n in frames if n.startswith("fig8")]
    return {
        name: auto_exposure_ev(frames[eighth[0]].rgb if name in eighth else frame.rgb)
        for name, frame in frames.items()
    }


def make_figures(
    out: Path,
    only: list[str] | None = None,
    size: tuple[int, int] = DEFAULT_SIZE,
    backend: Backend = "auto",
    progress: Callable[[str], Progress] = lambda _: no_progress,
) -> list[Verdict]:
    """Render the paper's figures, measure its claims and write a page about them.

    Args:
        out: the folder, which is made if it is missing.
        only: names such as ``fig5f``; all by default.
        size: width and height in pixels.
        backend: how to get a GL context.
        progress: gives, for a figure's name, the wrapper of its loop over rows.

    Returns:
        The verdicts on all claims.

    Raises:
        InputError: a name is no figure's, or the folder cannot be written.
    """
    from rtbow.study.page import write_page

    names = chosen_names(only)
    prepare_folder(out)
    frames = render_figures(out, names, size, backend, progress)
    shown = exposures(frames)
    for name, frame in frames.items():
        texts = _metadata(frame.scene, "")
        write_frame(out / f"{name}.png", frame.rgb.astype("f4"), texts, shown[name])
    verdicts = judge(frames)
    write_atomic(out / "figures.json", json.dumps(_rows(verdicts), indent=2).encode())
    write_page(out, frames, verdicts)
    return verdicts


def _rows(verdicts: list[Verdict]) -> list[dict[str, object]]:
    return [
        {
            "figure": v.claim.figure,
            "text": v.claim.text,
            "scenes": list(v.claim.needs),
            "measured": v.numbers,
            "holds": v.holds,
            "note": v.claim.note,
        }
        for v in verdicts
    ]
