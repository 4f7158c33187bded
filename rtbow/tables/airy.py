"""The scattering table: Airy's intensity averaged over the light's disc, in scaled variables.

Airy's theory depends on radius, wavelength, order and disc only through the scaled angle ``z`` and
the disc's radius ``s`` in the same scale (:mod:`rtbow.physics.drop.airy`), so three
small arrays hold it all:

* ``near``: the mean of Ai²(-(z + s t)) over a disc, around the bow, up to a last ``z``, and its
  running integral over z, with which a march in angle takes exact steps;
* ``fringe`` beyond: there Ai² is ``(1 + sin(psi)) / (2 pi sqrt(z))`` to better than 0.1 %; a
  disc of ``P`` rad of fringe phase damps the sine by ``J = 2 J1(P)/P``, and because fringes narrow
  across the disc it adds ``B cos(psi) / z^(3/2)``, B = P J'/4 - P² J''/8;
* ``pole``: within some disc radii of the antisolar point (or, for the secondary, of the sun) a
  disc covers rings, not strips: what that adds to the factor of the sine, as a complex number.

No axis is a radius, so nothing is interpolated between radii: fringes move as a^(-2/3), and a
plain grid over radius loses 10-30 % of the bow's peak between its nodes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rtbow.base.arrays import Array, floats
from rtbow.base.cache import cached_arrays, source_digest
from rtbow.physics.drop.airy import RADIUS_POWER, SCALE_POWER, Bow, airy_squared_and_integral
from rtbow.physics.light.disc import disc_nodes

# --- Layout, shared with the shader through :func:`shader_constants` --------------------------

NEAR_Z_LOW = -9.0
"""Below, Ai² is under 1e-16 of its peak: zero."""
NEAR_Z_HIGH = 11.0
"""Above, the asymptotic form holds."""
NEAR_WIDENING = 2.5
"""Growth of the near rows' upper end with the disc: the far form wants fringes well inside."""
NEAR_COLUMNS = 1536
NEAR_ROWS = 192
MAX_DISC = 24.0
"""Largest scaled disc radius with a row. On discs so wide only Descartes' caustic is left, which
scales: G(z, s) = sqrt(k) G(k z, k s); wider ones are looked up through k = MAX_DISC / s."""
NEAR_S_FIXED = MAX_DISC * (55.0 / (NEAR_ROWS - 1.0)) ** 2
"""Up to this disc (1.99) the near rows all span the same z, so that fringes line up between rows;
wider discs have no fringes left, and their rows widen with the disc. It is a row's own disc: rows
that are mixed are then all of one kind."""

MAX_PHASE = 96.0
"""Fringe phase across the disc's radius, rad, beyond which the fringes are gone."""
FRINGE_SIZE = 1024
POLE_DISTANCE = 24.0
"""In disc radii: how far from the pole the rings matter."""
POLE_ROWS = 128
POLE_COLUMNS = 256


def shader_constants() -> dict[str, float]:
    """Give the layout's numbers under the names that ``drop/airy.glsl`` uses."""
    return {
        "AIRY_NEAR_Z_LOW": NEAR_Z_LOW,
        "AIRY_NEAR_Z_HIGH": NEAR_Z_HIGH,
        "AIRY_NEAR_S_FIXED": NEAR_S_FIXED,
        "AIRY_NEAR_WIDENING": NEAR_WIDENING,
        "AIRY_NEAR_COLUMNS": float(NEAR_COLUMNS),
        "AIRY_NEAR_ROWS": float(NEAR_ROWS),
        "AIRY_MAX_DISC": MAX_DISC,
        "AIRY_MAX_PHASE": MAX_PHASE,
        "AIRY_FRINGE_SIZE": float(FRINGE_SIZE),
        "AIRY_POLE_DISTANCE": POLE_DISTANCE,
        "AIRY_POLE_ROWS": float(POLE_ROWS),
        "AIRY_POLE_COLUMNS": float(POLE_COLUMNS),
    }


def _disc_of_row(q: Array) -> Array:
    # Rows dense where fringes still show.
    return MAX_DISC * q**2


def _row_of_disc(s: Array) -> Array:
    return floats(np.sqrt(s / MAX_DISC))


def _near_span(s: Array) -> tuple[Array, Array]:
    """Give the z range of the near rows for discs ``s``."""
    wide = np.maximum(s - NEAR_S_FIXED, 0.0)
    return NEAR_Z_LOW - NEAR_S_FIXED - wide, NEAR_Z_HIGH + NEAR_WIDENING * wide


def near_z_high(s: float) -> float:
    """Give the z up to which look-ups for a disc ``s`` use the near rows."""
    return float(_near_span(floats(s))[1])


_LINE_STEP = 4e-3


def _on_line(values: Array, start: float, z: Array) -> Array:
    """Interpolate linearly between values that start at ``start``, ``_LINE_STEP`` apart."""
    # np.interp searches for each z; here its place is known.
    at = (z - start) / _LINE_STEP
    index = at.astype(np.int32)
    left = values[index]
    return floats(left + (at - index) * (values[index + 1] - left))


def _build_near() -> Array:
    s = _disc_of_row(np.linspace(0.0, 1.0, NEAR_ROWS))
    low, high = _near_span(s)
    # Both functions once on a line fine enough that linear interpolation errs by 1e-5 at most.
    line = np.arange(low[-1] - MAX_DISC, high[-1] + MAX_DISC + 1.0, _LINE_STEP)
    value, integral = airy_squared_and_integral(line)
    v = np.linspace(0.0, 1.0, NEAR_COLUMNS)
    near = np.empty((NEAR_ROWS, NEAR_COLUMNS, 2))
    for row, disc in enumerate(s):
        z = (low[row] + (high[row] - low[row]) * v)[:, None]
        # Midpoints in the angle whose cosine runs across the disc: its chords as the weight.
        count = 12 + int(8.0 * disc)
        angle = (np.arange(count) + 0.5) * np.pi / count
        chord = 2.0 / count * np.sin(angle) ** 2
        at = z + disc * np.cos(angle)
        running = _on_line(integral, line[0], at)
        near[row, :, 1] = running @ chord
        if disc < NEAR_S_FIXED:
            near[row, :, 0] = _on_line(value, line[0], at) @ chord
        else:
            # By parts, on the integral, whose fringes are far weaker: the nodes need to follow
            # the bow alone.
            near[row, :, 0] = running @ (2.0 / (disc * count) * np.cos(angle))
    return near


def _build_fringe() -> Array:
    from scipy.special import jv

    # Any phase will do for the first entry, which is J = 1 and B = 0.
    phase = np.maximum(np.linspace(0.0, MAX_PHASE, FRINGE_SIZE), 1e-3)
    # (J1/P)' = -J2/P and (J2/P)' = J1/P - 3 J2/P²: derivatives of Bessel functions.
    factor = 2.0 * jv(1, phase) / phase
    slope = -2.0 * jv(2, phase) / phase
    bend = -2.0 * (jv(1, phase) / phase - 3.0 * jv(2, phase) / phase**2)
    return np.stack([factor, 0.25 * phase * slope - 0.125 * phase**2 * bend], axis=1)


def _build_pole(fringe: Array) -> Array:
    phase = np.linspace(0.0, MAX_PHASE, POLE_COLUMNS)
    flat = np.interp(phase, np.linspace(0.0, MAX_PHASE, FRINGE_SIZE), fringe[:, 0])
    pole = np.zeros((POLE_ROWS, POLE_COLUMNS, 2))
    for row, q in enumerate(np.linspace(0.0, 1.0, POLE_ROWS)):
        distance = POLE_DISTANCE * q**2
        # A disc of 1e-4 rad: the plane, on the sphere's own quadrature.
        unit = 1e-4
        angle, weight = disc_nodes(distance * unit, unit, 64)
        kernel = np.exp(1j * np.outer(phase, angle / unit - distance)) @ weight - flat
        # Faded out over the last part, so that nothing steps at its end.
        kernel *= np.clip((1.0 - q) / 0.1, 0.0, 1.0)
        pole[row, :, 0], pole[row, :, 1] = kernel.real, kernel.imag
    return pole


@dataclass(frozen=True)
class _Fringes:
    """Fringes far inside the bow: amplitude, phase, and what the disc leaves of them."""

    z: Array
    amplitude: Array
    psi: Array
    phase: Array
    damping: Array
    sine: Array
    cosine: Array


@dataclass(frozen=True)
class AiryTable:
    """The table's arrays, and look-ups that follow the shader's step by step.

    Attributes:
        near: disc means of Ai² and of its integral (rows of disc, columns of z, 2), float32.
        fringe: J and B of the fringes (phase, 2), float32.
        pole: its complex change near the pole (distance, phase, 2), float32.
    """

    near: NDArray[np.float32]
    fringe: NDArray[np.float32]
    pole: NDArray[np.float32]

    def mean_airy_squared(self, z: Array, s: Array, pole_distance: Array) -> Array:
        """Look up the disc mean of Ai²(-z).

        Args:
            z: scaled angle into the bright side.
            s: scaled disc radius, 0 or more.
            pole_distance: angle from the pole in disc radii (large when there is no disc).

        Returns:
            The mean, shape of the broadcast arguments.
        """
        z, s, distance = np.broadcast_arrays(z, s, pole_distance)
        shrink = MAX_DISC / np.maximum(s, MAX_DISC)
        z, s = z * shrink, s * shrink
        fringes = self._fringes(z, s)
        # The disc's mean of 1/sqrt(z) is greater than at its centre, in first order by this.
        caustic = 1.0 + 3.0 / 32.0 * (s / fringes.z) ** 2
        far = fringes.amplitude * (caustic + fringes.sine)
        value = np.where(z < _near_span(s)[1], self._near(0, z, s), far)

        close = (distance < POLE_DISTANCE) & (z > 1.0)
        if np.any(close):
            d, p = np.sqrt(distance[close] / POLE_DISTANCE), fringes.phase[close] / MAX_PHASE
            real = _bilinear(self.pole[..., 0], d, p)
            imag = _bilinear(self.pole[..., 1], d, p)
            psi = fringes.psi[close]
            value = np.array(value)
            value[close] += fringes.amplitude[close] * (np.sin(psi) * real - np.cos(psi) * imag)
        return np.asarray(np.sqrt(shrink) * value)

    def running_airy_squared(self, z: Array, s: Array) -> Array:
        """Look up the disc mean of the integral of Ai²(-z) from the shadow up to z.

        Differences of it are exact means over a range of angles, however many fringes lie there.
        The rings about the poles are left out: they matter within a few disc radii only, where a
        lamp's light, which comes under all angles, is smeared out anyway.

        Args:
            z: scaled angle into the bright side.
            s: scaled disc radius, 0 or more.

        Returns:
            The mean of the integral, shape of the broadcast arguments.
        """
        z, s = np.broadcast_arrays(z, s)
        shrink = MAX_DISC / np.maximum(s, MAX_DISC)
        z, s = z * shrink, s * shrink
        fringes = self._fringes(z, s)
        safe, cubed = fringes.z, fringes.z**1.5
        # By parts from (1 + sin(psi)) / (2 pi sqrt(z)), to the third order in z^(-3/2).
        far = (
            np.sqrt(safe) / np.pi * (1.0 - (s / safe) ** 2 / 32.0 + 1.0 / (32.0 * safe**3))
            - fringes.cosine / (4.0 * np.pi * safe)
            - fringes.damping * np.sin(fringes.psi) / (8.0 * np.pi * safe * cubed)
        )
        value = np.where(z < _near_span(s)[1], self._near(1, z, s), far)
        return np.asarray(value / np.sqrt(shrink))

    def _near(self, channel: int, z: Array, s: Array) -> Array:
        low, high = _near_span(s)
        return _bilinear(self.near[..., channel], _row_of_disc(s), (z - low) / (high - low))

    def _fringes(self, z: Array, s: Array) -> _Fringes:
        safe = np.maximum(z, 1.0)
        root, cubed = np.sqrt(safe), safe**1.5
        psi = 4.0 / 3.0 * cubed - 5.0 / (24.0 * cubed)
        phase = np.minimum(2.0 * root * s, MAX_PHASE)
        phases = np.linspace(0.0, MAX_PHASE, FRINGE_SIZE)
        damping, bend = (np.interp(phase, phases, self.fringe[:, k]) for k in range(2))
        return _Fringes(
            z=safe,
            amplitude=0.5 / (np.pi * root),
            psi=psi,
            phase=phase,
            damping=damping,
            sine=damping * np.sin(psi) + bend / cubed * np.cos(psi),
            cosine=damping * np.cos(psi) - bend / cubed * np.sin(psi),
        )

    def cross_section(
        self, bow: Bow, component: Array, radius_m: Array, theta_rad: Array, disc_rad: float
    ) -> Array:
        """Look up one bow's differential cross-section.

        Args:
            bow: the bow, with W wavelengths.
            component: its strength to use, ``perpendicular``, ``parallel`` or their mean, (W,).
            radius_m: drop radii (R,), m.
            theta_rad: scattering angles (T,), rad.
            disc_rad: angular radius of the light's disc, rad.

        Returns:
            |S|²/k² in m² sr⁻¹, shape (R, W, T).
        """
        a = np.asarray(radius_m, dtype=np.float64)[:, None, None]
        theta = np.asarray(theta_rad, dtype=np.float64)[None, None, :]
        scale = bow.scale[None, :, None] * a**SCALE_POWER
        excess = bow.side * (theta - bow.angle_rad[None, :, None])
        distance = np.abs(theta - bow.pole_rad) / max(disc_rad, 1e-12)
        mean = self.mean_airy_squared(scale * excess, scale * disc_rad, distance)
        return np.asarray(component[None, :, None] * a**RADIUS_POWER * mean)


def _linear(rows: NDArray[np.float32], index: NDArray[np.int64], v: Array) -> Array:
    """Interpolate along the columns of given rows."""
    column = np.clip(v, 0.0, 1.0) * (rows.shape[1] - 1)
    left = np.clip(column.astype(np.int64), 0, rows.shape[1] - 2)
    f = column - left
    return floats(rows[index, left] * (1.0 - f) + rows[index, left + 1] * f)


def _bilinear(grid: NDArray[np.float32], u: Array, v: Array) -> Array:
    row = np.clip(u, 0.0, 1.0) * (grid.shape[0] - 1)
    index = np.clip(row.astype(np.int64), 0, grid.shape[0] - 2)
    f = row - index
    return floats(_linear(grid, index, v) * (1.0 - f) + _linear(grid, index + 1, v) * f)


def build_airy_table() -> AiryTable:
    """Compute the table from Airy's function, in float64, stored as float32."""
    fringe = _build_fringe()
    return AiryTable(
        near=_build_near().astype(np.float32),
        fringe=fringe.astype(np.float32),
        pole=_build_pole(fringe).astype(np.float32),
    )


def airy_table() -> AiryTable:
    """Give the table, from the cache where it lies there already."""
    # By content: whatever these modules compute differently makes another table.
    key = f"airy {source_digest('physics.drop', 'physics.light.disc', 'tables.airy')}"

    def build() -> dict[str, NDArray[np.float32]]:
        table = build_airy_table()
        return {"near": table.near, "fringe": table.fringe, "pole": table.pole}

    return AiryTable(**cached_arrays("airy", key, build))
