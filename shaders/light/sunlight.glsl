#include "common/definitions.glsl"
#include "common/math.glsl"
#include "drop/phase.glsl"
#include "rain/extinction.glsl"

// Sunlight is parallel: the scattering angle is one along a ray (paper, section 5.2).

#if SUN_COUNT
// Everything about a light at one pixel that does not change along the ray.
struct SunView {
    Angle theta;            // scattering angle, 0 = forward
    Angle altitude;
    Number perpendicular;   // share of that component, with a polariser
#if TABLE
    Number place;           // of theta along the table's angles
    int layer;              // first of the disc's layers
#else
    Angle disc;             // angular radius
    Number perDisc;         // its inverse
    int firstBow;           // bows that are not dark at this angle, for any wavelength and radius;
    int lastBow;            // none where first > last
#endif
};

#if TABLE
bool isDark(SunView sun) {
    return false;
}

CrossSection crossSection(sampler2D spectral, SECTION_PARAMETERS, int wavelength, vec2 radius,
                          SunView sun) {
    return sectionAt(sections, sun.place, radius, sun.layer + wavelength, sun.perpendicular);
}
#else
bool isDark(SunView sun) {
    return sun.firstBow > sun.lastBow;
}

// A bow is dark on the far side of its edge (host: the faintest reach of any wavelength and radius).
void findBows(inout SunView view, Angle edge[BOW_COUNT]) {
    view.firstBow = BOW_COUNT;
    view.lastBow = -1;
    for (int b = 0; b < BOW_COUNT; ++b) {
        if (BOW_SIDE[b] * (view.theta - edge[b]) > 0.0) {
            view.firstBow = min(view.firstBow, b);
            view.lastBow = b;
        }
    }
}

// C(lambda, a, theta) where some bow is not dark, for unpolarised light: the bows' intensities add.
CrossSection crossSection(sampler2D spectral, SECTION_PARAMETERS, int wavelength, vec2 radius,
                          SunView sun) {
    CrossSection sum = 0.0;
    // Most angles see one bow alone. Tested at the end, because Mesa's CPU driver would run the
    // body once more, masked out, to find a test at the top false.
    int b = sun.firstBow;
    do {
        Bow bow = bowAt(spectral, wavelength, b, sun.perpendicular);
        // BOW_SIDE: +1 for the primary, bright towards the antisolar point, -1 for the secondary.
        Number side = BOW_SIDE[b];
        Angle toPole = side > 0.0 ? PI - sun.theta : sun.theta;
        Number scale = bow.scale * radius.x;
        sum += bow.strength * radius.y
            * airyMean(near, fringe, pole, scale * side * (sun.theta - bow.angle),
                       scale * sun.disc, toPole * sun.perDisc);
    } while (++b <= sun.lastBow);
    return sum;
}
#endif

#if ONE_RADIUS && ATTENUATION
// With drops of one radius a pixel needs its cross-sections once, whatever the steps.
struct Sections {
    float at[WAVELENGTH_COUNT];
};

Sections crossSections(sampler2D spectral, SECTION_PARAMETERS, SunView sun, Length radius) {
    vec2 terms = RADIUS_TERMS(radius);
    Sections found;
    for (int w = 0; w < WAVELENGTH_COUNT; ++w) {
        found.at[w] = crossSection(spectral, SECTION_ARGUMENTS, w, terms, sun);
    }
    return found;
}

// One sample's light over all wavelengths, per metre of ray and per drop density.
Tristimulus attenuatedLight(sampler2D spectral, int light, Sections found, Column column,
                            Number depth, Number rise) {
    Tristimulus sum = vec3(0.0);
    for (int w = 0; w < WAVELENGTH_COUNT; ++w) {
        vec4 weight = texelFetch(spectral, ivec2(w, FIRST_LIGHT_ROW + light), 0);
        sum += found.at[w] * attenuation(spectral, w, weight.a, column, depth, rise) * weight.rgb;
    }
    return sum;
}
#endif

// One sample's light over all wavelengths, per metre of ray and per drop density.
Tristimulus scatteredLight(sampler2D spectral, SECTION_PARAMETERS, int light, SunView sun,
                           Length radius, Column column, Number depth, Number rise) {
    vec2 terms = RADIUS_TERMS(radius);
    Tristimulus sum = vec3(0.0);
    for (int w = 0; w < WAVELENGTH_COUNT; ++w) {
        vec4 weight = texelFetch(spectral, ivec2(w, FIRST_LIGHT_ROW + light), 0);
        Number value = crossSection(spectral, SECTION_ARGUMENTS, w, terms, sun);
#if ATTENUATION
        value *= attenuation(spectral, w, weight.a, column, depth, rise);
#endif
        sum += value * weight.rgb;
    }
    return sum;
}
#endif
