"""The page on the paper's figures: plots, and HTML that opens from disk."""

from __future__ import annotations

import html
from pathlib import Path

import numpy as np

from rtbow.base.files import write_atomic
from rtbow.base.version import __version__
from rtbow.frames import measures
from rtbow.frames.measures import Profile
from rtbow.frames.plot import new_figure, save
from rtbow.scene.text.file import builtin_scenes, scene_title
from rtbow.study.claims import Frame, Verdict, sun_profile
from rtbow.world.lights import lamps, suns
from rtbow.world.measured.spectra import load_spectrum

SPECTRA = (("equal-energy", "equal energy"), ("E490", "sun, ASTM E-490"), ("FL1", "lamp, CIE FL1"))


_DPI = 80


def profile_of(frame: Frame) -> tuple[Profile, str]:
    """Give a frame's angle profile, and the name of the point that angles are measured from."""
    if suns(frame.scene):
        return sun_profile(frame), "antisolar point"
    camera = frame.scene.camera
    # Opposite to the lamp, as seen from the eye: where the lamp casts the eye's shadow.
    away = np.array(camera.position_m) - lamps(frame.scene)[0].position_m
    angle = measures.angle_from(camera, away / np.linalg.norm(away))
    return measures.radial_profile(frame.rgb, angle, camera.fov_deg / camera.size_px[0]), (
        "point opposite to the lamp"
    )


def plot_profile(frame: Frame, path: Path) -> None:
    """Plot a frame's luminance and chromaticity against the angle (:func:`profile_of`)."""
    profile, origin = profile_of(frame)
    lit = profile.luminance > 1e-4 * profile.luminance.max()
    figure = new_figure(6.0, 4.4)
    above, below = figure.subplots(2, 1, sharex=True)
    above.plot(profile.angle_deg, profile.luminance, color="black", lw=1.2)
    above.set_ylabel("luminance, cd/m²")
    uv = measures.chromaticity(profile.xyz)
    for k, (label, colour) in enumerate((("u'", "tab:red"), ("v'", "tab:blue"))):
        values = np.where(lit, uv[:, k], np.nan)
        below.plot(profile.angle_deg, values, color=colour, lw=1.0, label=label)
    below.set_ylim(0.1, 0.6)
    below.set_ylabel("chromaticity")
    below.set_xlabel(f"angle from the {origin}, degrees")
    below.legend(loc="lower right")
    save(figure, path, _DPI)


def plot_spectra(path: Path) -> None:
    """Plot figure 6: the three spectra, with equal areas over 380-780 nm."""
    nm = np.arange(380.0, 780.5, 1.0)
    figure = new_figure(10.0, 2.8)
    axes = figure.subplots(1, 3, sharex=True)
    for axis, (name, title) in zip(axes, SPECTRA, strict=True):
        spectrum = load_spectrum(name)
        value = np.interp(nm, spectrum.wavelength_nm, spectrum.value) / spectrum.visible * 400.0
        axis.plot(nm, value, color="black", lw=1.0)
        axis.set_title(title)
        axis.set_ylim(0.0, None)
        axis.set_xlabel("wavelength, nm")
    axes[0].set_ylabel("relative power per nm")
    save(figure, path, _DPI)


_STYLE = """body{font:16px/1.5 system-ui,sans-serif;max-width:64rem;margin:2rem auto;padding:0 1rem;
color:#222;background:#fff}h2{border-top:1px solid #ccc;padding-top:1rem;margin-top:2.5rem}
.scenes{display:flex;flex-wrap:wrap;gap:1rem}.scenes figure{margin:0;width:480px;max-width:100%}
.scenes img{width:100%}figcaption{font-size:.9rem;color:#555}
.claim{border-left:4px solid #999;padding:.2rem 1rem;margin:1rem 0}.holds{border-color:#2a7}
.fails{border-color:#c52}.claim p{margin:.3rem 0}.numbers{font:.85rem/1.4 ui-monospace,monospace;
color:#444}.note{color:#555;font-size:.95rem}"""


def _claim(verdict: Verdict) -> str:
    state, mark = {
        True: ("holds", "holds"),
        False: ("does not hold", "fails"),
        None: ("not measured: a picture is missing", ""),
    }[verdict.holds]
    numbers = " &nbsp; ".join(
        f"{html.escape(name)} = {value:.4g}" for name, value in verdict.numbers.items()
    )
    note = f'<p class="note">{html.escape(verdict.claim.note)}</p>' if verdict.claim.note else ""
    return (
        f'<div class="claim {mark}"><p>The paper: {html.escape(verdict.claim.text)}'
        f" <strong>{state}</strong>.</p>"
        f'<p class="numbers">{numbers}</p>{note}</div>'
    )


def _scene(name: str, title: str) -> str:
    return (
        f'<figure><img src="{name}.png" alt="{html.escape(title)}">'
        f'<img src="{name}-profile.png" alt="profile of {name}">'
        f"<figcaption><b>{name}</b>: {html.escape(title)}</figcaption></figure>"
    )


def write_page(out: Path, frames: dict[str, Frame], verdicts: list[Verdict]) -> None:
    """Write the profiles, figure 6 and ``index.html`` into a folder.

    Args:
        out: the folder, which holds the pictures, such as ``fig5a.png``.
        frames: the frames by name.
        verdicts: the verdicts on the claims.
    """
    for name, frame in frames.items():
        plot_profile(frame, out / f"{name}-profile.png")
    plot_spectra(out / "fig6.png")
    titles = {n.removeprefix("figures/"): scene_title(p) for n, p in builtin_scenes().items()}
    parts = [
        "<!doctype html><html lang=en><meta charset=utf-8>"
        f"<title>rtbow: the paper's figures</title><style>{_STYLE}</style>"
        "<h1>The paper's figures, measured</h1>"
        "<p>Fujiwara, Tamaki, Kaneda: Realistic Rainbow Rendering Considering Light Attenuation"
        " due to Scattering and Absorption in the Atmosphere. Made by <code>rtbow figures</code>,"
        f" rtbow {__version__}. Numbers in full: <a href=figures.json>figures.json</a>; radiance:"
        " the .exr files that the command writes beside this page.</p>"
    ]
    for figure in ("1", "5", "6", "7", "8", "9"):
        parts.append(f"<h2>Figure {figure}</h2>")
        if figure == "6":
            parts.append('<img src="fig6.png" alt="the three spectra" style="max-width:100%">')
        parts += [_claim(verdict) for verdict in verdicts if verdict.claim.figure == figure]
        scenes = [_scene(n, titles[n]) for n in frames if n.startswith(f"fig{figure}")]
        parts.append(f'<div class="scenes">{"".join(scenes)}</div>')
    write_atomic(out / "index.html", "".join(parts).encode())
