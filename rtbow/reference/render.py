"""Method ``reference``: the radiance integral in float64 on the CPU, plainly.

Each ray is cut where it crosses the planes of the droplet grid; between cuts the drops vary
smoothly and Gauss-Legendre nodes integrate them. At every node and wavelength Airy's intensity is
evaluated itself and averaged over the light's disc by quadrature on the sphere; exact theory is
summed at the scene's own radius and wavelengths, or looked up in float64 where there are several
radii. Air columns towards the sun are quadratures through spherical shells, depths of rain are
integrated exactly between the grid's planes. This is what every faster method is measured against,
so it shares with them the scene, the spectra, the optics formulas and, for drops of several sizes,
the theory's cross-sections as numbers; not how light is gathered along a ray.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from rtbow.base.arrays import Array, Indices, Mask, Progress, floats, no_progress
from rtbow.base.limits import STANDS_M
from rtbow.physics.air.earth_shadow import place_over_sphere, shadow_span
from rtbow.physics.air.rayleigh import horizon_rad, segment_column, sun_column
from rtbow.physics.drop.airy import SCALE_POWER
from rtbow.physics.geometry import angle_between, box_span
from rtbow.physics.light.colour import xyz_to_rgb
from rtbow.physics.light.disc import disc_nodes
from rtbow.reference.lamp import Ball, integrate_lamp, lamp_pieces
from rtbow.reference.orders import Orders, counted_in
from rtbow.reference.pixels import pixel_means
from rtbow.reference.rays import (
    Attenuation,
    Bows,
    DiscNodes,
    Grid,
    Rays,
    Samples,
    depths_along,
    depths_of_paths,
    integrate_spectrum,
    moments_of,
    sample_rays,
)
from rtbow.reference.rows import LampSections, integrate_lamp_rows, integrate_rows
from rtbow.reference.sky import Sky
from rtbow.tables.layout import RadiusAxis, angle_axis, radius_axis, row_sections, running_integral
from rtbow.tables.mie.direct import DirectMieSections
from rtbow.tables.sections import Sections
from rtbow.tables.sky.air import shells_of
from rtbow.tables.sky.light import Air
from rtbow.world.lights import NEAREST_M, Lamp, Sun
from rtbow.world.optics import Optics
from rtbow.world.rain.extinction import (
    RainExtinction,
    mean_extinction_along,
    paths_to,
    with_second,
)
from rtbow.world.rain.volume import DropletVolume
from rtbow.world.steps import fringe_crowding
from rtbow.world.world import World

_AIR_CELL_M = 200.0
"""Longest piece of a ray in air: attenuation over it is a polynomial of degree 5 to 1e-12."""
_RAIN_DEPTH = 0.25
"""Largest optical depth of a piece of a ray."""
_LAMP_RAIN_DEPTH = 0.05
"""The same of a piece at a lamp, over which the attenuation is taken as that of its middle."""
_MIRRORED_PIECES = 12
"""Of the rain along a mirrored ray: the air within it is dimmed by straight lines between them."""
_AT_FLOOR_M = 1e-3
"""What leaves a box no higher than this above its floor leaves through the floor."""
_RAIN_PIECES = 64.0
"""Pieces of a ray in rain that attenuates, at least: ways to lights have kinks."""
_LAMP_PIECE_RAD = 0.01
"""Largest angle of a piece at a lamp. Drops and air vary over it by midpoint rule; the
cross-section's integral over it is exact."""
_DISC_NODES = 16
"""Nodes over the disc beside those that the fringe phase across it asks for."""
_RAYS = 1024
"""Rays that are integrated together where pixels are few, and their points many."""
_SECTION_VALUES = 8_000_000
"""Cross-sections held at a time: rows of pixels are rendered in as many groups as that takes."""


@dataclass(frozen=True)
class _Setup:
    """A world, ready to be integrated along rays."""

    world: World
    optics: Optics
    moments: Array
    sections: Sections | None
    rows: RadiusAxis | None
    sky: Sky | None
    orders: Orders | None

    @property
    def volume(self) -> DropletVolume:
        return self.world.volume

    @property
    def rain(self) -> RainExtinction | None:
        return self.world.rain

    @property
    def polarised(self) -> bool:
        return self.world.view.polarizer is not None

    @property
    def origin(self) -> Array:
        return self.world.view.eye_m

    @property
    def channels(self) -> int:
        """What the weights of the lights sum to: X, Y, Z, or each wavelength by itself."""
        return len((self.optics.sun_weights + self.optics.lamp_weights)[0].T)

    @property
    def rain_ratio(self) -> Array:
        count = len(self.optics.wavelength_nm)
        return np.zeros(count) if self.rain is None else self.rain.ratio

    def longest(self, span_m: Array) -> Array:
        """Longest piece of rays that are inside the box over some lengths (n,), m."""
        # Without attenuation and without a grid the integrand is constant along the ray.
        longest = np.full(len(span_m), _AIR_CELL_M if self.optics.has_air else np.inf)
        if self.rain is not None:
            longest = np.minimum(longest, np.maximum(span_m, 1e-9) / _RAIN_PIECES)
        return longest

    @property
    def extinction(self) -> Array:
        """The rain's extinction as the kernels take it (nz, ny, nx, 2); none if it has none."""
        return with_second(np.zeros((1, 1, 1)) if self.rain is None else self.rain.field)

    def thickest(self, depth: float) -> float:
        """``depth`` where rain attenuates: no piece is to be thicker."""
        return np.inf if self.rain is None else depth

    def shadow_edges(self, directions: Array) -> Array:
        """Distances at which rays in directions (n, 3) cross the edge of the Earth's shadow of each
        sun (n, 2 suns), m."""
        suns = [sun for sun in self.optics.suns if self.world.shades(sun)]
        ends = [shadow_span(self.origin, directions, self.origin, sun.direction) for sun in suns]
        return np.ascontiguousarray(np.reshape(ends, (-1, len(directions))).T)

    def row_place(self, radius_m: Array) -> Array:
        """Places of radii along the rows."""
        assert self.rows is not None
        if len(self.rows.radius_m) == 1:
            return np.zeros(len(radius_m))
        return floats(np.log(radius_m / self.rows.radius_m[0]) * self.rows.per_fold)

    @cached_property
    def haze(self) -> Air | None:
        """The air's ozone and aerosol, if it has them."""
        haze = self.world.haze
        return None if haze is None else haze.air(self.optics.wavelength_nm)

    def mirror_places(self, rays: Rays) -> Array:
        """Where the rain behind a mirror begins, for rays that meet water (m, 3).

        At the water; where a ray leaves through the floor of a box that stands on it, already
        there: the ground is a sphere and falls away from the flat floor, the rain does not end
        above it.
        """
        assert self.sky is not None
        floor = self.volume.box_m[0, 2]
        to_ground = self.sky.ground_distance(rays.origin, rays.directions)
        lowest = rays.origin[2] + rays.leave * rays.directions[:, 2]
        through_floor = (rays.leave > rays.entry) & (lowest < floor + _AT_FLOOR_M)
        through_floor &= floor < self.sky.around.ground_m + STANDS_M
        start = np.where(through_floor, np.minimum(rays.leave, to_ground), to_ground)
        return rays.origin + start[:, None] * rays.directions

    def rain_from(self, places: Array, directions: Array, at: Array) -> Array:
        """Optical depth of the rain along rays that do not begin at the eye: from places (m, 3)
        along unit directions (m, 3) up to distances (m, S)."""
        if self.rain is None:
            return np.zeros(at.shape)
        entry, leave = box_span(places, directions, self.volume.box_m)
        within = np.maximum(leave - entry, 0.0)
        depths = np.zeros(at.shape)
        nodes = np.linspace(0.0, 1.0, _MIRRORED_PIECES + 1)
        hits = np.flatnonzero(within > 0.0)
        length = within[hits] / _MIRRORED_PIECES
        total = np.zeros((len(hits), len(nodes)))
        for k in range(_MIRRORED_PIECES):
            start = places[hits] + (entry[hits] + k * length)[:, None] * directions[hits]
            start = np.clip(start, *self.volume.box_m)
            mean = mean_extinction_along(
                start, directions[hits], length, self.volume, self.rain.field
            )
            total[:, k + 1] = total[:, k] + mean * length
        for row, n in enumerate(hits):
            depths[n] = np.interp(at[n], entry[n] + nodes * within[n], total[row])
        return depths

    def above_ground(self, points: Array) -> Array:
        """Heights of points (m, 3) in the layers of ozone and aerosol, m."""
        assert self.world.haze is not None
        return self.world.haze.above_ground(points[:, 2])

    @cached_property
    def lamp_sections(self) -> LampSections:
        """Cross-sections without a disc at angles twice as close as the shader's own: summed once,
        not for every ray of a pixel."""
        assert self.sections is not None
        assert self.rows is not None
        largest, unit = self.volume.size_range_um[1] * 1e-6, self.world.scatterer.medium.bow_unit
        theta = angle_axis(0.0, np.pi, 0.0, largest, unit).angles()
        theta = np.sort(np.concatenate([theta, 0.5 * (theta[1:] + theta[:-1])]))
        both = row_sections(self.sections, self.rows, theta, 0.0).transpose(1, 0, 3, 2)
        both = np.ascontiguousarray(both)
        if self.polarised:
            both *= 0.5
        return LampSections(theta, both, running_integral(both, theta))

    def area(self, radius_m: Array) -> Array:
        """Squares of radii: of the rows' own one where there is only one, to the last digit."""
        assert self.rows is not None
        one = len(self.rows.radius_m) == 1
        return np.full(len(radius_m), self.rows.radius_m[0] ** 2) if one else radius_m**2


def _set_up(world: World, building: Progress = no_progress, optics: Optics | None = None) -> _Setup:
    volume, scatterer = world.volume, world.scatterer
    optics = optics or world.optics
    least, most = volume.size_range_um
    sections: Sections | None = None
    if scatterer.theory == "mie" and least == most:
        sections = DirectMieSections.of(
            least * 1e-6, optics.wavelength_nm, scatterer.medium, scatterer.spread
        )
    elif not world.bows_in_place:
        sections = world.sections(building)
    rows = None if sections is None else radius_axis((least, most), volume.sizes)
    sky = None
    if world.around is not None:
        lit = bool(optics.suns)
        sky = Sky.of(world.around, optics.wavelength_nm, lit=lit, progress=building)
    orders = None
    if optics is world.optics and counted_in(world) is not None:
        orders = Orders.of(world, building)
    return _Setup(world, optics, moments_of(volume), sections, rows, sky, orders)


def _rays(setup: _Setup, directions: Array) -> Rays:
    """Rays from the eye in some directions (n, 3), as the kernels take them."""
    entry, leave = box_span(setup.origin, directions, setup.volume.box_m)
    if setup.sky is not None:  # drops in the ground are not seen
        ground = np.maximum(setup.sky.ground_distance(setup.origin, directions), entry)
        leave = np.where(leave > entry, np.minimum(leave, ground), leave)
    return Rays(setup.origin, directions, entry, leave, setup.longest(leave - entry))


def _points(rays: Rays, start: Indices, distance: Array) -> tuple[Array, Array]:
    """Where samples along rays are, in m, and the directions of their rays: each (m, 3)."""
    along = np.repeat(rays.directions, np.diff(start), axis=0)
    return rays.origin + distance[:, None] * along, along


def _depth_to_eye(setup: _Setup, rays: Rays, grid: Grid, start: Indices, distance: Array) -> Array:
    if setup.rain is None:
        return np.zeros(len(distance))
    return depths_along(rays, start, distance, grid)


def _depth_to_light(setup: _Setup, light: Sun | Lamp, grid: Grid, points: Array) -> Array:
    if setup.rain is None or not len(points):
        return np.zeros(len(points))
    inside = np.clip(points, grid.box[0], grid.box[1])
    directions, lengths = paths_to(light, inside, grid.box)
    return depths_of_paths(inside, directions, lengths, grid)


def _attenuation(setup: _Setup, column: Array, depth: Array, others: Array) -> Attenuation:
    haze, waves = setup.haze, len(setup.optics.wavelength_nm)
    depths = np.zeros((0, waves)) if haze is None else haze.beam[1:]
    return Attenuation(column, depth, setup.optics.air_depth, setup.rain_ratio, others, depths)


def _others_to_eye(setup: _Setup, points: Array, distance: Array) -> Array:
    """Columns of ozone and aerosol from points (m, 3) to the eye (m, C), through flat layers as
    those of the molecules; C is 0 where there are none."""
    haze = setup.haze
    if haze is None:
        return np.zeros((len(points), 0))
    eye = np.broadcast_to(setup.origin, points.shape)
    heights = setup.above_ground(eye), setup.above_ground(points)
    return shells_of(haze).amounts(*heights, distance)[1:].T


def _others_to_sun(setup: _Setup, sun: Sun, points: Array) -> Array:
    """The same towards a sun, through spherical shells."""
    haze = setup.haze
    if haze is None:
        return np.zeros((len(points), 0))
    height, altitude = points[:, 2], np.full(len(points), sun.altitude_rad)
    if setup.world.shades(sun):
        height, altitude = place_over_sphere(points, setup.origin, sun.direction)
    assert setup.world.haze is not None
    height = setup.world.haze.above_ground(height)
    return shells_of(haze).column_at(height, altitude - horizon_rad(height))[1:].T


def _under_suns(setup: _Setup, rays: Rays, grid: Grid) -> Array:
    """Integrate pixels under the suns: (pixels, channels)."""
    optics = setup.optics
    total = np.zeros((len(rays.directions), setup.channels))
    edges = setup.shadow_edges(rays.directions)
    samples = sample_rays(rays, grid, edges, setup.thickest(_RAIN_DEPTH))
    points, along = _points(rays, samples.start, samples.distance)
    eye_depth = _depth_to_eye(setup, rays, grid, samples.start, samples.distance)
    eye_column = np.zeros(len(points))
    if optics.has_air:
        eye_column = segment_column(rays.origin[2], along[:, 2], samples.distance)
    for sun, colour in zip(optics.suns, optics.sun_weights, strict=True):
        column = eye_column
        if optics.has_air:
            column = column + _column_to_sun(setup, sun, points)
        depth = eye_depth + _depth_to_light(setup, sun, grid, points)
        others = _others_to_eye(setup, points, samples.distance)
        others = np.ascontiguousarray(others + _others_to_sun(setup, sun, points))
        attenuation = _attenuation(setup, column, depth, others)
        # 0 is forward: light travels along -direction and on towards the eye along -ray.
        theta = angle_between(rays.directions, sun.direction)
        share = setup.world.view.perpendicular_share(sun.direction, rays.directions)
        gather = _airy_sun if setup.sections is None else _table_sun
        total += gather(setup, sun, samples, attenuation, theta, share, colour)
    return total


def _column_to_sun(setup: _Setup, sun: Sun, points: Array) -> Array:
    """Air columns from points (n, 3) towards a sun, infinite in the Earth's shadow."""
    if setup.world.shades(sun):
        return sun_column(*place_over_sphere(points, setup.origin, sun.direction))
    return sun_column(points[:, 2], sun.altitude_rad)


def _airy_sun(
    setup: _Setup, sun: Sun, samples: Samples, attenuation: Attenuation, theta: Array,
    share: Array, colour: Array,
) -> Array:  # fmt: skip
    """Light of one sun by Airy's bows, evaluated at each sample."""
    counts = np.diff(samples.start)
    angles, weights, first = [], [], [0]
    for pixel, angle in enumerate(theta):
        if counts[pixel]:
            part = slice(samples.start[pixel], samples.start[pixel + 1])
            most = float(samples.radius[part].max())
            nodes, shares = _disc_angles(setup.optics, sun.disc_rad, float(angle), most)
            angles.append(nodes)
            weights.append(shares)
        first.append(first[-1] + (len(angles[-1]) if counts[pixel] else 0))
    if not angles:
        return np.zeros((len(theta), setup.channels))
    disc = DiscNodes(np.array(first), np.concatenate(angles), np.concatenate(weights))
    return integrate_spectrum(samples, attenuation, disc, share, _bows(setup), colour)


def _disc_angles(
    optics: Optics, disc_rad: float, theta: float, radius_m: float
) -> tuple[Array, Array]:
    """Give nodes over a light's disc, enough for the fringes of this angle and drop size."""
    phase = 0.0
    for bow in optics.bows:
        scale = bow.scale.max() * radius_m**SCALE_POWER
        excess = np.max(bow.side * (theta - bow.angle_rad)) + 2.0 * disc_rad
        phase = max(phase, 2.0 * scale * disc_rad * np.sqrt(max(scale * excess, 1.0)))
    return disc_nodes(theta, disc_rad, _DISC_NODES + int(0.6 * phase))


def _table_sun(
    setup: _Setup, sun: Sun, samples: Samples, attenuation: Attenuation, theta: Array,
    share: Array, colour: Array,
) -> Array:  # fmt: skip
    """Light of one sun by cross-sections computed at each pixel's own angle."""
    assert setup.sections is not None
    assert setup.rows is not None
    lit = np.diff(samples.start) > 0
    total = np.zeros((len(theta), setup.channels))
    if not np.any(lit):
        return total
    both = row_sections(setup.sections, setup.rows, theta[lit], sun.disc_rad)  # (R, W, U, 2)
    halves = 0.5 if setup.polarised else 1.0
    mixed = share[lit] * both[..., 0] + (1.0 - share[lit]) * both[..., 1]
    sections = np.zeros((len(theta), both.shape[1], both.shape[0]))
    sections[lit] = halves * mixed.transpose(2, 1, 0)
    row, area = setup.row_place(samples.radius), setup.area(samples.radius)
    return integrate_rows(samples, attenuation, row, area, sections, colour)


def _under_lamps(setup: _Setup, rays: Rays, grid: Grid) -> Array:
    """Integrate pixels under the lamps: (pixels, channels)."""
    optics = setup.optics
    total = np.zeros((len(rays.directions), setup.channels))
    for lamp, colour in zip(optics.lamps, optics.lamp_weights, strict=True):
        ball = Ball(lamp.position_m, lamp.radius_m, NEAREST_M)
        pieces = lamp_pieces(rays, grid, ball, _LAMP_PIECE_RAD, setup.thickest(_LAMP_RAIN_DEPTH))
        points, along = _points(rays, pieces.start, pieces.distance)
        column = np.zeros(len(points))
        if optics.has_air:
            distance = np.linalg.norm(points - lamp.position_m, axis=1)
            slope = (points[:, 2] - lamp.position_m[2]) / distance
            column = segment_column(rays.origin[2], along[:, 2], pieces.distance)
            column = column + segment_column(lamp.position_m[2], slope, distance)
        depth = _depth_to_eye(setup, rays, grid, pieces.start, pieces.distance)
        depth = depth + _depth_to_light(setup, lamp, grid, points)
        others = _others_to_eye(setup, points, pieces.distance)
        if setup.haze is not None:
            way = np.linalg.norm(points - lamp.position_m, axis=1)
            lamp_m = setup.above_ground(np.broadcast_to(lamp.position_m, points.shape))
            heights = lamp_m, setup.above_ground(points)
            others = others + shells_of(setup.haze).amounts(*heights, way)[1:].T
        attenuation = _attenuation(setup, column, depth, np.ascontiguousarray(others))
        towards = lamp.position_m - rays.origin
        share = setup.world.view.perpendicular_share(towards, rays.directions)
        if setup.sections is None:
            total += integrate_lamp(pieces, attenuation, share, _bows(setup), colour)
        else:
            row, sections = setup.row_place(pieces.radius), setup.lamp_sections
            total += integrate_lamp_rows(pieces, attenuation, row, share, sections, colour)
    return total


def _bows(setup: _Setup) -> Bows:
    """Bows as the kernels take them.

    With a polariser the strengths are half of the components', of which it passes shares; else
    each is the mean of both.
    """
    bows, polarised = setup.optics.bows, setup.polarised
    return Bows(
        angle=np.stack([b.angle_rad for b in bows]),
        scale=np.stack([b.scale for b in bows]),
        first=np.stack([0.5 * b.perpendicular if polarised else b.strength for b in bows]),
        second=np.stack([0.5 * b.parallel if polarised else b.strength for b in bows]),
        side=np.array([b.side for b in bows]),
    )


def radiance_along(world: World, rays: Array) -> Array:
    """Give what the eye receives along some rays, in float64.

    Args:
        world: the world; its eye counts, and its picture for a polariser alone.
        rays: unit directions (n, 3).

    Returns:
        X, Y, Z (n, 3), Y in cd/m².
    """
    return _gathered(_set_up(world), rays)


def _gathered(setup: _Setup, directions: Array) -> Array:
    rays = _rays(setup, directions)
    crowding = fringe_crowding(setup.volume, setup.optics)
    grid = Grid(setup.volume.box_m, setup.moments, setup.extinction, crowding)
    total = np.zeros((len(directions), setup.channels))
    if setup.optics.suns:
        total += _under_suns(setup, rays, grid)
    if setup.optics.lamps:
        total += _under_lamps(setup, rays, grid)
    if setup.sky is not None:
        total += _around(setup, setup.sky, rays, grid)
    if setup.orders is not None:
        counted = counted_in(setup.world)
        assert counted is not None
        paths = setup.world.fineness.samples
        total += setup.orders.along(directions, counted, paths=paths).mean
    return total


def _around(setup: _Setup, sky: Sky, rays: Rays, grid: Grid) -> Array:
    """The air's own light, the ground and the suns themselves: (pixels, channels)."""
    optics, view = setup.optics, setup.world.view
    edges = sky.edges(rays)
    middles = 0.5 * (edges[:, 1:] + edges[:, :-1])
    at = np.concatenate([middles, edges[:, -1:]], axis=1)
    start = np.arange(len(edges) + 1) * at.shape[1]
    distance = np.minimum(at, rays.leave[:, None])  # the depth stays what it is behind the rain
    distance = np.where(rays.leave[:, None] > rays.entry[:, None], distance, 0.0)
    depth = _depth_to_eye(setup, rays, grid, start, distance.ravel()).reshape(at.shape)
    probes = view.probes(rays.directions)

    def rain_from(chosen: Mask, directions: Array, at: Array) -> Array:
        return setup.rain_from(setup.mirror_places(rays.some(chosen)), directions, at)

    total = np.zeros((len(edges), setup.channels))
    for sun, colour in zip(optics.suns, optics.sun_weights, strict=True):
        seen = sky.along(rays, edges, depth, setup.rain_ratio, sun, probes, rain_from)
        total += seen @ colour
    return total


def spectral_radiance_along(world: World, rays: Array) -> Array:
    """Give the spectral radiance that the eye receives along some rays, in float64.

    Args:
        world: the world, as for :func:`radiance_along`.
        rays: unit directions (n, 3).

    Returns:
        Means over the bins of the world's wavelength step (n, W), W m⁻² sr⁻¹ nm⁻¹: see
        :func:`rtbow.physics.light.spectrum.wavelength_bins`; without the rain's own glow.
    """
    return _gathered(_set_up(world, optics=world.optics.apart()), rays)


def radiance_of_pixels(world: World, rows: Indices, columns: Indices) -> Array:
    """Give some pixels of a world's picture, in float64.

    Args:
        world: the world.
        rows: row of each pixel, first on top (n,).
        columns: column of each (n,).

    Returns:
        X, Y, Z (n, 3), Y in cd/m².
    """
    if world.view.area:
        return _means(_set_up(world), rows, columns)
    rays, _ = world.view.rays_through(floats(columns + 0.5), floats(rows + 0.5))
    return radiance_along(world, rays)


def _means(setup: _Setup, rows: Indices, columns: Indices) -> Array:
    """Means over the solid angles of pixels (n, 3)."""
    disc = min((sun.disc_rad for sun in setup.optics.suns), default=0.0)
    return pixel_means(
        setup.world.view, rows, columns, disc, lambda rays: _gathered(setup, rays),
        _rays_at_a_time(setup),
    )  # fmt: skip


def _rays_at_a_time(setup: _Setup) -> int:
    """Rays whose cross-sections are held together."""
    if setup.rows is None:
        return _RAYS
    each = len(setup.rows.radius_m) * len(setup.optics.wavelength_nm) * 2
    return min(_SECTION_VALUES // each, _RAYS)


def _rows_at_a_time(setup: _Setup, width: int, height: int) -> int:
    """Rows of pixels that are rendered together."""
    if setup.rows is None or width == 0:
        return 1
    # What a table gives it gives for many angles at once.
    each = width * len(setup.rows.radius_m) * len(setup.optics.wavelength_nm) * 2
    return min(max(_SECTION_VALUES // each, 1), max(height // 4, 1))


def render_reference(
    world: World,
    progress: Progress = no_progress,
    columns: slice = slice(None),
    building: Progress = no_progress,
) -> Array:
    """Render a world in float64 at its own wavelength step (1 nm is the standard of truth).

    Args:
        world: the world.
        progress: wraps the loop over the picture's rows.
        columns: which columns of the picture; all by default.
        building: wraps the loop over parts of an exact table that has to be built first.

    Returns:
        Linear Rec. 709, D65, in cd/m², float64 (h, columns, 3), first row on top.
    """
    setup = _set_up(world, building)
    width, height = world.view.size_px
    columns_of = np.arange(width)[columns]
    width = len(columns_of)
    xyz = np.zeros((height, width, 3))
    group = _rows_at_a_time(setup, width, height)
    for row in progress(range(height)):
        if row % group == 0:
            rows = slice(row, min(row + group, height))
            if world.view.area:
                places = np.meshgrid(np.arange(height)[rows], columns_of, indexing="ij")
                xyz[rows] = _means(setup, *(p.ravel() for p in places)).reshape(xyz[rows].shape)
            else:
                rays = world.view.pixel_directions(rows)[:, columns]
                xyz[rows] = _gathered(setup, rays.reshape(-1, 3)).reshape(rays.shape)
    return xyz_to_rgb(xyz)
