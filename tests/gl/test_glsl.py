"""Includes, defines, messages that name the file and line, and the probe that runs functions."""

from __future__ import annotations

from pathlib import Path

import moderngl
import numpy as np
import pytest

from glsl_probe import MAX_WIDTH_PX, probe
from rtbow.base.errors import RtbowError
from rtbow.gl.glsl import (
    HEADER_NAME,
    ShaderError,
    assemble,
    compile_program,
    glsl_literal,
    load_program_source,
)

VERTEX = """void main() {
    gl_Position = vec4(4.0 * vec2(gl_VertexID & 1, gl_VertexID >> 1) - 1.0, 0.0, 1.0);
}
"""


@pytest.fixture
def shaders(tmp_path):
    """Write files given as name=text (``_`` before the ending stands for a dot)."""

    def write(**files: str):
        for name, text in files.items():
            stem, _, ending = name.rpartition("_")
            (tmp_path / f"{stem}.{ending}").write_text(text, encoding="utf-8")
        return tmp_path

    return write


def test_version_header_and_text_in_order(shaders):
    directory = shaders(main_frag="\nvoid main() {}\n")
    source = load_program_source("main.frag", {"B": True, "A": 2}, directory)
    lines = ["#version 330 core", "#define A 2", "#define B 1", "", "void main() {}"]
    assert source.text.splitlines()[:5] == lines
    assert source.files == ("main.frag",)
    assert source.places[1:5] == (
        (HEADER_NAME, 2),
        (HEADER_NAME, 3),
        ("main.frag", 1),
        ("main.frag", 2),
    )
    assert len(source.places) == source.text.count("\n")


def test_a_file_is_included_once(shaders):
    directory = shaders(
        main_frag='#include "a.glsl"\n#include "b.glsl"\n#include "a.glsl"\nvoid main() {}\n',
        a_glsl='#include "c.glsl"\nfloat a() { return c(); }\n',
        b_glsl='#include "./c.glsl"\n  #  include "a.glsl" // again\nfloat b() { return a(); }\n',
        c_glsl="float c() { return 1.0; }\n",
    )
    source = load_program_source("main.frag", directory=directory)
    assert source.files == ("main.frag", "a.glsl", "c.glsl", "b.glsl")
    for name in "abc":
        assert source.text.count(f"float {name}()") == 1
    assert "include" not in source.text


def test_a_cycle_names_the_chain(shaders):
    directory = shaders(
        main_frag='\n#include "a.glsl"\n',
        a_glsl='#include "b.glsl"\n',
        b_glsl='// b\n#include "a.glsl"\n',
    )
    with pytest.raises(ShaderError, match=r"b\.glsl:2: circular .*: a\.glsl -> b\.glsl -> a\.glsl"):
        load_program_source("main.frag", directory=directory)


def test_a_file_that_includes_itself_is_a_cycle(shaders):
    directory = shaders(main_frag='#include "main.frag"\n')
    with pytest.raises(ShaderError, match=r"main\.frag:1: circular .*: main\.frag -> main\.frag"):
        load_program_source("main.frag", directory=directory)


def test_a_missing_include_names_the_line(shaders):
    directory = shaders(main_frag='\n\n#include "gone.glsl"\n')
    with pytest.raises(ShaderError, match=r"main\.frag:3: cannot read .*'gone\.glsl': No such"):
        load_program_source("main.frag", directory=directory)


def test_a_missing_main_file_is_named(tmp_path):
    with pytest.raises(ShaderError, match=r"'none\.frag'") as caught:
        load_program_source("none.frag", directory=tmp_path)
    assert isinstance(caught.value, RtbowError)
    assert caught.value.exit_code == 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("\n#version 330 core\n", r"main\.frag:2: #version is the host's business"),
        ("#line 3\n", r"main\.frag:1: #line is the host's business"),
        ("#include <a.glsl>\n", r'main\.frag:1: must read #include "name\.glsl"'),
        ('#ifdef X\n#include "a.glsl"\n#endif\n', r"main\.frag:2: an #include may not stand"),
    ],
)
def test_misplaced_directives(shaders, text, message):
    directory = shaders(main_frag=text, a_glsl="")
    with pytest.raises(ShaderError, match=message):
        load_program_source("main.frag", directory=directory)


def test_directives_in_comments_say_nothing(shaders):
    directory = shaders(
        main_frag='// #include "x"\n/* #version 110\n#include "y"\n*/\n// /*\n#include "a.glsl"\n',
        a_glsl="float a;\n",
    )
    assert "float a;" in load_program_source("main.frag", directory=directory).text


def test_only_ascii_reaches_the_driver(shaders):
    directory = shaders(main_frag="\ufeff// θ in µm\nvoid main() {}\n")
    text = load_program_source("main.frag", directory=directory).text
    assert "// ? in ?m\nvoid main() {}" in text


@pytest.mark.parametrize(
    ("value", "literal"),
    [
        (True, "1"),
        (np.False_, "0"),
        (7, "7"),
        (np.int64(-7), "(-7)"),
        (1.0, "1.0"),
        (-2.0, "(-2.0)"),
        (0.1, "0.100000001"),
        (np.float32(1e-7), "1.00000001e-07"),
        (1e10, "1e+10"),
        (16777216.0, "16777216.0"),
        ("vec3(1.0)", "vec3(1.0)"),
    ],
)
def test_literals(value, literal):
    assert glsl_literal(value) == literal


@pytest.mark.parametrize("value", [float("nan"), float("inf"), 1e39, 2**31, "a\nb"])
def test_values_that_glsl_cannot_hold(value):
    with pytest.raises(ShaderError):
        glsl_literal(value)


@pytest.mark.parametrize("name", ["1A", "A B", "gl_A", "A__B", ""])
def test_names_that_glsl_cannot_define(name):
    with pytest.raises(ShaderError, match="is no name for a define"):
        assemble("", {name: 1}, Path())


def test_messages_of_each_driver(shaders):
    directory = shaders(
        main_frag='float a;\n#include "march.glsl"\nvoid main() {}\n', march_glsl="\n" * 40 + "x\n"
    )
    source = load_program_source("main.frag", {"A": 1}, directory)
    line = source.text.splitlines().index("x") + 1
    for message in (
        f"0:{line}(12): error: x undeclared",
        f"0({line}) : error: x undeclared",
        f"ERROR: 0:{line}: x undeclared",
    ):
        assert source.locate(message) == "march.glsl:41: error: x undeclared"
    main = source.text.splitlines().index("void main() {}") + 1
    assert source.locate(f"WARNING: 0:{main}: odd") == "main.frag:3: warning: odd"
    assert source.locate("0:2(1): error: x") == "(defines):2: error: x"
    several = f"head\n0:3(3): error: a\n0:{line}(5): warning: b"
    assert source.locate(several) == "head\nmain.frag:1: error: a\nmarch.glsl:41: warning: b"
    for unknown in ("0:0(0): error: nowhere", "0:999(1): error: far", "error: no place", ""):
        assert source.locate(unknown) == unknown


def test_compile_errors_are_located(gl, shaders):
    directory = shaders(
        main_vert=VERTEX,
        main_frag='#include "a.glsl"\nout vec4 c;\nvoid main() {\n    c = vec4(a());\n}\n',
        bad_frag='#include "a.glsl"\nout vec4 c;\nvoid main() {\n    c = vec4(nothing);\n}\n',
        worse_frag='#include "b.glsl"\nvoid main() {}\n',
        a_glsl="float a() { return VALUE; }\n",
        b_glsl="/* one\ntwo */\n\nfloat b() { return nothing; }\n",
        bad_vert="\n\nvoid main() { gl_Position = nothing; }\n",
    )
    compile_program(gl.ctx, "main.vert", "main.frag", {"VALUE": 1.0}, directory)
    for vertex, fragment, place in (
        ("main.vert", "bad.frag", "bad.frag:4: error: "),
        ("main.vert", "worse.frag", "b.glsl:4: error: "),
        ("bad.vert", "main.frag", "bad.vert:3: error: "),
        ("main.vert", "main.frag", "a.glsl:1: error: "),  # for want of VALUE
    ):
        defines = {} if place.startswith("a.glsl") else {"VALUE": 1.0}
        with pytest.raises(ShaderError) as caught:
            compile_program(gl.ctx, vertex, fragment, defines, directory)
        assert place in str(caught.value)
        assert str(caught.value).startswith(f"{vertex} + {fragment}: ")


def test_link_errors_are_shader_errors(gl, shaders):
    directory = shaders(
        main_vert=VERTEX, main_frag="float f();\nout float c;\nvoid main() { c = f(); }\n"
    )
    with pytest.raises(ShaderError, match=r"main\.vert \+ main\.frag: "):
        compile_program(gl.ctx, "main.vert", "main.frag", directory=directory)


def test_nvidia_link_messages_are_located():
    class Context:
        def program(self, **stages):
            raise moderngl.Error(
                "GLSL Linker failed\n\nProgram\n=======\nFragment info\n-------------\n"
                "0(3) : error C3001: no program defined\nVertex info\n0(2) : error C1: x\n"
            )

    stages = [assemble("\n\n", directory=Path(), name=name) for name in ("v.vert", "f.frag")]
    with pytest.raises(ShaderError) as caught:
        compile_program(Context(), *stages)
    assert "f.frag:2: error C3001" in str(caught.value)
    assert "v.vert:1: error C1" in str(caught.value)


# --- the probe --------------------------------------------------------------------------------


def test_probe_gives_back_its_inputs(gl, rng):
    n = 2 * MAX_WIDTH_PX + 17  # three rows of pixels, the last one unfinished
    a = rng.normal(size=n)
    b = rng.normal(size=(n, 2))
    c = rng.normal(size=(n, 3))
    d = rng.normal(size=(n, 4)) * 10.0 ** rng.integers(-30, 30, (n, 4))
    inputs = {"a": a, "b": b, "c": c, "d": d}
    np.testing.assert_array_equal(probe(gl, [], "d", inputs), d.astype(np.float32))
    mixed = probe(gl, [], "vec4(a, b.y, c.z, d.w)", inputs)
    expected = np.stack([a, b[:, 1], c[:, 2], d[:, 3]], axis=1)
    np.testing.assert_array_equal(mixed, expected.astype(np.float32))


def test_probe_takes_many_cases(gl):
    a = np.arange(300_000) / 7.0
    result = probe(gl, [], "a", {"a": a})
    assert result.shape == (300_000, 4)
    assert result.dtype == np.float32
    np.testing.assert_array_equal(result[:, 0], a.astype(np.float32))


def test_probe_fills_short_expressions_with_zeros(gl):
    a = {"a": [2.0, 3.0]}
    for expression, first in (
        ("a", [2, 0, 0, 0]),
        ("vec2(a)", [2, 2, 0, 0]),
        ("vec3(a)", [2, 2, 2, 0]),
        ("int(a)", [2, 0, 0, 0]),
        ("a > 2.5", [0, 0, 0, 0]),
    ):
        assert probe(gl, [], expression, a)[0].tolist() == first


def test_probe_runs_statements(gl):
    a = {"a": [1.0, 4.0]}
    for statements in (
        "for (int i = 0; i < 3; ++i) { result.x += a; }",
        "vec4 result = vec4(3.0 * a, 0.0, 0.0, 0.0);",
    ):
        assert probe(gl, [], statements, a)[:, 0].tolist() == [3.0, 12.0]


def test_probe_includes_defines_uniforms_and_preamble(gl, shaders):
    directory = shaders(double_glsl="float double_of(float x) { return FACTOR * x; }\n")
    matrix = np.array([[1.0, 2.0], [3.0, 4.0]])
    result = probe(
        gl,
        ["double.glsl"],
        "vec4(shift(double_of(a)), turn * vec2(a, 1.0), on ? float(count) : axis.z)",
        {"a": [1.0, 2.0]},
        defines={"FACTOR": 2.0},
        uniforms={
            "offset": 0.5,
            "turn": matrix,
            "on": True,
            "count": np.int32(3),
            "axis": [0.0, 0.0, 9.0],
            "unused": 1.0,
        },
        preamble="uniform float offset;\nfloat shift(float x) { return x + offset; }",
        directory=directory,
    )
    rows = [[2 * a + 0.5, *(matrix @ [a, 1.0]), 3.0] for a in (1.0, 2.0)]
    np.testing.assert_array_equal(result, np.array(rows, np.float32))


def test_probe_reads_textures(gl):
    with gl.current() as ctx:
        flat = ctx.texture((3, 1), 1, np.array([1, 2, 4], np.float32).tobytes(), dtype="f4")
        solid = ctx.texture3d((1, 1, 2), 1, np.array([8, 16], np.float32).tobytes(), dtype="f4")
        whole = ctx.texture((2, 1), 1, np.array([5, 6], np.uint32).tobytes(), dtype="u4")
        result = probe(
            gl,
            [],
            "vec4(texelFetch(flat_map, ivec2(a, 0), 0).r, texelFetch(solid, ivec3(0, 0, 1), 0).r,"
            " float(texelFetch(whole, ivec2(1, 0), 0).r), 0.0)",
            {"a": [0.0, 1.0, 2.0]},
            textures={"flat_map": flat, "solid": solid, "whole": whole},
        )
    assert result[:, :3].tolist() == [[1.0, 16.0, 6.0], [2.0, 16.0, 6.0], [4.0, 16.0, 6.0]]


def test_probe_float_defines_arrive_exactly(gl, rng):
    values = (rng.normal(size=20) * 10.0 ** rng.integers(-30, 30, 20)).astype(np.float32)
    defines = {f"V{i}": value for i, value in enumerate(values)}
    for i, value in enumerate(values):
        assert probe(gl, [], f"V{i}", {"a": [0.0]}, defines=defines)[0, 0] == value


def test_probe_locates_errors(gl, shaders):
    directory = shaders(f_glsl="\nfloat f(float x) { return y; }\n")
    with pytest.raises(ShaderError, match=r"f\.glsl:2: error"):
        probe(gl, ["f.glsl"], "f(a)", {"a": [1.0]}, directory=directory)


def test_probe_leaves_the_framebuffer_bound(gl):
    target = gl.ctx.framebuffer([gl.ctx.texture((1, 1), 4)])
    target.use()
    probe(gl, [], "a", {"a": [1.0]})
    assert gl.ctx.fbo is target


@pytest.mark.parametrize(
    "inputs", [{}, {"a": []}, {"a": [1.0], "b": [1.0, 2.0]}, {"a": np.zeros((2, 5))}]
)
def test_probe_refuses_inputs_of_wrong_shape(gl, inputs):
    with pytest.raises(ValueError, match="input"):
        probe(gl, [], "1.0", inputs)


# --- images of a failure ----------------------------------------------------------------------

pytest_plugins = ["pytester"]


def test_images_are_kept_when_a_test_fails(pytester, pytestconfig):
    conftest = (pytestconfig.rootpath / "tests" / "conftest.py").read_text(encoding="utf-8")
    pytester.makeconftest(conftest)
    pytester.makepyfile(
        """
        import numpy as np

        def test_bad(save_failure):
            save_failure("red bow", np.ones((2, 2), np.float32), np.zeros((2, 2)))
            assert False

        def test_good(save_failure):
            save_failure("red bow", [1.0], [1.0])
        """
    )
    pytester.runpytest("-p", "no:cacheprovider").assert_outcomes(passed=1, failed=1)
    folder = pytester.path / "test-failures"
    assert sorted(path.name for path in folder.iterdir()) == [
        f"test_bad-red_bow-{kind}.npy" for kind in ("difference", "frame", "reference")
    ]
    assert np.load(folder / "test_bad-red_bow-difference.npy").tolist() == [[1.0, 1.0], [1.0, 1.0]]
