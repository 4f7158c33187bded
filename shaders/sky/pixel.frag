#include "sky/along.glsl"

// One pixel of what is around the drops under one sun, added to a frame of what they scatter.

uniform Camera camera;
uniform Sky sky;
#if EXTINCTION
uniform Volume volume;
#define RAIN volume,
#else
#define RAIN
#endif

out vec4 radiance;

// Share of a pixel that is on the near side of an edge which is `ahead` of its middle, and by `change`
// nearer or farther at its sides.
Number shareBefore(Number ahead, Number change) {
    return change > 0.0 ? clamp(ahead / change + 0.5, 0.0, 1.0) : float(ahead >= 0.0);
}

#if PIXEL_AREA
const int LINES = 12;               // in a pixel across a disc: its area is within 1 %
const Number LEAST_DISC = 0.25;     // radius, in pixels, of a disc that does not fall between two of them
                                    // where their rays are not quite even

// Share of a pixel that a disc fills, of which `radius` is a chord: the sum over all pixels is the
// disc's solid angle, however small it is. `apart`: from the disc's centre to the pixel's ray;
// `across`, `upwards`: by which that changes from one pixel to the next.
Number discShare(Number radius, vec3 apart, vec3 across, vec3 upwards) {
    Number wide = max(dot(across, across), 1.0e-20);
    Number drawn = max(radius, LEAST_DISC * sqrt(length(across) * length(upwards)));
    // Along lines across the pixel: where these meet the disc at all, then how much of each does.
    vec3 off = apart - dot(apart, across) / wide * across;
    vec3 side = upwards - dot(upwards, across) / wide * across;
    Number high = max(dot(side, side), 1.0e-20);
    Number middle = -dot(off, side) / high;
    Number reach = sqrt(max((drawn * drawn - dot(off, off)) / high + middle * middle, 0.0));
    Number first = max(middle - reach, -0.5);
    Number step = max(min(middle + reach, 0.5) - first, 0.0) / float(LINES);
    Number share = 0.0;
    for (int k = 0; k < LINES; ++k) {
        vec3 at = apart + (first + (float(k) + 0.5) * step) * upwards;
        Number nearest = -dot(at, across) / wide;
        Number chord = sqrt(max((drawn * drawn - dot(at, at)) / wide + nearest * nearest, 0.0));
        share += max(min(nearest + chord, 0.5) - max(nearest - chord, -0.5), 0.0);
    }
    return share * step * (radius * radius) / (drawn * drawn);
}
#endif

// The direction of a ray's azimuth at another altitude.
Direction turnedTo(Direction ray, Angle altitude) {
    return vec3(cos(altitude) * normalize(ray.xy), sin(altitude));
}

void main() {
    Direction ray = pixelRay(camera, gl_FragCoord.xy);
    Angle above = altitudeOf(ray) - sky.horizon;
    Direction onward = ray;
#if WATER
    if (above < 0.0) onward = mirrored(sky, ray);
    vec3 beside = onward - sky.towards;
#endif
    vec3 apart = ray - sky.towards;
#if PIXEL_AREA
    Angle rise = abs(dFdx(above)) + abs(dFdy(above));
    Number disc = discShare(sky.disc, apart, dFdx(ray), dFdy(ray));
#if WATER
    Number below = discShare(sky.disc, beside, dFdx(onward), dFdy(onward));
#endif
#else
    const Angle rise = 0.0;
    Number disc = float(length(apart) < sky.disc);
#if WATER
    Number below = float(length(beside) < sky.disc);
#endif
#endif
#if !WATER
    const Number below = 0.0;
#endif
#if POLARIZER
    disc *= 0.5;
#endif
    Number share = shareBefore(above, rise);
    Tristimulus light = vec3(0.0);
    // Of a pixel that the horizon crosses, the middle of either part.
    bool crossed = share > 0.0 && share < 1.0;
    if (share > 0.0) {
        Angle middle = crossed ? 0.5 * share * rise : above;
        Direction part = crossed ? turnedTo(ray, sky.horizon + middle) : ray;
        SkyPlace at = skyPlace(sky, part, middle, false);
        light += share * around(camera, sky, RAIN part, at, part, disc);
    }
    if (share < 1.0) {
        Angle middle = crossed ? 0.5 * (share - 1.0) * rise : above;
        Direction part = crossed ? turnedTo(ray, sky.horizon + middle) : ray;
#if WATER
        if (crossed) onward = mirrored(sky, part);
#endif
        SkyPlace at = skyPlace(sky, part, middle, true);
        light += (1.0 - share) * around(camera, sky, RAIN part, at, onward, below);
    }
    radiance = vec4(light, 1.0);
}
