#include "sky/along.glsl"

// One pixel of what is around the drops under one sun, added to a frame of what they scatter.

out vec4 radiance;

// Share of a pixel that is on the near side of an edge which is `ahead` of its middle, and by `change`
// nearer or farther at its sides.
Number shareBefore(Number ahead, Number change) {
    return change > 0.0 ? clamp(ahead / change + 0.5, 0.0, 1.0) : float(ahead >= 0.0);
}

// Share of a pixel of some width that a disc of a radius fills whose centre is `away`: a cone's, which in
// all keeps the disc's solid angle, however small it is.
Number discShare(Number radius, Number away, Number width) {
    if (radius == 0.0) return 0.0;
    Number disc = radius * radius;
    Number pixel = width * width;
    Number edge = sqrt(max(disc - pixel / 12.0, 0.25 * pixel));
    return min(1.0, 3.0 * disc / max(pixel, 1.0e-30)) * shareBefore(edge - away, width);
}

void main() {
    Direction ray = pixelRay(camera, gl_FragCoord.xy);
    Angle above = altitudeOf(ray) - sky.horizon;
    Number away = length(ray - sky.towards);
    Direction onward = ray;
#if WATER
    if (above < 0.0) onward = mirrored(sky, ray);
    Number beside = length(onward - sky.towards);
#endif
#if PIXEL_AREA
    Angle rise = abs(dFdx(above)) + abs(dFdy(above));
    Number width = sqrt(length(dFdx(ray)) * length(dFdy(ray)));
#else
    const Angle rise = 0.0;
    const Number width = 0.0;
#endif
    Number disc = discShare(sky.disc, away, width);
#if POLARIZER
    disc *= 0.5;
#endif
    Number below = 0.0;
#if WATER
    below = discShare(sky.disc, beside, width);
#endif
    Number share = shareBefore(above, rise);
    Tristimulus light = vec3(0.0);
    // Of a pixel that the horizon crosses, the middle of either part.
    if (share > 0.0) {
        SkyPlace at = skyPlace(sky, ray, share < 1.0 ? 0.5 * share * rise : above, false);
        light += share * around(ray, at, ray, disc);
    }
    if (share < 1.0) {
        SkyPlace at = skyPlace(sky, ray, share > 0.0 ? 0.5 * (share - 1.0) * rise : above, true);
        light += (1.0 - share) * around(ray, at, onward, below);
    }
    radiance = vec4(light, 1.0);
}
