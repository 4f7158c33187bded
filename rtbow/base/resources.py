"""Where the files that travel with the package lie: shaders, scenes and data."""

from importlib.resources import files
from pathlib import Path
from typing import Literal

from rtbow.base.errors import UnavailableError

PACKAGE = Path(str(files("rtbow"))).resolve()
"""The folder of the package itself."""


def resource_dir(kind: Literal["shaders", "scenes", "data"]) -> Path:
    """Return the folder of one kind of shipped file, in an installed wheel and in a checkout.

    Raises:
        UnavailableError: the installation has no such folder.
    """
    installed = PACKAGE / kind
    if installed.is_dir():
        return installed
    checkout = PACKAGE.parent
    # Only a checkout's own folder counts: site-packages may hold another project's "scenes".
    if kind != "data" and (checkout / "pyproject.toml").is_file() and (checkout / kind).is_dir():
        return checkout / kind
    raise UnavailableError(
        f"this installation of rtbow has no {kind} folder (looked for {installed}); "
        "install it again with: pip install ."
    )
