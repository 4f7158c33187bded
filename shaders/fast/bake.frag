#include "drop/airy_theory.glsl"

// Colours of drops under a light of one spectrum: a texel sums one scattering angle and radius over
// all wavelengths, once for each column of air and depth of rain that `light` has rows for.

uniform sampler2D spectral;         // rows of bows, as method `spectral` has them
uniform sampler2D light;            // X, Y, Z per wavelength; a row per outcome
uniform sampler2D angles;           // scattering angle of each column
uniform sampler2D radii;            // radius of each row
uniform Theory theory;
uniform float discRadius;
uniform float component;            // share of the perpendicular one, with a polariser
uniform int firstRow;               // row of `radii` of the target's first one
uniform float perRadius;            // what is stored is divided by (radius / this)^RADIUS_POWER

layout(location = 0) out vec4 outcome[OUTCOMES];

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy);
    Angle theta = texelFetch(angles, ivec2(texel.x, 0), 0).r;
    SunView view = sunView(theory, theta, discRadius, 0, component);
    Tristimulus sums[OUTCOMES];
    for (int k = 0; k < OUTCOMES; ++k) sums[k] = vec3(0.0);
    if (!isDark(view)) {
        Length radius = texelFetch(radii, ivec2(firstRow + texel.y, 0), 0).r;
        vec2 terms = radiusTerms(theory, radius);
        for (int w = 0; w < WAVELENGTH_COUNT; ++w) {
            CrossSection value = crossSection(spectral, theory, w, terms, view);
            for (int k = 0; k < OUTCOMES; ++k) sums[k] += value * texelFetch(light, ivec2(w, k), 0).rgb;
        }
        Number scale = pow(perRadius / radius, RADIUS_POWER);
        for (int k = 0; k < OUTCOMES; ++k) sums[k] *= scale;
    }
    for (int k = 0; k < OUTCOMES; ++k) outcome[k] = vec4(sums[k], 1.0);
}
