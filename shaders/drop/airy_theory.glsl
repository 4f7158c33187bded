#include "common/definitions.glsl"
#include "drop/airy.glsl"
#include "drop/bows.glsl"
#include "common/pixel_points.glsl"

// Cross-sections by Airy's theory, whose bows are evaluated where the drop is. drop/table_theory.glsl
// has the same names for a table; a program includes one of the two.

struct Theory {
    sampler2D near;        // Ai^2 averaged over discs, about the bow (drop/airy.glsl)
    sampler2D fringe;      // and far inside
    sampler2D pole;        // and about the pole
    Angle edge[BOW_COUNT]; // scattering angle beyond which a bow is dark
};

// What look-ups need of a radius.
vec2 radiusTerms(Theory theory, Length radius) {
    return radiusPowers(radius);
}

#if SUN_COUNT
// Everything about a sun at one pixel that does not change along the ray.
struct SunView {
    Angle theta;            // scattering angle, 0 = forward
    Number perpendicular;   // share of that component, with a polariser
    Angle disc;             // angular radius
    Number perDisc;         // its inverse
    int firstBow;           // bows that are not dark at this angle, for any wavelength and radius;
    int lastBow;            // none where first > last
#if PIXEL_POINTS
    vec2 extent;            // of the pixel across theta
#endif
};

// `layer` is for tables alone (drop/table_theory.glsl). A bow is dark on the far side of its edge (host: the faintest reach
// of any wavelength and radius).
SunView sunView(Theory theory, Angle theta, Angle disc, int layer, Number perpendicular
#if PIXEL_POINTS
                , vec2 extent
#endif
                ) {
#if PIXEL_POINTS
    disc = sqrt(disc * disc + pixelRest(extent));
    SunView view = SunView(theta, perpendicular, disc, 1.0 / max(disc, 1.0e-9), BOW_COUNT, -1, extent);
#else
    SunView view = SunView(theta, perpendicular, disc, 1.0 / max(disc, 1.0e-9), BOW_COUNT, -1);
#endif
    for (int b = 0; b < BOW_COUNT; ++b) {
        if (BOW_SIDE[b] * (theta - theory.edge[b]) > 0.0) {
            view.firstBow = min(view.firstBow, b);
            view.lastBow = b;
        }
    }
    return view;
}

bool isDark(SunView sun) {
    return sun.firstBow > sun.lastBow;
}

#if PIXEL_POINTS
// The view at one of the pixel's points.
SunView atPoint(SunView view, int k) {
    view.theta = clamp(view.theta + pixelPoint(view.extent, k), 0.0, PI);
    return view;
}
#endif

// C(lambda, a, theta) where some bow is not dark, for unpolarised light: the bows' intensities add.
CrossSection crossSection(sampler2D spectral, Theory theory, int wavelength, vec2 radius,
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
            * airyMean(theory.near, theory.fringe, theory.pole,
                       scale * side * (sun.theta - bow.angle), scale * sun.disc,
                       toPole * sun.perDisc);
    } while (++b <= sun.lastBow);
    return sum;
}
#endif

#if LAMP_COUNT
// First and last bow that are not dark somewhere between two angles; none where first > last.
ivec2 litBows(Theory theory, vec2 theta, Angle disc) {
    ivec2 lit = ivec2(BOW_COUNT, -1);
    for (int b = 0; b < BOW_COUNT; ++b) {
        Angle bright = BOW_SIDE[b] > 0.0 ? theta.y : theta.x;
        if (BOW_SIDE[b] * (bright - theory.edge[b]) + disc > 0.0) {
            lit.x = min(lit.x, b);
            lit.y = b;
        }
    }
    return lit;
}

// Mean of one bow over a step between two scattering angles.
CrossSection bowMean(Theory theory, Bow bow, Number side, vec2 powers, vec2 theta, Angle disc) {
    Number scale = bow.scale * powers.x;
    Number from = scale * side * (theta.x - bow.angle);
    Number to = scale * side * (theta.y - bow.angle);
    Number span = to - from;
    Number wide = scale * disc;
    Number mean = abs(span) > 0.1
        ? (airyRunning(theory.near, theory.fringe, to, wide)
           - airyRunning(theory.near, theory.fringe, from, wide)) / span
        : airyMean(theory.near, theory.fringe, theory.near, 0.5 * (from + to), wide, 1.0e9);
    return bow.strength * powers.y * mean;
}

// Mean cross-section over a step, of the bows that are not dark.
CrossSection meanSection(sampler2D spectral, Theory theory, int wavelength, vec2 powers, vec2 theta,
                         Angle disc, ivec2 lit, Number perpendicular) {
    CrossSection sum = 0.0;
    int b = lit.x;
    do {
        Bow bow = bowAt(spectral, wavelength, b, perpendicular);
        sum += bowMean(theory, bow, BOW_SIDE[b], powers, theta, disc);
    } while (++b <= lit.y);
    return sum;
}
#endif
