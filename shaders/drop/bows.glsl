#include "common/definitions.glsl"
#include "common/math.glsl"
#include "drop/airy.glsl"

// One bow at one wavelength, from its row of the spectral texture: Descartes' angle, scale, and its
// strength (of both components where there is a polariser, else their mean).
struct Bow {
    Angle angle;
    Number scale;
    Number strength;
};

Bow bowAt(sampler2D spectral, int wavelength, int order, Number perpendicular) {
    vec4 v = texelFetch(spectral, ivec2(wavelength, order), 0);
#if POLARIZER
    v.z = 0.5 * mix(v.w, v.z, perpendicular);
#endif
    return Bow(v.x, v.y, v.z);
}

// a^(2/3) and a^(7/3) carry the radius; everything else is per wavelength.
vec2 radiusPowers(Length radius) {
    return vec2(pow(radius, 2.0 / 3.0), radius * radius * pow(radius, 1.0 / 3.0));
}
