"""Messages between the window and the process that renders for it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from rtbow.base.arrays import Array, Float32
from rtbow.base.errors import InputError, RtbowError, UnavailableError

if TYPE_CHECKING:
    from rtbow.render.renderer import MethodName
    from rtbow.scene.model import Scene


@dataclass(frozen=True)
class DrawFrame:
    """Draw a frame to look at; of several that wait only the last is drawn."""

    number: int
    scene: Scene
    method: MethodName


@dataclass(frozen=True)
class SaveFrame:
    """Render a frame and write it to files."""

    number: int
    scene: Scene
    method: MethodName
    paths: tuple[str, ...]
    exposure_ev: float | None
    command: str


@dataclass(frozen=True)
class TakeSpectrum:
    """Compute the spectral radiance along a direction by the reference; the last that waits."""

    number: int
    scene: Scene
    direction: tuple[float, float, float]


@dataclass(frozen=True)
class Reload:
    """Forget programs and tables: shaders or files have changed. It has no reply."""

    number: int


Request = DrawFrame | SaveFrame | TakeSpectrum | Reload


@dataclass(frozen=True)
class FrameDrawn:
    """A frame is done.

    Attributes:
        number: of its request.
        scene: what it shows.
        rgb: linear Rec. 709 in cd/m², float32 (h, w, 3), first row on top.
        seconds: time taken, with all rebuilding.
        exposure_ev: automatic exposure.
        method: by which it was drawn.
        unsuited: why ``auto`` did not take ``fast``; empty if it did.
        renderer: the device.
        notes: what of the scene is not drawn as it stands, and why no bow shows.
        behind: what sky stands in for the scene's own, which is being made; empty if none does.
    """

    number: int
    scene: Scene
    rgb: Float32
    seconds: float
    exposure_ev: float
    method: str
    unsuited: str
    renderer: str
    notes: tuple[str, ...] = ()
    behind: str = ""


@dataclass(frozen=True)
class FrameSaved:
    """Files are written."""

    number: int
    paths: tuple[str, ...]


@dataclass(frozen=True)
class SpectrumTaken:
    """Spectral radiance (W), W/(m² sr nm), at wavelengths (W), nm."""

    number: int
    wavelength_nm: Array
    radiance: Array


@dataclass(frozen=True)
class Progressed:
    """How far a request is, 0 to 1, and what is being done."""

    number: int
    share: float
    what: str


@dataclass(frozen=True)
class SkyWaits:
    """How far the sky is that pictures wait for.

    Attributes:
        number: 0, of no request.
        share: 0 to 1; None where nothing is being solved for.
        what: what is being done.
        there: whether another picture would show more of it.
    """

    number: int
    share: float | None
    what: str
    there: bool


@dataclass(frozen=True)
class Failed:
    """A request could not be done; ``kind`` says whose fault that is. Number 0 is of no request."""

    number: int
    kind: Literal["input", "machine", "defect"]
    message: str


_FAILURES = {"input": InputError, "machine": UnavailableError, "defect": RtbowError}


def failure_of(reply: Failed) -> RtbowError:
    """Give a reply's error."""
    return _FAILURES[reply.kind](reply.message)


Reply = FrameDrawn | FrameSaved | SpectrumTaken | Progressed | SkyWaits | Failed


@dataclass(frozen=True)
class Placed:
    """A frame in shared memory, as it travels; this memory is now its slot's only one."""

    frame: FrameDrawn
    slot: int
    memory: str
    size_px: tuple[int, int]


@dataclass(frozen=True)
class Begun:
    """A frame is being drawn now."""

    number: int
