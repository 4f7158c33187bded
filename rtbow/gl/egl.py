"""OpenGL contexts by EGL: no display needed, a GPU where there is one."""

from __future__ import annotations

import os
import re
import sys
from typing import TYPE_CHECKING, Any

from rtbow.base.errors import InputError
from rtbow.gl.driver import BackendError, Driver, create_moderngl

if TYPE_CHECKING:
    import moderngl

EGL_DEVICE_VARIABLE = "RTBOW_EGL_DEVICE"

# Mesa prints its EGL warnings to stderr; the reasons stand in our own message instead.
_EGL_LOG_VARIABLE = "EGL_LOG_LEVEL"
# glcontext lets this variable win over the index it is called with.
_GLCONTEXT_DEVICE_VARIABLE = "GLCONTEXT_DEVICE_INDEX"

_EGL_PACKAGES = (
    "install libegl1 libgl1 libgl1-mesa-dri (Debian, Ubuntu) or the EGL of the GPU's vendor"
)
_EGL_NO_DEVICE = (
    "no EGL device can be used, as in a container without one: install libgl1-mesa-dri to draw on "
    "the CPU, or hand the GPU and its vendor's EGL into the container; "
    f"{_EGL_LOG_VARIABLE}=debug shows more"
)


class _EglDriver:
    def __init__(self, ctx: moderngl.Context) -> None:
        self.closed = False
        self._ctx = ctx

    def attach(self) -> None:
        if not self.closed:
            self._ctx.__enter__()  # type: ignore[no-untyped-call]

    def detach(self) -> None:
        if not self.closed:
            self._ctx.__exit__(None, None, None)  # type: ignore[no-untyped-call]

    def destroy(self) -> None:
        if not self.closed:
            self.closed = True
            self._ctx.release()


def open_egl() -> tuple[Driver, moderngl.Context]:
    """Open a context on the device that ``RTBOW_EGL_DEVICE`` names, or the first that works.

    Raises:
        BackendError: none works.
        InputError: a wrong ``RTBOW_EGL_DEVICE``.
    """
    chosen = _chosen_egl_device()
    reasons: list[str] = []
    index = 0 if chosen is None else chosen
    while True:
        try:
            ctx = _create_egl(index)
            return _EglDriver(ctx), ctx
        except Exception as error:  # moderngl raises bare Exception here
            reason = str(error)
        beyond = re.search(r"found (\d+) devices?", reason)
        if beyond is None:
            reasons.append(f"device {index}: {reason}")
            if chosen is not None or not reason.startswith("egl"):
                break  # what does not come from EGL fails alike on every device
            index += 1
            continue
        count = int(beyond.group(1))
        if chosen is not None and count > 0:
            raise InputError(
                f"{EGL_DEVICE_VARIABLE} = {chosen}; must be 0..{count - 1}, the EGL devices here; "
                "unset it to take the first that works"
            )
        if not reasons:
            raise BackendError("EGL finds no device", f"{_EGL_PACKAGES}; {_EGL_NO_DEVICE}")
        break
    help_text = _EGL_NO_DEVICE if "0x3001" in reasons[0] else _EGL_PACKAGES
    if len(reasons) > 1 or chosen is not None:
        help_text += f"; {EGL_DEVICE_VARIABLE} chooses one of several devices by index"
    raise BackendError("; ".join(reasons), help_text)


def _chosen_egl_device() -> int | None:
    text = os.environ.get(EGL_DEVICE_VARIABLE, "").strip()
    if not text:
        return None
    # ASCII digits alone: glcontext indexes an array with the number and checks no lower bound.
    if not re.fullmatch(r"[0-9]{1,4}", text):
        raise InputError(
            f"{EGL_DEVICE_VARIABLE} = {text!r}; must be the index of an EGL device: 0, 1, …; "
            "unset it to take the first that works"
        )
    return int(text)


def _create_egl(index: int) -> moderngl.Context:
    settings: dict[str, Any] = {"backend": "egl", "device_index": index}
    if sys.platform.startswith("linux"):
        # By soname: glcontext's own search runs a compiler or ldconfig for every context.
        settings |= {"libgl": "libGL.so.1", "libegl": "libEGL.so.1"}
    index_override = os.environ.pop(_GLCONTEXT_DEVICE_VARIABLE, None)
    quiet = _EGL_LOG_VARIABLE not in os.environ
    if quiet:
        os.environ[_EGL_LOG_VARIABLE] = "fatal"
    try:
        return create_moderngl(standalone=True, **settings)
    finally:
        if quiet:
            del os.environ[_EGL_LOG_VARIABLE]
        if index_override is not None:
            os.environ[_GLCONTEXT_DEVICE_VARIABLE] = index_override
