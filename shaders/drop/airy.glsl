#include "common/definitions.glsl"
#include "common/math.glsl"

// Ai^2(-z) averaged over the light's disc (rtbow/tables/airy.py builds the three textures and says what
// they hold). z: scaled angle into the bright side; disc: the disc's radius in the same scale.

// WIDE: some disc's rows span more than the common range of z, or is beyond the table. Divisions and
// roots are what a look-up costs on a CPU, so that code is left out where no disc is so wide.

// z range of a row of the near texture.
vec2 airyNearSpan(Number disc) {
    vec2 span = vec2(AIRY_NEAR_Z_LOW - AIRY_NEAR_S_FIXED, AIRY_NEAR_Z_HIGH);
#if WIDE
    span += max(disc - AIRY_NEAR_S_FIXED, 0.0) * vec2(-1.0, AIRY_NEAR_WIDENING);
#endif
    return span;
}

// Wider discs than the table's leave only Descartes' caustic, which scales: both arguments shrink.
Number airyShrink(Number disc) {
#if WIDE
    return AIRY_MAX_DISC / max(disc, AIRY_MAX_DISC);
#else
    return 1.0;
#endif
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
    Number root;           // of z, which is at least 1 here
    Number inverse;        // z^(-3/2)
    Angle psi;
    Number phase;          // across the disc's radius, share of AIRY_MAX_PHASE
    Number damping;        // what the disc leaves of the fringes
    Number bend;           // what the narrowing of fringes across the disc adds
};

Fringes airyFringes(sampler2D fringe, Number z, Number disc) {
    Number safe = max(z, 1.0);
    Number root = sqrt(safe);
    Number inverse = 1.0 / (safe * root);
    Angle psi = 4.0 / 3.0 * safe * root - 5.0 / 24.0 * inverse;
    // Brought near 0 first: sine keeps few digits of thousands of radians.
    psi -= 2.0 * PI * floor(psi * (0.5 / PI) + 0.5);
#if DISC
    Number phase = 2.0 / AIRY_MAX_PHASE * root * disc;
    // Two fetches by hand: a filtered one of a texture one texel high would read four texels.
    Number column = min(phase, 1.0) * (AIRY_FRINGE_SIZE - 1.0);
    int left = int(min(column, AIRY_FRINGE_SIZE - 2.0));
    vec2 f = mix(texelFetch(fringe, ivec2(left, 0), 0).rg,
                 texelFetch(fringe, ivec2(left + 1, 0), 0).rg, column - float(left));
    return Fringes(root, inverse, psi, phase, f.x, f.y * inverse);
#else
    return Fringes(root, inverse, psi, 0.0, 1.0, 0.0);
#endif
}

// Ai^2(-z) averaged over the disc. `rtbow table info` measures the worst errors: 0.02 % of the bow's
// peak without a disc, 0.2 % with the sun's, 1 % with any up to 5 degrees across.
// poleDistance, in disc radii: where the disc covers rings about the axis instead of strips.
Number airyMean(sampler2D near, sampler2D fringe, sampler2D pole,
                Number z, Number disc, Number poleDistance) {
    Number shrink = airyShrink(disc);
    z *= shrink;
    disc *= shrink;
    Fringes f = airyFringes(fringe, z, disc);
    Number amplitude = 0.5 / PI * f.root * f.root * f.inverse;
    // The disc's mean of 1/sqrt(z) is greater than at its centre, in first order by this.
    Number wide = disc * f.root * f.inverse;
    Number value = z < airyNearSpan(disc).y
        ? airyNear(near, z, disc).r
        : amplitude * (1.0 + 3.0 / 32.0 * wide * wide + f.damping * sin(f.psi)
                       + f.bend * cos(f.psi));
#if POLE && DISC
    if (poleDistance < AIRY_POLE_DISTANCE && z > 1.0) {
        vec2 at = vec2(texelCentred(f.phase, AIRY_POLE_COLUMNS),
                       texelCentred(sqrt(poleDistance / AIRY_POLE_DISTANCE), AIRY_POLE_ROWS));
        vec2 ring = textureLod(pole, at, 0.0).rg;
        value += amplitude * (sin(f.psi) * ring.r - cos(f.psi) * ring.g);
    }
#endif
#if WIDE
    value *= sqrt(shrink);
#endif
    return value;
}

#if LAMP_COUNT
// The integral of Ai^2(-z) from the shadow up to z, averaged over the disc: within 2.4e-4 where it is
// of order 1, and 2e-6 of itself beyond (float32); discs beyond the table scale. Without the rings
// about the poles, which matter within a few disc radii only.
Number airyRunning(sampler2D near, sampler2D fringe, Number z, Number disc) {
    Number shrink = airyShrink(disc);
    z *= shrink;
    disc *= shrink;
    Fringes f = airyFringes(fringe, z, disc);
    // (1 + sin psi) / (2 pi sqrt z) by parts, to the third order in z^(-3/2).
    Number wide = disc * f.root * f.inverse;
    Number cosine = f.damping * cos(f.psi) - f.bend * sin(f.psi);
    Number value = z < airyNearSpan(disc).y
        ? airyNear(near, z, disc).g
        : f.root / PI * (1.0 + (f.inverse * f.inverse - wide * wide) / 32.0)
            - f.root * f.inverse / (8.0 * PI) * (2.0 * cosine + f.damping * f.inverse * sin(f.psi));
#if WIDE
    value *= inversesqrt(shrink);
#endif
    return value;
}
#endif
