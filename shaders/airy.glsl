#include "definitions.glsl"
#include "math.glsl"

// Ai^2(-z) averaged over the light's disc (rtbow/table.py builds the three textures and says what
// they hold). z: scaled angle into the bright side; disc: the disc's radius in the same scale.

// z range of a row of the near texture.
vec2 airyNearSpan(Number disc) {
    Number wide = max(disc - AIRY_NEAR_S_FIXED, 0.0);
    return vec2(AIRY_NEAR_Z_LOW - AIRY_NEAR_S_FIXED - wide, AIRY_NEAR_Z_HIGH + 1.5 * wide);
}

// Around the bow.
Number airyNear(sampler2D near, Number z, Number disc) {
    vec2 span = airyNearSpan(disc);
    Number column = texelCentred((z - span.x) / (span.y - span.x), AIRY_NEAR_COLUMNS);
#if DISC
    Number row = texelCentred(sqrt(disc / AIRY_MAX_DISC), AIRY_NEAR_ROWS);
#else
    Number row = 0.5 / AIRY_NEAR_ROWS;
#endif
    return textureLod(near, vec2(column, row), 0.0).r;
}

// Far inside: fringes of phase psi about a mean, damped by the disc. Worst error 0.05 % of the
// bow's peak without a disc, 0.2 % with the sun's, 0.4 % with any.
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
        vec2 f = textureLod(fringe, vec2(texelCentred(phase, AIRY_FRINGE_SIZE), 0.5), 0.0).rg;
        // The disc's mean of 1/sqrt(z) is greater than at its centre, in first order by this.
        Number caustic = 1.0 + 3.0 / 32.0 * (disc / z) * (disc / z);
        value = amplitude * (caustic + f.x * sin(psi) + f.y / cubed * cos(psi));
#else
        value = amplitude * (1.0 + sin(psi));
#endif
    }
#if POLE
    if (poleDistance < AIRY_POLE_DISTANCE && z > 1.0) {
        vec2 at = vec2(texelCentred(phase, AIRY_POLE_COLUMNS),
                       texelCentred(sqrt(poleDistance / AIRY_POLE_DISTANCE), AIRY_POLE_ROWS));
        vec2 ring = textureLod(pole, at, 0.0).rg;
        value += amplitude * (sin(psi) * ring.r - cos(psi) * ring.g);
    }
#endif
    return sqrt(shrink) * value;
}
