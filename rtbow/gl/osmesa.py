"""OpenGL contexts by OSMesa, Mesa's off-screen library: CPU only."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING

from rtbow.gl.driver import GL_VERSION_CODE, BackendError, Driver, SymbolLoader, create

if TYPE_CHECKING:
    import moderngl

_OSMESA_LIBRARIES = ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so")
_PICTURE_PX = (64, 64)
_OSMESA_HELP = "install libosmesa6 (Debian, Ubuntu); Mesa from 25.1 on has no OSMesa: use egl there"

# GL/osmesa.h and GL/gl.h
_OSMESA_FORMAT, _OSMESA_DEPTH_BITS = 0x22, 0x30
_OSMESA_PROFILE, _OSMESA_CORE_PROFILE = 0x33, 0x34
_OSMESA_MAJOR_VERSION, _OSMESA_MINOR_VERSION = 0x36, 0x37
_GL_RGBA, _GL_UNSIGNED_BYTE = 0x1908, 0x1401


class _OsmesaDriver:
    """OSMesa called directly.

    GLFW makes OSMesa contexts too, but only one platform at a time, the null one or a display's,
    and it leaves OSMesa current when asked to detach it.
    """

    def __init__(self, library: ctypes.CDLL) -> None:
        self.closed = False
        self._library = library
        handle, integer = ctypes.c_void_p, ctypes.c_int
        library.OSMesaCreateContextAttribs.argtypes = [ctypes.POINTER(integer), handle]
        library.OSMesaCreateContextAttribs.restype = handle
        library.OSMesaMakeCurrent.argtypes = [handle, handle, ctypes.c_uint, integer, integer]
        library.OSMesaMakeCurrent.restype = ctypes.c_ubyte
        library.OSMesaDestroyContext.argtypes = [handle]
        library.OSMesaDestroyContext.restype = None
        library.OSMesaGetProcAddress.argtypes = [ctypes.c_char_p]
        library.OSMesaGetProcAddress.restype = handle
        attributes = (
            (_OSMESA_FORMAT, _GL_RGBA),
            (_OSMESA_DEPTH_BITS, 24),
            (_OSMESA_PROFILE, _OSMESA_CORE_PROFILE),
            (_OSMESA_MAJOR_VERSION, GL_VERSION_CODE // 100),
            (_OSMESA_MINOR_VERSION, GL_VERSION_CODE // 10 % 10),
        )
        numbers = [number for pair in attributes for number in pair] + [0]
        self._handle = library.OSMesaCreateContextAttribs((integer * len(numbers))(*numbers), None)
        if not self._handle:
            raise BackendError("OSMesa makes no OpenGL 3.3 core context", _OSMESA_HELP)
        # OSMesa wants a picture of its own, though all that counts is drawn to framebuffers.
        self._size = _PICTURE_PX
        self._pixels = ctypes.create_string_buffer(4 * self._size[0] * self._size[1])

    def symbol(self, name: str) -> int:
        return self._library.OSMesaGetProcAddress(name.encode()) or 0

    def attach(self) -> None:
        if self.closed:
            return
        width, height = self._size
        if not self._library.OSMesaMakeCurrent(
            self._handle, self._pixels, _GL_UNSIGNED_BYTE, width, height
        ):
            raise BackendError("OSMesaMakeCurrent failed", _OSMESA_HELP)

    def detach(self) -> None:
        if not self.closed:
            self._library.OSMesaMakeCurrent(None, None, 0, 0, 0)

    def destroy(self) -> None:
        if not self.closed:
            self.closed = True
            self._library.OSMesaDestroyContext(self._handle)


def open_osmesa() -> tuple[Driver, moderngl.Context]:
    """Open a context.

    Raises:
        BackendError: there is no OSMesa here, or it is too old.
    """
    missing = ""
    for name in _OSMESA_LIBRARIES:
        try:
            library = ctypes.CDLL(name)
            driver = _OsmesaDriver(library)
        except OSError as error:
            missing = missing or str(error)
        except AttributeError as error:  # a function that this library lacks
            missing = missing or f"{name}: {error}"
        else:
            return create(driver, SymbolLoader(driver), _OSMESA_HELP)
    raise BackendError(missing, _OSMESA_HELP)
