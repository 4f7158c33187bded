"""What is accepted anywhere, and what is asked for by default."""

MAX_DENSITY_PER_M3 = 1e12
"""Number densities accepted anywhere; the densest fog has some 1e9."""
MAX_GRID_POINTS = 512**3
"""Points of a volume: two float32 moments of each are 1 GiB."""

MAX_COORDINATE_M = 1e7
"""Eyes, lamps and boxes lie within this distance of the origin along each axis: every scene on
Earth, and squares of lengths still fit in float32."""
DEEPEST_AIR_M = -1e5
"""Where there is air, nothing lies lower than this: the density there is 3e5 times that at sea
level, and light gets no farther than some metres."""
TOP_M = 100_000.0
"""Where the air that glows ends: 4e-6 of its molecules are above."""
GROUND_HEIGHTS_M = (-500.0, 8000.0)
"""Heights of the ground: the Dead Sea's shore, and the highest peaks below their tops."""
PRESSURES_HPA = (100.0, 1100.0)
"""Pressures at height 0: that at 16 km, and more than was ever measured."""
MOST_AEROSOL_DEPTH = 2.0
"""Vertical optical depth of aerosol up to which the sky holds its error; beyond are dust storms."""
HIGHEST_SKY_M = 15_000.0
"""Eyes up to which tables of a sky hold a shader's error: CIEDE2000 0.13 at 12 km, 1.6 at 40 km."""
STANDS_M = 1.0
"""A box of drops whose floor is at most this high above the ground stands on it."""
LEAST_EXTENT_M = 1e-3
"""A box that is thinner along any axis is a mistake: it holds no drop."""
LEAST_SHARE_OF_DISTANCE = 2e-5
"""A shader knows the faces of a box to 6e-8 of their distance from the eye along an axis, and a way
through it to four times that: through a box this share of the distance thick, to 1.2 %."""

LEAST_FOV_DEG = 1e-6
"""A narrower picture is of one ray: a tenth of this turns no direction in float32."""

MIN_RADIUS_UM = 1.0
MAX_RADIUS_UM = 5000.0
"""Drop radii accepted anywhere, µm; raindrops break up well before the upper end."""
TABLE_RADII_UM = (MIN_RADIUS_UM, 1500.0)
"""Radii of the whole table of exact theory; larger ones are built when a scene asks for them."""

MAX_DISC_DEG = 5.0
"""Discs accepted anywhere, across."""
WATER_C = (-12.0, 60.0)
"""Temperatures of water accepted anywhere; supercooled drops below 0."""
SALINITIES_G_KG = (0.0, 40.0)
"""Salinities accepted anywhere: the formula's 0..35, and by its straight line the saltiest seas."""
SALT_WATER_C = (0.0, 30.0)
"""Temperatures over which the index of sea water is known."""
INDICES = (1.2, 1.9)
"""Refractive indices accepted instead of water's: with both bows where their equations have them,
and the primary at least 1.5 degrees from the antisolar point."""
SIZE_SPREADS = (0.01, 0.2)
"""Standard deviations of ln(radius) about each size that exact tables are built for."""
NO_PLANE = 1e-9
"""Square of the angle (rad²) from the line through a light within which there is no scattering
plane to speak of: both components count alike."""

DEFAULT_DELTA_E = 0.5
"""Colour difference (CIEDE2000, 99th percentile) allowed to method fast: half of what is just
noticeable side by side."""
LEAST_DELTA_E = 0.25
"""The least one that its settings exist for."""
MOST_DELTA_E = 20.0
