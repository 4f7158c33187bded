#include "definitions.glsl"
#include "math.glsl"
#include "bows.glsl"

// Sunlight is parallel: the scattering angle is one along a ray (paper, section 5.2).

#if SUN_COUNT
// Everything about a light at one pixel that does not change along the ray (sunlight is parallel).
struct SunView {
    Angle theta;          // scattering angle, 0 = forward
    Angle altitude;
    Angle disc;           // angular radius
    Number perDisc;       // its inverse
    int firstBow;         // bows that are not dark at this angle, for any wavelength and radius;
    int lastBow;          // none where first > last
};

// A bow is dark on the far side of its edge (host: the faintest reach of any wavelength and radius).
SunView viewSun(Direction towardsSun, Direction ray, Angle altitude, Angle disc,
                Angle edge[BOW_COUNT]) {
    // Light travels along -towardsSun and on to the eye along -ray.
    Angle theta = angleBetween(towardsSun, ray);
    SunView view = SunView(theta, altitude, disc, 1.0 / max(disc, 1.0e-9), BOW_COUNT, -1);
    for (int b = 0; b < BOW_COUNT; ++b) {
        if (BOW_SIDE[b] * (theta - edge[b]) > 0.0) {
            view.firstBow = min(view.firstBow, b);
            view.lastBow = b;
        }
    }
    return view;
}

// C(lambda, a, theta), where some bow is not dark (firstBow <= lastBow), for unpolarised light: the bows' intensities add.
CrossSection crossSection(sampler2D spectral, sampler2D near, sampler2D fringe, sampler2D pole,
                          int wavelength, Number radiusScale, Number radiusStrength,
                          SunView sun) {
    CrossSection sum = 0.0;
    // Most angles see one bow alone. Tested at the end, because Mesa's CPU driver would run the
    // body once more, masked out, to find a test at the top false.
    int b = sun.firstBow;
    do {
        Bow bow = bowAt(spectral, wavelength, b);
        // BOW_SIDE: +1 for the primary, bright towards the antisolar point, -1 for the secondary.
        Number side = BOW_SIDE[b];
        Angle toPole = side > 0.0 ? PI - sun.theta : sun.theta;
        Number scale = bow.scale * radiusScale;
        sum += bow.strength * radiusStrength
            * airyMean(near, fringe, pole, scale * side * (sun.theta - bow.angle),
                       scale * sun.disc, toPole * sun.perDisc);
    } while (++b <= sun.lastBow);
    return sum;
}

#if ONE_RADIUS && AIR
// With drops of one radius a pixel needs its cross-sections once, whatever the steps.
struct Sections {
    float at[WAVELENGTH_COUNT];
};

Sections crossSections(sampler2D spectral, sampler2D near, sampler2D fringe, sampler2D pole,
                       SunView sun, Length radius) {
    vec2 powers = radiusPowers(radius);
    Sections sections;
    for (int w = 0; w < WAVELENGTH_COUNT; ++w) {
        sections.at[w] = crossSection(spectral, near, fringe, pole, w, powers.x, powers.y, sun);
    }
    return sections;
}

// One sample's light over all wavelengths, per metre of ray and per drop density.
Tristimulus attenuatedLight(sampler2D spectral, int light, Sections sections, Column column) {
    Tristimulus sum = vec3(0.0);
    for (int w = 0; w < WAVELENGTH_COUNT; ++w) {
        vec4 weight = texelFetch(spectral, ivec2(w, BOW_COUNT + light), 0);
        sum += sections.at[w] * exp(-weight.a * column) * weight.rgb;
    }
    return sum;
}
#endif

// One sample's light over all wavelengths, per metre of ray and per drop density.
Tristimulus scatteredLight(sampler2D spectral, sampler2D near, sampler2D fringe, sampler2D pole,
                           int light, SunView sun, Length radius, Column column) {
    vec2 powers = radiusPowers(radius);
    Tristimulus sum = vec3(0.0);
    for (int w = 0; w < WAVELENGTH_COUNT; ++w) {
        vec4 weight = texelFetch(spectral, ivec2(w, BOW_COUNT + light), 0);
        Number value = crossSection(spectral, near, fringe, pole, w, powers.x, powers.y, sun);
#if AIR
        value *= exp(-weight.a * column);
#endif
        sum += value * weight.rgb;
    }
    return sum;
}
#endif
