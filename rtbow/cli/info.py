"""The verb ``rtbow info``: what this machine offers, or what was understood of an input."""

from __future__ import annotations

from pathlib import Path

import click

from rtbow.base.errors import InputError
from rtbow.base.version import __version__


@click.command()
@click.argument("subject", metavar="[SCENE|SPECTRUM]", required=False)
@click.option("-o", "--output", metavar="OUT", help="Draw the spectrum, too: .png or .svg.")
def info(subject: str | None, output: str | None) -> None:
    """Show the GL backends that work here, versions and the cache; or describe an input.

    SCENE: the number, liquid water, rain rate and size of its drops, their extinction and optical
    depth, and each light.

    SPECTRUM is a name, such as FL2, or a file, such as lamp.csv, or lamp.csv#3 for its third
    column: what was understood of it, its colour and its strength are shown.

    \b
    Examples:
      rtbow info fogbow
      rtbow info lamp.csv -o lamp.png
    """
    if subject is None:
        if output is not None:
            raise InputError(f"-o {output}: there is nothing to draw; name a spectrum or its file")
        _show_machine()
    elif _is_scene(subject):
        _show_scene(subject, output)
    elif subject.lower().endswith(".npz"):
        raise InputError(
            f"{subject}: a volume is described with the scene that takes it: name it there as"
            " droplets.file, and use rtbow info on the scene"
        )
    elif subject == "-":
        raise InputError("-: render alone reads a scene from standard input; name a file here")
    else:
        _show_spectrum(subject, output)


def _is_scene(subject: str) -> bool:
    """Whether a subject is a scene; what is a spectrum's name, too, is that."""
    from rtbow.scene.text.file import builtin_scenes, is_scene_name

    if not is_scene_name(subject):
        return False
    if subject.lower().endswith(".toml") or subject in builtin_scenes():
        return True
    from rtbow.world.measured.spectra import spectrum_names

    return subject not in spectrum_names()


def _show_scene(subject: str, output: str | None) -> None:
    from rtbow.scene.text.file import load_scene
    from rtbow.world.report import scene_report

    if output is not None:
        raise InputError(
            f"-o {output}: of a scene there is nothing to draw here; use rtbow render {subject}"
            f" -o {output}"
        )
    click.echo(scene_report(load_scene(subject)))


def _check_known(subject: str) -> None:
    """Refuse a name that is nearer to a scene's than to a spectrum's."""
    if Path(subject).exists():
        return
    import difflib

    from rtbow.scene.text.file import builtin_scenes
    from rtbow.world.measured.spectra import spectrum_names

    scenes = builtin_scenes()
    near = difflib.get_close_matches(subject, [*scenes, *spectrum_names()], n=1, cutoff=0.7)
    if near and near[0] in scenes:
        raise InputError(f"{subject} is no scene, spectrum or file; did you mean {near[0]}?")


def _show_spectrum(subject: str, output: str | None) -> None:
    _check_known(subject)
    from rtbow.base.files import check_writable
    from rtbow.frames.plot import PLOT_SUFFIXES
    from rtbow.study.spectra import describe, draw_spectrum

    if output is not None:
        check_writable(output, PLOT_SUFFIXES)
    description = describe(subject)
    for label, text in description.lines:
        click.echo(f"{label + ':':<14}{text}")
    for note in description.notes:
        click.echo(f"note: {note}", err=True)
    if output is not None:
        draw_spectrum(Path(output), description)
        click.echo(output)


def _show_machine() -> None:
    import platform
    from importlib.metadata import version

    from rtbow.base.cache import cache_dir, cache_size
    from rtbow.gl.context import probe_backends

    click.echo(f"rtbow {__version__}, Python {platform.python_version()}, {platform.platform()}")
    for report in probe_backends():
        if report.ok:
            click.echo(f"{report.backend:<8}works: {report.renderer}, OpenGL {report.version}")
        else:
            click.echo(f"{report.backend:<8}does not work: {report.reason}")
            if report.help:
                click.echo(f"{'':<8}{report.help}")
    names = ("moderngl", "glfw", "numpy", "scipy", "numba", "colour-science", "OpenEXR")
    click.echo("packages: " + ", ".join(f"{name} {version(name)}" for name in names))
    click.echo(f"cache: {cache_dir()}, {cache_size() / 2**20:.1f} MiB")
