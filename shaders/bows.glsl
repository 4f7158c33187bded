#include "definitions.glsl"
#include "math.glsl"
#include "airy.glsl"

// Rows of the spectral texture, one column per wavelength: first one row per bow (Descartes' angle,
// scale, strength, -), then one per sun and one per
// lamp (weights to X, Y, Z, air depth).
struct Bow {
    Angle angle;
    Number scale;
    Number strength;
};

Bow bowAt(sampler2D spectral, int wavelength, int order) {
    vec4 v = texelFetch(spectral, ivec2(wavelength, order), 0);
    return Bow(v.x, v.y, v.z);
}

// a^(2/3) and a^(7/3) carry the radius; everything else is per wavelength.
vec2 radiusPowers(Length radius) {
    return vec2(pow(radius, 2.0 / 3.0), radius * radius * pow(radius, 1.0 / 3.0));
}
