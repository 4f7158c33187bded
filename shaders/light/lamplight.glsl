#include "common/definitions.glsl"
#include "light/lamp_ray.glsl"
#include "rain/extinction.glsl"

// Light of a lamp near by over one step in the angle at the lamp (light/lamp_ray.glsl). Needs a theory
// before it: drop/airy_theory.glsl or drop/table_theory.glsl.

#if LAMP_COUNT
// One step's light over all wavelengths, per drop density and per integral of dt / d^2. `lit`: the
// bows that are not dark.
Tristimulus lampLight(sampler2D spectral, Theory theory, int light, vec2 theta, Angle disc,
                      Length radius, Column column, Number depth, Number rise, ivec2 lit,
                      Number perpendicular) {
    Tristimulus sum = vec3(0.0);
    vec2 terms = radiusTerms(theory, radius);
    for (int w = 0; w < WAVELENGTH_COUNT; ++w) {
        vec4 weight = texelFetch(spectral, ivec2(w, FIRST_LIGHT_ROW + SUN_COUNT + light), 0);
        CrossSection value = meanSection(spectral, theory, w, terms, theta, disc, lit, perpendicular);
#if ATTENUATION
        value *= attenuation(spectral, w, weight.a, column, depth, rise, 0.0);
#endif
        sum += value * weight.rgb;
    }
    return sum;
}
#endif
