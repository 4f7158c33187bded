"""Runs a GLSL expression once per case on the GPU, one pixel each, so that a function is testable.

The values that the shader sees are the float32 roundings of the inputs; a float64 reference is to
be taken at those, else it measures the rounding of the inputs.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from rtbow.gl.context import GlContext
from rtbow.gl.glsl import Define, assemble, compile_program

MAX_WIDTH_PX = 1024

_VERTEX = """
void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = vec4(4.0 * corner - 1.0, 0.0, 1.0);
}
"""

_FRAGMENT = """
{includes}
{declarations}
{preamble}

out vec4 probe_result;

vec4 probe_vec4(bool x) {{ return vec4(x ? 1.0 : 0.0, 0.0, 0.0, 0.0); }}
vec4 probe_vec4(int x) {{ return vec4(float(x), 0.0, 0.0, 0.0); }}
vec4 probe_vec4(float x) {{ return vec4(x, 0.0, 0.0, 0.0); }}
vec4 probe_vec4(vec2 x) {{ return vec4(x, 0.0, 0.0); }}
vec4 probe_vec4(vec3 x) {{ return vec4(x, 0.0); }}
vec4 probe_vec4(vec4 x) {{ return x; }}

void main() {{
    ivec2 probe_pixel = ivec2(gl_FragCoord.xy);
{fetches}
    {body}
    probe_result = result;
}}
"""

_SAMPLERS = {
    moderngl.Texture: "sampler2D",
    moderngl.Texture3D: "sampler3D",
    moderngl.TextureArray: "sampler2DArray",
    moderngl.TextureCube: "samplerCube",
}


def probe(
    gl: GlContext,
    includes: Sequence[str],
    expression: str,
    inputs: Mapping[str, Any],
    defines: Mapping[str, Define] | None = None,
    uniforms: Mapping[str, Any] | None = None,
    textures: Mapping[str, Any] | None = None,
    preamble: str = "",
    directory: Path | None = None,
) -> NDArray[np.float32]:
    """Evaluate ``expression`` for each case.

    Args:
        gl: the context; need not be current.
        includes: shader files to include, as in ``#include``.
        expression: a GLSL expression of type bool, int, float or vec2 … vec4 (shorter ones fill up
            with zeros), or statements, with semicolons, that assign to ``vec4 result``.
        inputs: variable name to array of shape (n,) or (n, 2 … 4); the variable is a float or
            vec2 … vec4 with the case's value.
        defines: as for ``load_program_source``.
        uniforms: name to bool, int, float, a sequence of 2 to 4 floats, or a square matrix of 2
            to 4 rows. Declared here, unless the preamble does; members of a struct, such as
            ``air.grey``, are the preamble's.
        textures: name to texture; the sampler is declared here, unless the preamble does.
        preamble: GLSL before ``main``: functions, uniforms.
        directory: where the includes are; left out: the package's shaders.

    Returns:
        shape (n, 4), float32.
    """
    uniforms, textures = dict(uniforms or {}), dict(textures or {})
    arrays = {name: _columns(name, value) for name, value in inputs.items()}
    counts = {len(array) for array in arrays.values()}
    if len(counts) != 1 or 0 in counts:
        raise ValueError(f"inputs must be one or more arrays of one length, not {sorted(counts)}")
    count = counts.pop()
    width = min(count, MAX_WIDTH_PX)
    height = -(-count // width)

    declared = [f"uniform sampler2D probe_in_{name};" for name in arrays]
    for name, value in uniforms.items():
        declared.append(f"uniform {_uniform_type(name, value)} {name};")
    for name, texture in textures.items():
        declared.append(f"uniform {_sampler_type(texture)} {name};")
    already = set(re.findall(r"\buniform\s+(?:\w+\s+)?\w+\s+(\w+)\s*[;\[=]", preamble))
    declared = [
        line
        for line in declared
        if (name := line.rstrip(";").split()[-1]) not in already and "." not in name
    ]

    source = assemble(
        _FRAGMENT.format(
            includes="\n".join(f'#include "{name}"' for name in includes),
            declarations="\n".join(declared),
            preamble=preamble,
            fetches="\n".join(_fetch(name, array) for name, array in arrays.items()),
            body=_body(expression),
        ),
        defines or {},
        directory,
        name="(probe)",
    )
    with gl.current() as ctx:
        program = compile_program(ctx, assemble(_VERTEX, {}, Path()), source)
        units: dict[str, Any] = {
            f"probe_in_{name}": _input_texture(ctx, array, width, height)
            for name, array in arrays.items()
        }
        units |= textures
        for unit, (name, texture) in enumerate(units.items()):
            texture.use(unit)
            _set_uniform(program, name, unit)
        for name, value in uniforms.items():
            _set_uniform(program, name, value)
        framebuffer = ctx.framebuffer([ctx.texture((width, height), 4, dtype="f4")])
        framebuffer.use()
        ctx.disable(moderngl.BLEND | moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        ctx.vertex_array(program, []).render(moderngl.TRIANGLES, vertices=3)
        pixels = np.frombuffer(framebuffer.read(components=4, dtype="f4"), np.float32)
        assert ctx.error == "GL_NO_ERROR"
    return pixels.reshape(-1, 4)[:count].copy()


def _columns(name: str, value: Any) -> NDArray[np.float32]:
    array = np.asarray(value, dtype=np.float32)
    if array.ndim == 1:
        array = array[:, None]
    if array.ndim != 2 or not 1 <= array.shape[1] <= 4:
        raise ValueError(f"input {name} has shape {array.shape}; must be (n,) or (n, 2 … 4)")
    return np.ascontiguousarray(array)


def _glsl_float_type(size: int) -> str:
    return "float" if size == 1 else f"vec{size}"


def _fetch(name: str, array: NDArray[np.float32]) -> str:
    size = array.shape[1]
    swizzle = "xyzw"[:size]
    kind = _glsl_float_type(size)
    return f"    {kind} {name} = texelFetch(probe_in_{name}, probe_pixel, 0).{swizzle};"


def _body(expression: str) -> str:
    if ";" not in expression:
        return f"vec4 result = probe_vec4({expression});"
    declares = re.search(r"\bvec4\s+result\b", expression)
    return expression if declares else f"vec4 result = vec4(0.0);\n{expression}"


def _uniform_type(name: str, value: Any) -> str:
    if isinstance(value, bool | np.bool_):
        return "bool"
    if isinstance(value, int | np.integer):
        return "int"
    shape = np.shape(value)
    if len(shape) == 2 and shape[0] == shape[1] and 2 <= shape[0] <= 4:
        return f"mat{shape[0]}"
    if shape == () or (len(shape) == 1 and 2 <= shape[0] <= 4):
        return _glsl_float_type(int(np.prod(shape)))
    raise ValueError(f"uniform {name} has shape {shape}; declare it in the preamble")


def _sampler_type(texture: Any) -> str:
    prefix = {"u": "u", "i": "i"}.get(texture.dtype[0], "")
    return prefix + _SAMPLERS[type(texture)]


def _input_texture(
    ctx: moderngl.Context, array: NDArray[np.float32], width: int, height: int
) -> moderngl.Texture:
    padded = np.zeros((height * width, array.shape[1]), np.float32)
    padded[: len(array)] = array
    texture = ctx.texture((width, height), array.shape[1], padded.tobytes(), dtype="f4")
    texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
    return texture


def _set_uniform(program: moderngl.Program, name: str, value: Any) -> None:
    if name not in program:  # the compiler drops what the expression does not use
        return
    array = np.asarray(value)
    if array.ndim == 2 and array.dtype.kind == "f":
        # Rows here, columns in GL: M[i][j] of NumPy is row i, column j of the shader's M * v.
        value = tuple(array.T.astype(float).ravel())
    elif array.ndim == 1:
        value = tuple(array.tolist())
    elif isinstance(value, np.generic):
        value = value.item()
    program[name].value = value  # type: ignore[union-attr]


def upload(gl, data):
    """Upload rows of texels, (rows, columns, channels)."""
    data = np.ascontiguousarray(data)
    texture = gl.ctx.texture(data.shape[1::-1], data.shape[2], data, dtype="f4")
    texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
    texture.repeat_x = texture.repeat_y = False
    return texture


def rounded(values):
    """Round to float32, as the device holds it."""
    return np.float64(np.float32(values))


def unit_vectors(rng, count):
    """Draw directions (count, 3)."""
    v = rng.normal(size=(count, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)
