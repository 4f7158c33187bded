"""Standard input and output, the shell's Tab, and surroundings that lack what programs rely on."""

from __future__ import annotations

import io
import os
import subprocess
import sys

import numpy as np
import pytest
from click.shell_completion import ShellComplete
from PIL import Image

import rtbow.cli.main
from checkout import ROOT
from command_line import FAST, SMALL, assert_refused, contents
from rtbow.frames.image import read_exr
from scene_samples import UNIFORM


@pytest.fixture
def run(tmp_path):
    """Run the command line as a process of its own; bytes in and out."""

    def start(*args: str, **options) -> subprocess.CompletedProcess[bytes]:
        options.setdefault("cwd", tmp_path)
        env = {**os.environ, "PYTHONPATH": str(ROOT), **options.pop("env", {})}
        command = [sys.executable, "-m", "rtbow", *args]
        return subprocess.run(command, env=env, capture_output=True, timeout=240, **options)

    return start


def typed(monkeypatch, content: bytes) -> None:
    """Have the command line find this on standard input."""
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(content)))


@pytest.mark.slow
def test_a_picture_to_a_program(run, tmp_path):
    """Nothing but the picture goes to standard output; notes and names go beside it."""
    done = run("render", "uniform", *SMALL, "-o", "-", "-o", "bow.exr")
    assert done.returncode == 0
    with Image.open(io.BytesIO(done.stdout)) as image:
        assert (image.format, image.size) == ("PNG", (32, 18))
        assert image.text["method"] == "fast"
    name, said = done.stderr.decode().split("\n", 1)
    assert name == "bow.exr"
    assert said == FAST

    exr = run("render", "-", *SMALL, "-o", "-", "--format", "exr", "-q", input=UNIFORM.encode())
    assert (exr.returncode, exr.stderr) == (0, b"")
    (tmp_path / "piped.exr").write_bytes(exr.stdout)
    piped, texts = read_exr(tmp_path / "piped.exr")
    np.testing.assert_array_equal(piped, read_exr(tmp_path / "bow.exr")[0])
    assert texts["scene"].startswith(UNIFORM)


@pytest.mark.usefixtures("no_rendering")
class TestRefused:
    def test_a_terminal(self, call, tmp_path, monkeypatch):
        monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
        result = call("render", "uniform", "-o", "-")
        assert_refused(result, "-o -: standard output is a terminal", "| magick png:- ")

    def test_a_format_of_files(self, call, tmp_path):
        result = call("render", "uniform", "-o", "a.png", "--format", "exr")
        assert_refused(result, "--format exr goes with -o -", "that of its name")
        assert_refused(call("render", "uniform", "-o", "-", "--format", "jpg"), "'png', 'exr'")
        assert contents(tmp_path) == {}

    def test_twice(self, call):
        assert_refused(call("render", "-o", "-", "-o", "-"), "-o -: is given twice")

    @pytest.mark.parametrize(
        ("content", "words"),
        [
            (b"[camera\n", "<stdin>: not valid TOML"),
            (b"[camera]\nfov_deg = 1\xff\n", "<stdin>: line 2: is not UTF-8 text"),
            (UNIFORM.encode() + b"\n[render]\nsteps = 0\n", "<stdin>: line "),
            (b'droplets = {file = "no.npz"}\n[[light]]\n[camera]\nfov_deg = 0', "<stdin>: line 4"),
        ],
    )
    def test_what_is_no_scene(self, call, monkeypatch, content, words):
        typed(monkeypatch, content)
        assert_refused(call("render", "-", "-o", "a.png"), words)

    def test_a_closed_input(self, call, monkeypatch):
        monkeypatch.setattr(sys, "stdin", None)
        assert_refused(call("render", "-", "-o", "a.png"), "<stdin>: is closed; send a scene")


def test_paths_on_standard_input_start_at_the_current_folder(call, tmp_path, monkeypatch):
    typed(monkeypatch, b'[[light]]\n[droplets]\nfile = "rain.npz"\n')
    result = call("render", "-", "-o", "a.png")
    assert_refused(
        result, "<stdin>: line 3: droplets.file", str(tmp_path / "rain.npz"), "not found"
    )


class TestCompletion:
    def proposed(self, *words: str) -> list[str]:
        shell = ShellComplete(rtbow.cli.main.rtbow, {}, "rtbow", "_RTBOW_COMPLETE")
        return [item.value for item in shell.get_completions(list(words[:-1]), words[-1])]

    @pytest.mark.parametrize("verb", ["render", "view", "animate", "bench"])
    def test_scenes(self, tmp_path, monkeypatch, verb):
        monkeypatch.chdir(tmp_path)
        for name in ("shade.toml", "shot.png", "shapes/a.toml", "shapes/b.txt", ".shy.toml"):
            (tmp_path / name).parent.mkdir(exist_ok=True)
            (tmp_path / name).touch()
        assert self.proposed(verb, "sh") == ["shower", "shade.toml", f"shapes{os.sep}"]
        assert self.proposed(verb, "shapes/") == ["shapes/a.toml"]
        assert self.proposed(verb, "figures/fig9a") == ["figures/fig9a"]
        assert self.proposed(verb, "no/such/") == []
        assert self.proposed(verb, ".s") == [".shy.toml"]

    def test_frames_and_scenes(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        for name in ("shade.toml", "shot.png", "shy.exr"):
            (tmp_path / name).touch()
        assert self.proposed("measure", "sh") == ["shower", "shade.toml", "shy.exr"]

    def test_options_and_choices(self):
        assert self.proposed("render", "uniform", "--meth") == ["--method"]
        assert self.proposed("render", "uniform", "--method", "s") == ["spectral"]


@pytest.mark.slow
class TestSurroundings:
    def test_a_current_folder_that_was_deleted(self, run, tmp_path):
        gone = tmp_path / "gone"
        gone.mkdir()
        leaving = {"cwd": gone, "preexec_fn": lambda: os.rmdir(gone)}
        done = run("render", "uniform", *SMALL, "-q", "-o", str(tmp_path / "a.exr"), **leaving)
        assert (done.returncode, done.stderr) == (0, b"")
        assert (tmp_path / "a.exr").exists()
        gone.mkdir()
        done = run("render", "uniform", *SMALL, "-q", "-o", "a.exr", **leaving)
        assert done.returncode == 2
        assert done.stderr.decode() == (
            "rtbow: a.exr: starts at the current folder, which was deleted; change to another"
            " folder (cd), or give the path from the root on\n"
        )

    def test_no_home(self, run, tmp_path):
        """Matplotlib, which colour-science imports, and Mesa miss it, and say nothing."""
        env = {
            "HOME": "/proc/no/home",  # where not even the superuser makes folders
            "XDG_CACHE_HOME": "",
            "XDG_CONFIG_HOME": "",
            "RTBOW_CACHE_DIR": "/proc/no/cache",
        }
        done = run("render", "uniform", *SMALL, "-q", "-o", "a.png", env=env)
        assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")
        code = "from rtbow.frames.plot import new_figure, style\nwith style(): new_figure(1, 1)"
        command = [sys.executable, "-c", code]
        env = {**os.environ, "PYTHONPATH": str(ROOT), **env}
        done = subprocess.run(command, env=env, capture_output=True, timeout=240)
        assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")
