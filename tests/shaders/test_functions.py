"""Small GLSL functions against float64 at the same float32 inputs, on each backend."""

import moderngl
import numpy as np
import pytest

from glsl_probe import probe, rounded, unit_vectors
from rtbow.physics.geometry import box_span
from rtbow.physics.light.colour import XYZ_TO_RGB, xyz_to_rgb
from rtbow.render.uniforms import matrix_literal
from rtbow.scene.model import Camera
from rtbow.world.camera.perspective import camera_basis
from rtbow.world.camera.resolve import pixel_directions
from rtbow.world.rain.volume_compiled import interpolate


class TestAngleBetween:
    def angles(self, gl, u, v):
        return probe(gl, ["common/math.glsl"], "angleBetween(u, v)", {"u": u, "v": v})[:, 0]

    def test_any_angle(self, gl, rng):
        count = 30_000
        u, beside = unit_vectors(rng, count), unit_vectors(rng, count)
        beside -= (beside * u).sum(axis=1, keepdims=True) * u
        beside /= np.linalg.norm(beside, axis=1, keepdims=True)
        tiny = 10.0 ** rng.uniform(-7.0, 0.0, count)
        angle = np.select(
            [np.arange(count) % 3 == 0, np.arange(count) % 3 == 1],
            [tiny, np.pi - tiny],
            rng.uniform(0.0, np.pi, count),
        )[:, None]
        u, v = rounded(u), rounded(np.cos(angle) * u + np.sin(angle) * beside)
        # Rounded vectors are no longer of length 1 exactly: the angle between their directions.
        a, b = (w / np.linalg.norm(w, axis=1, keepdims=True) for w in (u, v))
        exact = 2.0 * np.arctan2(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))
        got = self.angles(gl, u, v)
        # Worst 3.5e-7 rad; 5e-8 below 0.1 rad.
        np.testing.assert_allclose(got, exact, rtol=0.0, atol=5e-7)
        small = exact < 0.1
        np.testing.assert_allclose(got[small], exact[small], rtol=0.0, atol=8e-8)

    def test_parallel_and_antiparallel(self, gl, rng):
        u = unit_vectors(rng, 500)
        np.testing.assert_array_equal(self.angles(gl, u, u), 0.0)
        np.testing.assert_allclose(self.angles(gl, u, -u), np.pi, rtol=0.0, atol=3e-7)

    def test_right_angles_of_the_axes(self, gl):
        axes = np.vstack([np.eye(3), -np.eye(3)])
        u, v = np.repeat(axes, 6, axis=0), np.tile(axes, (6, 1))
        exact = np.arccos(np.clip((u * v).sum(axis=1), -1.0, 1.0))
        np.testing.assert_allclose(self.angles(gl, u, v), exact, rtol=0.0, atol=3e-7)


class TestMeanDecay:
    def test_both_sides_of_every_threshold(self, gl, rng):
        u = rounded(
            np.concatenate(
                [
                    rng.choice([-1.0, 1.0], 20_000) * 10.0 ** rng.uniform(-8.0, 1.3, 20_000),
                    np.linspace(-0.3, 0.3, 6001),
                    np.float32(0.25) * (1.0 + np.arange(-4, 5) * 2.0**-23),
                ]
            )
        )
        u = u[u != 0.0]
        got = probe(gl, ["common/math.glsl"], "meanDecay(u)", {"u": u})[:, 0]
        error = np.abs(got / (-np.expm1(-u) / u) - 1.0)
        # Worst 9.3e-7, Mesa's exp; 1.0e-7 where the series stands in for it.
        assert error.max() < 1.2e-6
        assert error[np.abs(u) < 0.25].max() < 2e-7

    def test_horizontal(self, gl):
        assert probe(gl, ["common/math.glsl"], "meanDecay(u)", {"u": [0.0, -0.0]})[
            :, 0
        ] == pytest.approx(1.0, abs=0.0)


def test_texel_centred_maps_the_ends_to_texel_centres(gl):
    value = rounded(np.array([-5.0, 0.0, 0.25, 0.5, 1.0, 7.0]))
    for size in (1, 2, 7, 1280):
        got = probe(gl, ["common/math.glsl"], "texelCentred(value, size)", {"value": value},
                    uniforms={"size": float(size)})[:, 0]  # fmt: skip
        exact = (np.clip(value, 0.0, 1.0) * (size - 1) + 0.5) / size
        np.testing.assert_allclose(got, exact, rtol=0.0, atol=1.2e-7)


def test_texel_centred_hits_the_nodes_of_a_texture(gl):
    nodes = np.array([[3.0, 1.0, 4.0, 1.5, 9.0]], dtype=np.float32)
    texture = gl.ctx.texture((5, 1), 1, nodes, dtype="f4")
    texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
    texture.repeat_x = False
    at = np.linspace(0.0, 1.0, 9)
    got = probe(
        gl, ["common/math.glsl"], "texture(line, vec2(texelCentred(at, 5.0), 0.5)).r", {"at": at},
        textures={"line": texture},
    )[:, 0]  # fmt: skip
    np.testing.assert_allclose(got, np.interp(at * 4.0, np.arange(5), nodes[0]), rtol=1e-6)


class TestBoxSpan:
    LOW, HIGH = np.array([-3.0, 2.0, -1.0]), np.array([5.0, 10.0, 7.0])

    def spans(self, gl, rays, low, high):
        """Rays (n, 3) from the eye, with corners relative to it: entry and exit (n, 2)."""
        inputs = {"ray": rays, "low": low, "high": high}
        return probe(gl, ["common/box.glsl"], "boxSpan(ray, low, high)", inputs)[:, :2]

    def check(self, gl, rays, low, high):
        rays, low, high = (
            rounded(np.broadcast_to(a, np.broadcast_shapes(np.shape(rays), np.shape(low))))
            for a in (rays, low, high)
        )
        got = self.spans(gl, rays, low, high)
        for ray, a, b, (entry, leave) in zip(rays, low, high, got, strict=True):
            exact = box_span(np.zeros(3), ray[None], np.stack([a, b]))
            inside = exact[0][0] < exact[1][0]
            assert (entry < leave) == inside, (ray, a, b)
            if inside:
                # Worst 2e-7 relative: one division.
                assert entry == pytest.approx(exact[0][0], rel=4e-7)
                assert leave == pytest.approx(exact[1][0], rel=4e-7)

    @pytest.mark.parametrize(
        "eye",
        [
            [0.0, 0.0, 0.0],  # before it
            [0.0, 5.0, 3.0],  # inside
            [-3.0, 5.0, 3.0],  # on a face
            [-3.0, 2.0, -1.0],  # on a corner
            [5.0, 10.0, 3.0],  # on an edge
            [0.0, 20.0, 3.0],  # beyond it
            [-300.0, 500.0, 80.0],  # far
        ],
    )
    def test_directions_all_round(self, gl, rng, eye):
        axes = np.vstack([np.eye(3), -np.eye(3)])
        planes = unit_vectors(rng, 90)
        planes[np.arange(90), np.arange(90) % 3] = 0.0  # parallel to one pair of faces
        planes /= np.linalg.norm(planes, axis=1, keepdims=True)
        at_box = rng.uniform(self.LOW - 1.0, self.HIGH + 1.0, (300, 3)) - eye
        at_box /= np.linalg.norm(at_box, axis=1, keepdims=True)
        rays = np.vstack([axes, planes, unit_vectors(rng, 200), at_box])
        self.check(gl, rays, self.LOW - eye, self.HIGH - eye)

    @pytest.mark.parametrize("axis", [0, 1, 2])
    @pytest.mark.parametrize("side", [-1, 1])
    def test_along_a_face(self, gl, axis, side):
        # The eye in the plane of a face, outside of the box; the ray in that plane towards it.
        other = (axis + 1) % 3
        eye = 0.5 * (self.LOW + self.HIGH)
        eye[axis] = (self.LOW if side < 0 else self.HIGH)[axis]
        eye[other] = self.LOW[other] - 2.0
        ray = np.eye(3)[other]
        got = self.spans(gl, ray[None], (self.LOW - eye)[None], (self.HIGH - eye)[None])
        np.testing.assert_allclose(got[0], [2.0, 2.0 + (self.HIGH - self.LOW)[other]], rtol=1e-6)
        beside = eye + side * 1e-3 * np.eye(3)[axis]
        entry, leave = self.spans(gl, ray[None], (self.LOW - beside)[None],
                                  (self.HIGH - beside)[None])[0]  # fmt: skip
        assert entry >= leave

    def test_behind(self, gl):
        entry, leave = self.spans(gl, [[0.0, 1.0, 0.0]], [[-1.0, -9.0, -1.0]], [[1.0, -3.0, 1.0]])[
            0
        ]
        assert entry >= leave

    def test_everything_is_finite(self, gl, rng):
        rays = np.vstack([np.eye(3), -np.eye(3), unit_vectors(rng, 50)])
        got = self.spans(gl, rays, np.zeros_like(rays), np.ones_like(rays))
        assert np.all(np.isfinite(got))


@pytest.mark.parametrize("size_px", [(97, 54), (30, 80), (1, 1)])
@pytest.mark.parametrize(("azimuth", "altitude"), [(0.0, 20.0), (123.0, -65.0), (270.0, 90.0)])
@pytest.mark.parametrize("fov_deg", [1.0, 75.0, 170.0])
def test_camera_ray(gl, size_px, azimuth, altitude, fov_deg):
    camera = Camera(size_px=size_px, azimuth_deg=azimuth, altitude_deg=altitude, fov_deg=fov_deg)
    width, height = size_px
    column, row = (a.ravel() for a in np.meshgrid(np.arange(width), np.arange(height)))
    screen = np.stack(
        [(column + 0.5) / width * 2.0 - 1.0, 1.0 - (row + 0.5) / height * 2.0], axis=1
    )
    # Rows of the host's basis are columns of the shader's.
    got = probe(
        gl, ["common/camera.glsl"], "cameraRay(screen, basis)", {"screen": screen},
        uniforms={"basis": camera_basis(camera).T},
    )[:, :3]  # fmt: skip
    exact = pixel_directions(camera).reshape(-1, 3)
    np.testing.assert_allclose(got, exact, rtol=0.0, atol=3e-7)  # worst 2e-7


class TestDroplets:
    @pytest.fixture
    def grid(self, rng):
        """Moments (nz, ny, nx, 2) of a grid with empty points, density and density x radius."""
        shape = (4, 3, 5)
        density = rng.uniform(50.0, 2000.0, shape) * (rng.random(shape) < 0.6)
        radius = rng.uniform(15e-6, 1500e-6, shape)
        return np.stack([density, density * radius], axis=-1).astype(np.float32)

    def sample(self, gl, moments, place):
        nz, ny, nx = moments.shape[:3]
        texture = gl.ctx.texture3d((nx, ny, nz), 2, np.ascontiguousarray(moments), dtype="f4")
        texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        texture.repeat_x = texture.repeat_y = texture.repeat_z = False
        body = "Droplets d = sampleDroplets(m, place); result = vec4(d.density, d.radius, 0, 0);"
        return probe(gl, ["rain/droplets.glsl"], body, {"place": place}, textures={"m": texture})[
            :, :2
        ]

    def test_is_the_references(self, gl, rng, grid):
        place = rounded(np.vstack([rng.random((3000, 3)), rng.integers(0, 2, (50, 3))]))
        box = np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])
        exact = np.array([interpolate(p, box, grid.astype(np.float64)) for p in place])
        got = self.sample(gl, grid, place)
        # Worst 4e-7 of the greatest.
        np.testing.assert_allclose(got[:, 0], exact[:, 0], rtol=0.0, atol=1e-6 * grid[..., 0].max())
        filled = exact[:, 0] > 1.0
        radius = exact[filled, 1] / exact[filled, 0]
        # Worst 2e-5, where a point is almost empty.
        np.testing.assert_allclose(got[filled, 1], radius, rtol=1e-4)

    def test_grid_points_are_met_and_faces_extend(self, gl, grid):
        nz, ny, nx = grid.shape[:3]
        k, j, i = (a.ravel() for a in np.indices((nz, ny, nx)))
        place = np.stack([i / (nx - 1), j / (ny - 1), k / (nz - 1)], axis=1)
        got = self.sample(gl, grid, place)
        np.testing.assert_allclose(got[:, 0], grid[k, j, i, 0], rtol=1e-5, atol=2e-3)
        beyond = self.sample(gl, grid, np.array([[-0.5, 0.0, 0.0], [1.5, 1.0, 1.0]]))
        np.testing.assert_allclose(beyond[:, 0], [grid[0, 0, 0, 0], grid[-1, -1, -1, 0]], atol=2e-3)

    def test_an_empty_point_pulls_no_radius(self, gl):
        moments = np.zeros((2, 2, 2, 2), dtype=np.float32)
        moments[..., 0, :] = (1000.0, 1000.0 * 500e-6)  # the west face
        place = np.array([[0.0, 0.5, 0.5], [0.5, 0.5, 0.5], [0.99, 0.5, 0.5], [1.0, 0.5, 0.5]])
        got = self.sample(gl, moments, place)
        np.testing.assert_allclose(got[:, 0], [1000.0, 500.0, 10.0, 0.0], rtol=1e-5, atol=1e-4)
        np.testing.assert_allclose(got[:3, 1], 500e-6, rtol=1e-6)
        assert np.all(np.isfinite(got))


def test_xyz_to_rgb(gl, rng):
    xyz = rounded(rng.uniform(0.0, 9000.0, (200, 3)))
    got = probe(
        gl, ["common/colour.glsl"], "xyzToRgb(xyz)", {"xyz": xyz},
        {"XYZ_TO_RGB": matrix_literal(XYZ_TO_RGB)},
    )[:, :3]  # fmt: skip
    np.testing.assert_allclose(got, xyz_to_rgb(xyz), rtol=0.0, atol=9000.0 * 5e-7)


def test_d65_is_white(gl):
    # CIE 15: chromaticity of D65, in the four digits of IEC 61966-2-1.
    white = np.array([0.3127, 0.3290, 0.3583]) / 0.3290
    got = probe(
        gl, ["common/colour.glsl"], "xyzToRgb(xyz)", {"xyz": white[None]},
        {"XYZ_TO_RGB": matrix_literal(XYZ_TO_RGB)},
    )[0, :3]  # fmt: skip
    np.testing.assert_allclose(got, 1.0, atol=1e-3)
