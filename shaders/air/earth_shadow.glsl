#include "common/definitions.glsl"
#include "air/atmosphere.glsl"

// The Earth's shadow: half a cylinder behind a sphere that touches sea level below the eye
// (rtbow/physics/air/earth_shadow.py). With q from the Earth's centre to a place and s towards the
// sun, a place is dark where q.s < 0 and its distance from the axis, |q - (q.s) s|, is less than the
// radius R. Along a ray the square of that distance less R^2, over 2 R, is
//
//     a t^2 + b t + c,   a = |s x ray|^2 / 2R,   b = outward . ray,   c = clear,
//
// a height in metres, in which R itself does not occur: the host takes it out in float64.

struct EarthShadow {
    Direction towards;     // to the sun
    Length clear;          // the eye's height above the cylinder
    vec3 outward;          // from the axis to the eye, in radii
    Length sunward;        // from the Earth's centre to the eye, along the axis
};

const Length NOWHERE = 3.0e38;

// Distances at which a ray enters the shadow and leaves it; both NOWHERE where it does not.
vec2 shadowSpan(EarthShadow shadow, Direction ray) {
    vec2 nowhere = vec2(NOWHERE);
    Number along = dot(shadow.towards, ray);
    vec3 across = cross(shadow.towards, ray);
    // The square is 0 along the axis, and a root then NOWHERE instead of infinite.
    Number a = max(dot(across, across), 1.0e-20) / (2.0 * EARTH_RADIUS_M);
    Number b = dot(shadow.outward, ray);
    Number square = b * b - 4.0 * a * shadow.clear;
    if (square <= 0.0) return nowhere;
    // The sum of like signs keeps its digits; the other root follows from the product of both.
    Number middle = -0.5 * (b + (b < 0.0 ? -1.0 : 1.0) * sqrt(square));
    vec2 roots = vec2(middle / a, shadow.clear / middle);
    vec2 dark = vec2(min(roots.x, roots.y), max(roots.x, roots.y));
    // Where the ray passes the Earth's centre: beyond it, seen from the sun, the shadow begins.
    Length centre = abs(along) < 1.0e-30 ? NOWHERE : -shadow.sunward / along;
    if (along < 0.0) dark.x = max(dark.x, centre);
    else if (centre == NOWHERE) return shadow.sunward < 0.0 ? dark : nowhere;
    else dark.y = min(dark.y, centre);
    return dark.x < dark.y ? dark : nowhere;
}

bool isInShadow(vec2 dark, Length distance) {
    return distance > dark.x && distance < dark.y;
}

// Air column towards the sun from a place along a ray outside of the shadow.
Column columnOverSphere(sampler2D logColumn, EarthShadow shadow, Length eyeHeight, Direction ray,
                        Length distance) {
    // (|q|^2 - R^2) / 2R, again without R: of that |q| - R follows.
    Number perRadius = 1.0 / EARTH_RADIUS_M;
    Length excess = eyeHeight * (1.0 + 0.5 * eyeHeight * perRadius)
        + distance * (ray.z * (1.0 + eyeHeight * perRadius) + 0.5 * distance * perRadius);
    Length height = 2.0 * excess / (1.0 + sqrt(1.0 + 2.0 * excess * perRadius));
    Number sine = (shadow.sunward + dot(shadow.towards, ray) * distance)
        / (EARTH_RADIUS_M + height);
    // Near the shadow's edge the sun is near the horizon: the series of the arc sine, within 4e-9
    // up to 10 degrees. Mesa's own errs by 1e-4.
    Number square = sine * sine;
    Angle altitude = sine * (1.0 + square * (1.0 / 6.0
        + square * (3.0 / 40.0 + square * (15.0 / 336.0))));
    return litColumn(logColumn, height, altitude);
}
