#include "common/definitions.glsl"
#include "common/math.glsl"
#include "drop/phase.glsl"
#include "rain/extinction.glsl"
#include "light/lamp_ray.glsl"

// Light of a lamp near by over one step in the angle at the lamp (light/lamp_ray.glsl).

#if LAMP_COUNT
// Mean cross-section over a step between two scattering angles.
#if TABLE
CrossSection meanSection(SECTION_PARAMETERS, int layer, vec2 radius, vec2 theta, Angle disc,
                         Number perpendicular) {
    // The disc's chords have the second and fourth moments of two even ranges, of half the width
    // across the diagonal and of the whole; each is widened by the step.
    Angle span = theta.y - theta.x;
    Angle middle = 0.5 * (theta.x + theta.y);
    CrossSection mean = 0.0;
    for (int k = 1; k <= 2; ++k) {
        Angle wide = sign(span) * sqrt(span * span + 2.0 * float(k) * disc * disc);
        vec2 range = clamp(middle + vec2(-0.5, 0.5) * wide, 0.0, PI);
        mean += 0.5 * sectionMean(sections, angles, range, radius, layer, perpendicular);
    }
    return mean;
}
#else
CrossSection meanSection(sampler2D near, sampler2D fringe, Bow bow, Number side, vec2 powers,
                         vec2 theta, Angle disc) {
    Number scale = bow.scale * powers.x;
    Number from = scale * side * (theta.x - bow.angle);
    Number to = scale * side * (theta.y - bow.angle);
    Number span = to - from;
    Number wide = scale * disc;
    Number mean = abs(span) > 0.1
        ? (airyRunning(near, fringe, to, wide) - airyRunning(near, fringe, from, wide)) / span
        : airyMean(near, fringe, near, 0.5 * (from + to), wide, 1.0e9);
    return bow.strength * powers.y * mean;
}
#endif

#if !TABLE
// First and last bow that are not dark somewhere between two angles.
ivec2 litBows(vec2 theta, Angle disc, Angle edge[BOW_COUNT]) {
    ivec2 lit = ivec2(BOW_COUNT, -1);
    for (int b = 0; b < BOW_COUNT; ++b) {
        Angle bright = BOW_SIDE[b] > 0.0 ? theta.y : theta.x;
        if (BOW_SIDE[b] * (bright - edge[b]) + disc > 0.0) {
            lit.x = min(lit.x, b);
            lit.y = b;
        }
    }
    return lit;
}
#endif

// One step's light over all wavelengths, per drop density and per integral of dt / d^2. `lit`: the
// bows that are not dark.
Tristimulus lampLight(sampler2D spectral, SECTION_PARAMETERS, int light, vec2 theta, Angle disc,
                      Length radius, Column column, Number depth, Number rise, ivec2 lit,
                      Number perpendicular) {
    Tristimulus sum = vec3(0.0);
    vec2 terms = RADIUS_TERMS(radius);
    for (int w = 0; w < WAVELENGTH_COUNT; ++w) {
        vec4 weight = texelFetch(spectral, ivec2(w, FIRST_LIGHT_ROW + SUN_COUNT + light), 0);
#if TABLE
        CrossSection value = meanSection(SECTION_ARGUMENTS, w, terms, theta, disc, perpendicular);
#else
        CrossSection value = 0.0;
        int b = lit.x;
        do {
            Bow bow = bowAt(spectral, w, b, perpendicular);
            value += meanSection(near, fringe, bow, BOW_SIDE[b], terms, theta, disc);
        } while (++b <= lit.y);
#endif
#if ATTENUATION
        value *= attenuation(spectral, w, weight.a, column, depth, rise);
#endif
        sum += value * weight.rgb;
    }
    return sum;
}
#endif
