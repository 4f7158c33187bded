"""``rtbow view`` as a command: scripts, files that it watches, and how it ends."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

import rtbow
import rtbow.frames.image
import rtbow.scene.text.file
from rtbow.scene.text.file import load_scene
from screen import PROCESSES, virtual_screen

pytestmark = pytest.mark.slow

SIZE = (320, 180)
WINDOW = (SIZE[0] + 340, 600)
PATIENCE_S = 120.0


# --- From the command line ----------------------------------------------------------------------


def view(*words: str, timeout: float = PATIENCE_S, **env: str) -> subprocess.CompletedProcess[str]:
    # No window offers what another has left: there are no unsaved scenes where there is no folder.
    whole = {**os.environ, "XDG_DATA_HOME": os.devnull, **env}
    whole = {k: v for k, v in whole.items() if v}
    return subprocess.run(
        [sys.executable, "-m", "rtbow", "view", *words],
        capture_output=True, text=True, timeout=timeout, env=whole,
    )  # fmt: skip


def test_a_script_takes_a_screenshot(screen, tmp_path):
    path = tmp_path / "a.png"
    result = view(
        "curtain", "--size", "320x180", "--frames", "3", "--screenshot", str(path), DISPLAY=screen
    )
    assert result.returncode == 0, result.stderr
    assert result.stderr == ""
    from PIL import Image

    assert Image.open(path).size == (640 + 340, 600)


def test_pictures_are_counted_though_nothing_changes(screen):
    result = view("uniform", "--size", "64x36", "--frames", "150", DISPLAY=screen)
    assert result.returncode == 0, result.stderr
    assert result.stderr == ""


def test_a_script_learns_that_the_scene_cannot_be_drawn(screen, tmp_path):
    path = tmp_path / "a.png"
    words = ("uniform", "--size", "64x36", "--method", "fast", "--max-delta-e", "1e-6")
    result = view(*words, "--frames", "3", "--screenshot", str(path), DISPLAY=screen)
    assert result.returncode == 2, result.stderr
    assert "max_delta_e" in result.stderr
    assert "Traceback" not in result.stderr
    assert not path.exists()


def test_options_that_contradict_are_told(screen):
    words = ("uniform", "--method", "spectral", "--max-delta-e", "1")
    result = view(*words, DISPLAY=screen)
    assert result.returncode == 2
    assert "leave one of the two out" in result.stderr


def test_without_a_display_it_says_what_to_do():
    result = view("uniform", DISPLAY="", WAYLAND_DISPLAY="")
    assert result.returncode == 3
    assert "rtbow render" in result.stderr
    assert "Traceback" not in result.stderr


def test_an_old_driver_is_told(screen):
    result = view("uniform", DISPLAY=screen, MESA_GL_VERSION_OVERRIDE="3.0")
    assert result.returncode == 3
    assert "3.3" in result.stderr


def test_a_wrong_scene_or_file_is_told_before_the_window_opens(screen):
    assert view("nothing", DISPLAY=screen).returncode == 2
    result = view("uniform", "--screenshot", "a.gif", DISPLAY=screen)
    assert result.returncode == 2
    assert ".png" in result.stderr


WATCHED = """
import sys, time
from pathlib import Path
from rtbow.scene.text.file import load_scene
from rtbow.view.app import Viewer
from rtbow.view.document.edits import Opened

def main():
    scene, shader = Path(sys.argv[1]), Path(sys.argv[2])
    viewer = Viewer(Opened(load_scene(scene), str(scene)), watch=True)

    def until(condition):
        end = time.monotonic() + 120
        while not condition() and time.monotonic() < end:
            viewer.step()
        return condition()

    text = scene.read_text()
    print(until(lambda: viewer.settled))
    scene.write_text(text.replace("altitude_deg = 42.0", "altitude_deg = 30.0"))
    print(until(lambda: viewer.edits.scene.light[0].altitude_deg == 30.0 and viewer.settled))
    scene.write_text(text.replace("altitude_deg = 42.0", "altitude_deg = 420.0"))
    print(until(lambda: "altitude_deg = 420" in viewer.state.stale))
    print(viewer.edits.scene.light[0].altitude_deg, viewer.frame_rgb.max() > 0.0)
    scene.write_text(text)
    print(until(lambda: not viewer.state.stale and viewer.settled))
    scene.write_text(text.replace("altitude_deg = 42.0", "altitude_deg = 421.0"))
    print(until(lambda: "altitude_deg = 421" in viewer.state.stale))
    camera = viewer.edits.scene.camera
    viewer.steering.aim(camera.model_copy(update={"azimuth_deg": 5.0}), "camera")
    print(until(lambda: viewer.settled), "altitude_deg = 421" in viewer.state.stale)
    viewer.undo()
    scene.write_text(text)
    print(until(lambda: not viewer.state.stale and viewer.settled))
    scene.unlink()
    print(until(lambda: "there is no such file" in viewer.state.stale))
    viewer.save_scene(str(scene))
    print(until(lambda: not viewer.state.stale))
    scene.write_text(text)
    print(until(lambda: viewer.settled))
    own = shader.parents[2] / "display" / "picture.frag"
    whole = own.read_text()
    own.write_text(whole.replace("void main()", "void man()"))
    print(until(lambda: "picture.frag" in viewer.state.stale or "main" in viewer.state.stale))
    own.write_text(whole)
    print(until(lambda: not viewer.state.stale))
    spectrum = scene.with_name("lamp.csv")
    spectrum.write_text("380,1\\n780,1\\n")
    viewer.change({"light.0.spectrum": str(spectrum)})
    print(until(lambda: viewer.settled))


    def redness():
        red, _, blue = viewer.frame_rgb.sum(axis=(0, 1))
        return red / blue

    before = redness()
    spectrum.write_text("380,1\\n780,9\\n")
    print(until(lambda: redness() > 1.5 * before))
    viewer.undo()
    until(lambda: viewer.settled)
    whole = shader.read_text()
    shader.write_text(whole.replace("radiance.rgb = ", "radiance.rgb = wrong + "))
    print(until(lambda: "fast/sun/pixel.frag" in viewer.state.stale))
    print(viewer.state.stale)
    shader.write_text(whole.replace("radiance.rgb = ", "radiance.rgb = 2.0 * "))
    before = float(viewer.frame_rgb.max())
    print(until(lambda: not viewer.state.stale and viewer.settled))
    print(round(float(viewer.frame_rgb.max()) / before, 3))
    viewer.close()

if __name__ == "__main__":
    main()
"""

SCENE = """
[camera]
size_px = [160, 90]
[[light]]
altitude_deg = 42.0
[droplets]
box_m = [[-200.0, 100.0, 0.0], [200.0, 300.0, 200.0]]
radius = { distribution = "constant", radius_um = 300.0 }
density = { number_per_m3 = 1000.0 }
"""


def test_changed_files_are_taken_over_and_mistakes_told(screen, tmp_path):
    # In a copy of the project: its shaders are changed.
    root = Path(rtbow.__file__).parents[1]
    for name in ("rtbow", "shaders", "scenes"):
        shutil.copytree(root / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(root / "pyproject.toml", tmp_path)
    scene, driver = tmp_path / "mine.toml", tmp_path / "driver.py"
    scene.write_text(SCENE)
    driver.write_text(textwrap.dedent(WATCHED))
    result = subprocess.run(
        [sys.executable, str(driver), str(scene), str(tmp_path / "shaders/fast/sun/pixel.frag")],
        capture_output=True, text=True, timeout=280, cwd=tmp_path,
        env={**os.environ, "DISPLAY": screen, "PYTHONPATH": str(tmp_path)},
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    lines = result.stdout.splitlines()
    assert lines[:3] == ["True"] * 3, result.stdout
    assert lines[3] == "30.0 True"
    assert lines[4:6] == ["True"] * 2, result.stdout
    assert lines[6] == "True True", result.stdout
    assert lines[7:15] == ["True"] * 8, result.stdout
    assert any("fast/sun/pixel.frag:" in line and "wrong" in line for line in lines), result.stdout
    assert lines[-2:] == ["True", "2.0"], result.stdout


BUILT_IN = """
import sys, time
from rtbow.base.resources import resource_dir
from rtbow.scene.text.file import builtin_scenes, load_scene
from rtbow.view.app import Viewer
from rtbow.view.document.edits import Opened

def main():
    viewer = Viewer(Opened(load_scene("uniform"), "uniform"), watch=True)
    file = builtin_scenes()["uniform"]
    end = time.monotonic() + 60
    before = viewer.edits.scene
    file.write_text(file.read_text() + "\\n[render]\\nmax_delta_e = 0.7\\n")
    while viewer.edits.scene is before and time.monotonic() < end:
        viewer.step()
    print(viewer.edits.scene.render.max_delta_e)
    viewer.close()

if __name__ == "__main__":
    main()
"""


def test_built_in_scenes_are_followed_too(screen, tmp_path):
    root = Path(rtbow.__file__).parents[1]
    for name in ("rtbow", "shaders", "scenes"):
        shutil.copytree(root / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(root / "pyproject.toml", tmp_path)
    driver = tmp_path / "driver.py"
    driver.write_text(BUILT_IN)
    result = subprocess.run(
        [sys.executable, str(driver)], capture_output=True, text=True, timeout=PATIENCE_S,
        cwd=tmp_path, env={**os.environ, "DISPLAY": screen, "PYTHONPATH": str(tmp_path)},
    )  # fmt: skip
    assert result.stdout == "0.7\n", result.stderr


# --- The end ------------------------------------------------------------------------------------

ACTING = """
import os, sys
from pathlib import Path
from rtbow.base.errors import UnavailableError
from rtbow.view import app
from rtbow.view.document import autosave
from rtbow.view.window import system as window

def act(viewer, frames=None, screenshot=None):
    def until(condition):
        while not condition():
            viewer.step()

    def lost(self):
        raise UnavailableError("the context is lost")

    ACT

app.Viewer.run = act
if __name__ == "__main__":
    sys.argv = ["rtbow", "view", SCENE, "--size", "64x36"]
    from rtbow.cli.main import main
    main()
"""


def acted(
    screen: str, folder: Path, act: str, scene: str = "uniform", **env: str
) -> subprocess.CompletedProcess[str]:
    """Run rtbow view with something else than its loop."""
    script = folder / "act.py"
    act = textwrap.indent(textwrap.dedent(act), "    ").strip()
    script.write_text(ACTING.replace("ACT", act, 1).replace("SCENE", repr(scene)))
    return subprocess.run(
        [sys.executable, str(script)], capture_output=True, text=True, timeout=PATIENCE_S,
        cwd=folder,
        env={**os.environ, "DISPLAY": screen, "XDG_DATA_HOME": str(folder / "data"), **env},
    )  # fmt: skip


def unsaved(folder: Path, stem: str = "*") -> list[Path]:
    """The files that hold what was not saved of a scene."""
    return list((folder / "data" / "rtbow" / "unsaved").glob(f"{stem}-*.toml"))


BREAKS = """
viewer.change({"light.0.altitude_deg": 3.0})
window.Window.show = lost
until(lambda: False)
"""


def test_changes_are_kept_when_something_breaks_and_offered_next_time(screen, tmp_path):
    result = acted(screen, tmp_path, BREAKS)
    assert result.returncode == 3, result.stderr
    (kept,) = unsaved(tmp_path, "uniform")
    assert f"unsaved changes are in {kept}" in result.stderr
    assert "the context is lost" in result.stderr
    assert load_scene(kept).light[0].altitude_deg == 3.0
    act = """
    offered = viewer.state.recent
    print(len(offered), [notice.text for notice in viewer.state.notices])
    viewer.open_scene(offered[0])
    scene = viewer.edits.scene
    print(viewer.edits.opened.name, scene.light[0].altitude_deg, viewer.state.recent)
    viewer.undo()
    print(viewer.edits.changes)
    """
    result = acted(screen, tmp_path, act, "red-sun")
    assert result.stdout.splitlines() == [
        "1 ['changes that were not saved are listed under Scenes']",
        "uniform 3.0 ['uniform']",
        "{}",
    ], result.stderr
    assert not unsaved(tmp_path)


def test_a_recovery_that_fails_hides_nothing(screen, tmp_path):
    fails = """
    def fails(*_):
        raise ZeroDivisionError("of ours")

    autosave.file_text = fails
    """
    result = acted(screen, tmp_path, textwrap.dedent(fails) + BREAKS)
    assert result.returncode == 3, result.stderr
    assert "the context is lost" in result.stderr
    assert "could not be kept: of ours" in result.stderr
    assert "rtbow view uniform --set" in result.stderr
    assert "light.0.altitude_deg=3.0" in result.stderr
    assert not unsaved(tmp_path)


def test_quitting_keeps_what_was_not_saved(screen, tmp_path):
    quits = """
    viewer.change({"light.0.altitude_deg": 3.0})
    viewer.open_scene("red-sun")
    viewer.change({"light.0.altitude_deg": 4.0})
    viewer.open_scene("mine.toml")
    viewer.steering.aim(viewer.edits.scene.camera.model_copy(update={"fov_deg": 33.0}), "camera")
    viewer.step()
    """
    shutil.copy(rtbow.scene.text.file.builtin_scenes()["street-lamp"], tmp_path / "mine.toml")
    result = acted(screen, tmp_path, quits)
    assert result.returncode == 0, result.stderr
    for stem, altitude_deg in (("uniform", 3.0), ("red-sun", 4.0)):
        (kept,) = unsaved(tmp_path, stem)
        assert load_scene(kept).light[0].altitude_deg == altitude_deg
        assert f"unsaved changes are in {kept}" in result.stderr
    # Where the camera looks is one line, and no file.
    assert "rtbow view mine.toml --set camera.fov_deg=33.0" in result.stderr
    assert len(unsaved(tmp_path)) == 2


def test_quitting_without_changes_leaves_nothing(screen, tmp_path):
    result = acted(screen, tmp_path, "until(lambda: viewer.settled)")
    assert (result.returncode, result.stderr, result.stdout) == (0, "", "")
    assert [path.name for path in tmp_path.iterdir()] == ["act.py"]


def test_what_was_changed_is_kept_though_its_scene_has_gone(screen, tmp_path):
    folder = tmp_path / "away"
    folder.mkdir()
    shutil.copy(rtbow.scene.text.file.builtin_scenes()["uniform"], folder / "mine.toml")
    act = """
    import shutil
    viewer.change({"light.0.altitude_deg": 3.0})
    shutil.rmtree("away")
    """
    result = acted(screen, tmp_path, act, "away/mine.toml")
    assert result.returncode == 0, result.stderr
    (kept,) = unsaved(tmp_path, "mine")
    assert load_scene(kept).light[0].altitude_deg == 3.0
    act = """
    viewer.open_scene(viewer.state.recent[0])
    print(viewer.edits.opened.name, viewer.edits.scene.light[0].altitude_deg, viewer.state.stale)
    """
    result = acted(screen, tmp_path, act)
    assert result.stdout == "None 3.0 \n", result.stderr
    assert len(unsaved(tmp_path)) == 1


def test_a_display_that_is_lost_takes_no_changes_with_it(tmp_path):
    act = """
    folder = Path(os.environ["XDG_DATA_HOME"], "rtbow", "unsaved")
    viewer.change({"light.0.altitude_deg": 3.0})
    until(lambda: list(folder.glob("uniform-*.toml")))
    print("kept", flush=True)
    os.kill(int(os.environ["SCREEN"]), 15)
    until(lambda: False)
    """
    with virtual_screen(900, 700) as name:
        result = acted(name, tmp_path, act, SCREEN=str(PROCESSES[name]))
    assert result.stdout == "kept\n"
    assert result.returncode != 0
    (kept,) = unsaved(tmp_path, "uniform")
    assert load_scene(kept).light[0].altitude_deg == 3.0


def test_what_is_being_saved_is_saved_before_the_end(screen, tmp_path):
    result = acted(screen, tmp_path, 'viewer.save_frame(("a.exr", "a.png"))')
    assert result.returncode == 0, result.stderr
    assert result.stderr == "saving a.exr, a.png; Ctrl-C gives it up\nsaved a.exr, a.png\n"
    assert (tmp_path / "a.exr").is_file()
    assert (tmp_path / "a.png").is_file()
    result = acted(screen, tmp_path, 'viewer.save_frame(("no/a.exr",))')
    assert result.returncode == 2, result.stderr
    assert "mkdir -p" in result.stderr
