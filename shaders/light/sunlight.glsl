#include "common/definitions.glsl"
#include "rain/extinction.glsl"
#include "air/earth_shadow.glsl"

// Sunlight is parallel: the scattering angle is one along a ray (paper, section 5.2). Needs a theory
// before it: drop/airy_theory.glsl or drop/table_theory.glsl.

#if SUN_COUNT
struct Sun {
    Direction towards;
    Angle altitude;
    Angle disc;            // angular radius
    int layer;             // first layer of a table that is averaged over such a disc
#if PIECES > 1
    bool shaded;           // the Earth keeps it from some of the drops
    EarthShadow shadow;
#endif
};

// Cross-section of a pixel: the mean over its points.
CrossSection pixelSection(sampler2D spectral, Theory theory, int wavelength, vec2 terms, SunView sun) {
#if PIXEL_POINTS
    CrossSection sum = 0.0;
    for (int k = 0; k < PIXEL_POINTS; ++k) {
        sum += crossSection(spectral, theory, wavelength, terms, atPoint(sun, k));
    }
    return sum / float(PIXEL_POINTS);
#else
    return crossSection(spectral, theory, wavelength, terms, sun);
#endif
}

#if ONE_RADIUS && ATTENUATION
// With drops of one radius a pixel needs its cross-sections once, whatever the steps.
struct Sections {
    float at[WAVELENGTH_COUNT];
};

Sections crossSections(sampler2D spectral, Theory theory, SunView sun, Length radius) {
    vec2 terms = radiusTerms(theory, radius);
    Sections sections;
    for (int w = 0; w < WAVELENGTH_COUNT; ++w) {
        sections.at[w] = pixelSection(spectral, theory, w, terms, sun);
    }
    return sections;
}

// One sample's light over all wavelengths, per metre of ray and per drop density, from cross-sections.
Tristimulus attenuatedLight(sampler2D spectral, int light, Sections sections, Column column,
                            Number depth, Number rise, Number haze) {
    Tristimulus sum = vec3(0.0);
    for (int w = 0; w < WAVELENGTH_COUNT; ++w) {
        vec4 weight = texelFetch(spectral, ivec2(w, FIRST_LIGHT_ROW + light), 0);
        sum += sections.at[w] * attenuation(spectral, w, weight.a, column, depth, rise, haze) * weight.rgb;
    }
    return sum;
}
#endif

// One sample's light over all wavelengths, per metre of ray and per drop density, from the radius of
// its drops.
Tristimulus scatteredLight(sampler2D spectral, Theory theory, int light, SunView sun,
                           Length radius, Column column, Number depth, Number rise, Number haze) {
    vec2 terms = radiusTerms(theory, radius);
    Tristimulus sum = vec3(0.0);
    for (int w = 0; w < WAVELENGTH_COUNT; ++w) {
        vec4 weight = texelFetch(spectral, ivec2(w, FIRST_LIGHT_ROW + light), 0);
        Number value = pixelSection(spectral, theory, w, terms, sun);
#if ATTENUATION
        value *= attenuation(spectral, w, weight.a, column, depth, rise, haze);
#endif
        sum += value * weight.rgb;
    }
    return sum;
}
#endif
