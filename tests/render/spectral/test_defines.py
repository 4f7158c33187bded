"""Shapes that the defines can give the shader compile."""

from collections.abc import Iterable, Iterator, Mapping
from itertools import combinations, product
from typing import Any

import pytest

from lamp_samples import make
from rtbow.gl.context import open_context
from rtbow.gl.glsl import compile_program
from rtbow.render.spectral.layout import shader_defines
from rtbow.world.world import resolve

pytestmark = pytest.mark.slow

SWITCHES = (
    "GRID", "ONE_RADIUS", "AIR", "DISC", "POLE", "WIDE", "EXTINCTION", "POLARIZER", "TABLE"
)  # fmt: skip
VALUES = {
    **dict.fromkeys(SWITCHES, (False, True)),
    "BOW_COUNT": (1, 2),
    "SUN_COUNT": (0, 1, 2),
    "LAMP_COUNT": (0, 1, 2),
}
LIGHTS = {(1, 0), (0, 1), (1, 1), (2, 2)}


def shapes():
    """Every shape with a light; tables have no bows, and so no switches of theirs."""
    for values in product(*VALUES.values()):
        shape = dict(zip(VALUES, values, strict=True))
        bows = shape["DISC"] or shape["POLE"] or shape["WIDE"] or shape["BOW_COUNT"] > 1
        if shape["SUN_COUNT"] + shape["LAMP_COUNT"] > 0 and not (shape["TABLE"] and bows):
            yield shape


def reachable(shape):
    """Whether a scene makes this one."""
    if shape["TABLE"]:
        return True
    if shape["EXTINCTION"] or shape["POLARIZER"]:
        return False  # with Airy's bows: pairs of values suffice, for they share no code
    if not shape["DISC"]:
        return not (shape["WIDE"] or shape["POLE"])
    if shape["SUN_COUNT"] == 0:
        return shape["WIDE"] and not shape["POLE"]
    return True


def pairwise(shapes: Iterable[Mapping[str, Any]]) -> Iterator[dict[str, Any]]:
    """Choose few shapes in which any two values meet that meet in some shape.

    Args:
        shapes: values of the same switches.
    """
    parts = {
        tuple(shape.items()): set(combinations(sorted(shape.items(), key=str), 2))
        for shape in shapes
    }
    missing = set().union(*parts.values())
    while missing:
        chosen = max(parts, key=lambda shape: len(parts[shape] & missing))
        missing -= parts[chosen]
        yield dict(chosen)


def test_shapes_of_the_shader_compile():
    """Any two values of any two defines meet in one, once among shapes that scenes make."""
    scene = make()
    defines = shader_defines(resolve(scene))
    assert defines.keys() | {"TABLE"} >= VALUES.keys()  # which chooses the main
    made = [s for s in shapes() if reachable(s) and (s["SUN_COUNT"], s["LAMP_COUNT"]) in LIGHTS]
    wanted = [*pairwise(made), *pairwise(shapes())]
    assert len(wanted) > 20
    context = open_context("osmesa")
    with context.current() as ctx:
        for number, shape in enumerate(wanted):
            sides = ("1.0", "-1.0")[: shape["BOW_COUNT"]]
            changes = {
                **shape,
                "BOW_SIDE": f"float[]({', '.join(sides)})",
                "ATTENUATION": shape["AIR"] or shape["EXTINCTION"],
                # As many as a sun below the horizon asks for, in every other shape with air.
                "PIECES": 1 + 2 * shape["SUN_COUNT"] * (shape["AIR"] and number % 2),
            }
            fragment = "spectral/table.frag" if changes.pop("TABLE") else "spectral/airy.frag"
            compile_program(
                ctx, "common/fullscreen.vert", fragment, {**defines, **changes}
            ).release()
        assert ctx.error == "GL_NO_ERROR"
    context.close()
