#include "common/definitions.glsl"
#include "drop/sections.glsl"
#include "common/pixel_points.glsl"

// Cross-sections of either theory from a table made for the scene. drop/airy_theory.glsl has the same
// names for Airy's bows evaluated in place; a program includes one of the two.

struct Theory {
    sampler2DArray sections;
    AngleAxis angles;
    RadiusAxis radii;
};

// What look-ups need of a radius.
vec2 radiusTerms(Theory theory, Length radius) {
    return sectionRadius(theory.radii, float(textureSize(theory.sections, 0).y), radius);
}

#if SUN_COUNT
// Everything about a sun at one pixel that does not change along the ray.
struct SunView {
    Number perpendicular;   // share of that component, with a polariser
    Number place;           // of the scattering angle along the table's
    int layer;              // first of the disc's layers
#if PIXEL_POINTS
    Number places[PIXEL_POINTS];    // of the angles at the pixel's points
#endif
};

// `disc` is for Airy's theory (drop/airy_theory.glsl): a table has layers averaged over each disc.
#if PIXEL_POINTS
SunView sunView(Theory theory, Angle theta, Angle disc, int layer, Number perpendicular,
                vec2 extent) {
    SunView view;
    view.perpendicular = perpendicular;
    view.layer = layer;
    for (int k = 0; k < PIXEL_POINTS; ++k) {
        Angle angle = clamp(theta + pixelPoint(extent, k), 0.0, PI);
        view.places[k] = anglePlace(theory.angles, angle);
    }
    return view;
}

SunView atPoint(SunView view, int k) {
    view.place = view.places[k];
    return view;
}
#else
SunView sunView(Theory theory, Angle theta, Angle disc, int layer, Number perpendicular) {
    return SunView(perpendicular, anglePlace(theory.angles, theta), layer);
}
#endif

bool isDark(SunView sun) {
    return false;
}

CrossSection crossSection(sampler2D spectral, Theory theory, int wavelength, vec2 radius,
                          SunView sun) {
    return sectionAt(theory.sections, sun.place, radius, sun.layer + wavelength, sun.perpendicular);
}
#endif

#if LAMP_COUNT
// A table has no bows that could be dark.
ivec2 litBows(Theory theory, vec2 theta, Angle disc) {
    return ivec2(0);
}

// Mean cross-section over a step between two scattering angles.
CrossSection meanSection(sampler2D spectral, Theory theory, int wavelength, vec2 radius, vec2 theta,
                         Angle disc, ivec2 lit, Number perpendicular) {
    // The disc's chords have the second and fourth moments of two even ranges, of half the width
    // across the diagonal and of the whole; each is widened by the step.
    Angle span = theta.y - theta.x;
    Angle middle = 0.5 * (theta.x + theta.y);
    CrossSection mean = 0.0;
    for (int k = 1; k <= 2; ++k) {
        Angle wide = sign(span) * sqrt(span * span + 2.0 * float(k) * disc * disc);
        vec2 range = clamp(middle + vec2(-0.5, 0.5) * wide, 0.0, PI);
        mean += 0.5 * sectionMean(theory.sections, theory.angles, range, radius, wavelength,
                                  perpendicular);
    }
    return mean;
}
#endif
