"""What every way to an OpenGL context has in common: how it is handed to moderngl, and fails."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from rtbow.base.errors import UnavailableError

# moderngl is imported where it is used: a verb without pictures must not wait.
if TYPE_CHECKING:
    import moderngl

GL_VERSION_CODE = 330


class BackendError(UnavailableError):
    """Why a backend gives no context; ``help`` names the package or variable that would."""

    def __init__(self, reason: str, help_text: str) -> None:
        super().__init__(reason)
        self.help = help_text

    def __reduce__(self) -> tuple[type[BackendError], tuple[str, str]]:
        return type(self), (str(self), self.help)  # for worker processes


class Driver(Protocol):
    """How a context becomes current; on a closed one, attach and detach do nothing."""

    closed: bool

    def attach(self) -> None:
        """Make the context current on this thread."""

    def detach(self) -> None:
        """Make none current."""

    def destroy(self) -> None:
        """Release the context; a second call does nothing."""


class HasSymbols(Driver, Protocol):
    """A driver whose GL functions are looked up by name."""

    def symbol(self, name: str) -> int:
        """Give a function's address, 0 if there is none of that name."""


def create(
    driver: Driver, symbols: SymbolLoader, failure_help: str
) -> tuple[Driver, moderngl.Context]:
    """Hand a context that can be attached to moderngl."""
    try:
        driver.attach()
        return driver, create_moderngl(context=symbols)
    except Exception as error:
        driver.detach()
        driver.destroy()
        if isinstance(error, BackendError):
            raise
        raise BackendError(str(error), failure_help) from error


def create_moderngl(**settings: Any) -> moderngl.Context:
    """Make moderngl's context of the one that is current, or of its own by ``settings``."""
    import moderngl

    # moderngl hands its newest context to code that asks for "the" context; ours are not for that.
    store = getattr(moderngl, "_store", None)
    default = getattr(store, "default_context", None)
    try:
        return moderngl.create_context(require=GL_VERSION_CODE, **settings)
    finally:
        if store is not None:
            store.default_context = default


class SymbolLoader:
    """What moderngl wants of a context that it did not make itself."""

    def __init__(self, driver: HasSymbols) -> None:
        self._driver = driver

    def load_opengl_function(self, name: str) -> int:
        """Give a function's address, 0 if there is none of that name."""
        return self._driver.symbol(name)

    load = load_opengl_function

    def __enter__(self) -> None:
        self._driver.attach()

    def __exit__(self, *exc_info: object) -> None:
        self._driver.detach()

    def release(self) -> None:
        """Release the context."""
        self._driver.destroy()


_MESA_FOLDERS = ("MESA_SHADER_CACHE_DIR", "MESA_GLSL_CACHE_DIR", "XDG_CACHE_HOME")
_MESA_NO_CACHE = "MESA_SHADER_CACHE_DISABLE"


@contextmanager
def quiet_mesa() -> Iterator[None]:
    """Open a context within the block without Mesa's remark that it cannot keep shaders.

    It prints one where there is no home; without the folder, shaders are compiled in every run.
    """
    if _MESA_NO_CACHE in os.environ or _mesa_keeps_shaders():
        yield
        return
    os.environ[_MESA_NO_CACHE] = "true"
    try:
        yield
    finally:
        os.environ.pop(_MESA_NO_CACHE, None)


def _mesa_keeps_shaders() -> bool:
    chosen = next((os.environ[name] for name in _MESA_FOLDERS if name in os.environ), None)
    folder = Path(os.path.expanduser("~/.cache")) if chosen is None else Path(chosen)
    if not folder.is_absolute() and not chosen:  # no home, or no name
        return False
    there = next((place for place in (folder, *folder.parents) if os.path.exists(place)), folder)
    return os.access(there, os.W_OK | os.X_OK)
