"""Make a volume file (.npz) from a scene's droplets, for scenes that name it in droplets.file.

python tools/build_droplets.py SCENE OUT.npz [KEY.PATH=VALUE ...]
"""

from __future__ import annotations

import sys
from pathlib import Path

from rtbow.base.errors import RtbowError
from rtbow.base.files import check_writable
from rtbow.scene.text.file import load_scene, parse_set
from rtbow.world.rain.volume import build_volume, save_volume


def main(arguments: list[str]) -> None:
    """Build and write the volume."""
    if len(arguments) < 2:
        sys.exit("usage: python tools/build_droplets.py SCENE OUT.npz [KEY.PATH=VALUE ...]")
    try:
        check_writable(arguments[1], (".npz",))
        scene = load_scene(arguments[0], dict(parse_set(text) for text in arguments[2:]))
        volume = build_volume(scene.droplets).gridded()
        save_volume(volume, Path(arguments[1]))
    except RtbowError as error:
        print(f"build_droplets: {error}", file=sys.stderr)
        sys.exit(error.exit_code)
    low, high = volume.radius_range_um
    print(f"{arguments[1]}: {volume.shape} points, radii {low:g}-{high:g} um")


if __name__ == "__main__":
    main(sys.argv[1:])
