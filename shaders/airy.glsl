#include "definitions.glsl"
#include "math.glsl"

// Ai^2(-z) averaged over the light's disc (rtbow/table.py builds the three textures and says what
// they hold). z: scaled angle into the bright side; disc: the disc's radius in the same scale.

const Number AIRY_DISC_SPAN = AIRY_DISC_EXP - 1.0;

// z range of a row of the near texture.
vec2 airyNearSpan(Number disc) {
    Number wide = max(disc - AIRY_NEAR_S_FIXED, 0.0);
    return vec2(AIRY_NEAR_Z_LOW - AIRY_NEAR_S_FIXED - wide, AIRY_NEAR_Z_HIGH + 1.5 * wide);
}

Number airyNearRow(sampler2D near, Number row, Number z) {
    Number disc = AIRY_MAX_DISC / AIRY_DISC_SPAN
        * (exp(AIRY_DISC_CURVE * row / (AIRY_NEAR_ROWS - 1.0)) - 1.0);
    vec2 span = airyNearSpan(disc);
    Number v = (z - span.x) / (span.y - span.x);
    return textureLod(near, vec2(texelCentred(v, AIRY_NEAR_COLUMNS), (row + 0.5) / AIRY_NEAR_ROWS),
                      0.0).r;
}

// Around the bow. Rows of different discs may span different z, so each is read on its own.
Number airyNear(sampler2D near, Number z, Number disc) {
#if DISC
    Number row = log(1.0 + disc * AIRY_DISC_SPAN / AIRY_MAX_DISC) / AIRY_DISC_CURVE
        * (AIRY_NEAR_ROWS - 1.0);
    Number below = min(floor(row), AIRY_NEAR_ROWS - 2.0);
    return mix(airyNearRow(near, below, z), airyNearRow(near, below + 1.0, z), row - below);
#else
    return airyNearRow(near, 0.0, z);
#endif
}

// Far inside: fringes of phase psi about a mean, damped by the disc; worst error 0.1 % of the peak.
// poleDistance, in disc radii: where the disc covers rings about the axis instead of strips.
Number airyMean(sampler2D near, sampler2D fringe, sampler2D pole,
                Number z, Number disc, Number poleDistance) {
    // Wider discs than the table's leave only Descartes' caustic, which scales.
    Number shrink = AIRY_MAX_DISC / max(disc, AIRY_MAX_DISC);
    z *= shrink;
    disc *= shrink;
    Number root = sqrt(max(z, 1.0));
    Number cubed = max(z, 1.0) * root;
    // Brought near 0 first: sine keeps few digits of thousands of radians.
    Angle psi = 4.0 / 3.0 * cubed - 5.0 / (24.0 * cubed);
    psi -= 2.0 * PI * floor(psi / (2.0 * PI) + 0.5);
    Number amplitude = 0.5 / (PI * root);
    Number value;
#if DISC
    Number phase = 2.0 * root * disc / AIRY_MAX_PHASE;
#endif
    if (z < airyNearSpan(disc).y) {
        value = airyNear(near, z, disc);
    } else {
#if DISC
        Number damping =
            textureLod(fringe, vec2(texelCentred(phase, AIRY_FRINGE_SIZE), 0.5), 0.0).r;
#else
        Number damping = 1.0;
#endif
        value = amplitude * (1.0 + damping * sin(psi));
    }
#if DISC
    if (poleDistance < AIRY_POLE_DISTANCE && z > 1.0) {
        vec2 at = vec2(texelCentred(phase, AIRY_POLE_COLUMNS),
                       texelCentred(sqrt(poleDistance / AIRY_POLE_DISTANCE), AIRY_POLE_ROWS));
        vec2 ring = textureLod(pole, at, 0.0).rg;
        value += amplitude * (sin(psi) * ring.r - cos(psi) * ring.g);
    }
#endif
    return sqrt(shrink) * value;
}
