#include "definitions.glsl"
#include "math.glsl"

// Ai^2(-z) averaged over the light's disc (rtbow/table.py builds the three textures and says what
// they hold). z: scaled angle into the bright side; disc: the disc's radius in the same scale.

// z range of a row of the near texture.
vec2 airyNearSpan(Number disc) {
    Number wide = max(disc - AIRY_NEAR_S_FIXED, 0.0);
    return vec2(AIRY_NEAR_Z_LOW - AIRY_NEAR_S_FIXED - wide, AIRY_NEAR_Z_HIGH + 1.5 * wide);
}

// Around the bow: the mean (r) and, where the texture holds it, its running integral (g).
vec2 airyNear(sampler2D near, Number z, Number disc) {
    vec2 span = airyNearSpan(disc);
    Number column = texelCentred((z - span.x) / (span.y - span.x), AIRY_NEAR_COLUMNS);
#if DISC
    Number row = texelCentred(sqrt(disc / AIRY_MAX_DISC), AIRY_NEAR_ROWS);
#else
    Number row = 0.5 / AIRY_NEAR_ROWS;
#endif
    return textureLod(near, vec2(column, row), 0.0).rg;
}

// Fringes far inside the bow: Ai^2(-z) = amplitude (1 + sin psi).
struct Fringes {
    Number z;              // at least 1
    Number root;           // of z
    Angle psi;
    Number phase;          // across the disc's radius, share of AIRY_MAX_PHASE
    Number damping;        // what the disc leaves of the fringes
    Number bend;           // and what their narrowing across it adds, times z^(-3/2)
};

Fringes airyFringes(sampler2D fringe, Number z, Number disc) {
    Number safe = max(z, 1.0);
    Number root = sqrt(safe);
    Number cubed = safe * root;
    Angle psi = 4.0 / 3.0 * cubed - 5.0 / (24.0 * cubed);
    // Brought near 0 first: sine keeps few digits of thousands of radians.
    psi -= 2.0 * PI * floor(psi / (2.0 * PI) + 0.5);
#if DISC
    Number phase = 2.0 * root * disc / AIRY_MAX_PHASE;
    vec2 f = textureLod(fringe, vec2(texelCentred(phase, AIRY_FRINGE_SIZE), 0.5), 0.0).rg;
    return Fringes(safe, root, psi, phase, f.x, f.y / cubed);
#else
    return Fringes(safe, root, psi, 0.0, 1.0, 0.0);
#endif
}

// Ai^2(-z) averaged over the disc. Worst error 0.02 % of the bow's peak without a disc, 0.12 % with
// the sun's, 0.9 % with any.
// poleDistance, in disc radii: where the disc covers rings about the axis instead of strips.
Number airyMean(sampler2D near, sampler2D fringe, sampler2D pole,
                Number z, Number disc, Number poleDistance) {
    // Wider discs than the table's leave only Descartes' caustic, which scales.
    Number shrink = AIRY_MAX_DISC / max(disc, AIRY_MAX_DISC);
    z *= shrink;
    disc *= shrink;
    Fringes f = airyFringes(fringe, z, disc);
    Number amplitude = 0.5 / (PI * f.root);
    Number value;
    if (z < airyNearSpan(disc).y) {
        value = airyNear(near, z, disc).r;
    } else {
        // The disc's mean of 1/sqrt(z) is greater than at its centre, in first order by this.
        Number caustic = 1.0 + 3.0 / 32.0 * (disc / z) * (disc / z);
        value = amplitude * (caustic + f.damping * sin(f.psi) + f.bend * cos(f.psi));
    }
#if POLE
    if (poleDistance < AIRY_POLE_DISTANCE && z > 1.0) {
        vec2 at = vec2(texelCentred(f.phase, AIRY_POLE_COLUMNS),
                       texelCentred(sqrt(poleDistance / AIRY_POLE_DISTANCE), AIRY_POLE_ROWS));
        vec2 ring = textureLod(pole, at, 0.0).rg;
        value += amplitude * (sin(f.psi) * ring.r - cos(f.psi) * ring.g);
    }
#endif
    return sqrt(shrink) * value;
}

#if LAMP_COUNT
// The integral of Ai^2(-z) from the shadow up to z, averaged over the disc: 4e-4 at the most, where
// it is of order 1. Without the rings about the poles, which matter within a few disc radii only.
Number airyRunning(sampler2D near, sampler2D fringe, Number z, Number disc) {
    Number shrink = AIRY_MAX_DISC / max(disc, AIRY_MAX_DISC);
    z *= shrink;
    disc *= shrink;
    Number value;
    if (z < airyNearSpan(disc).y) {
        value = airyNear(near, z, disc).g;
    } else {
        // (1 + sin psi) / (2 pi sqrt z) by parts, to the third order in z^(-3/2).
        Fringes f = airyFringes(fringe, z, disc);
        Number wide = disc / z;
        value = f.root / PI * (1.0 - wide * wide / 32.0 + 1.0 / (32.0 * z * z * z))
            - (f.damping * cos(f.psi) - f.bend * sin(f.psi)) / (4.0 * PI * z)
            - f.damping * sin(f.psi) / (8.0 * PI * z * z * f.root);
    }
    return value * inversesqrt(shrink);
}
#endif
