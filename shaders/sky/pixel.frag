#include "common/colour.glsl"
#include "fast/blocks.glsl"
#include "sky/along.glsl"

// One pixel of what is around the drops under one sun, added to a frame of what they scatter.

#if BLOCKS
uniform float blockSize;            // pixels between nodes
uniform sampler2D nodes;
uniform sampler2D flags;
#endif

out vec4 radiance;

// Share of a pixel that is on the near side of an edge which is `ahead` of its middle, and by `change`
// nearer or farther at its sides.
Number shareBefore(Number ahead, Number change) {
    return change > 0.0 ? clamp(ahead / change + 0.5, 0.0, 1.0) : float(ahead >= 0.0);
}

void main() {
#if BLOCKS
    if (texelFetch(flags, blockOf(gl_FragCoord.xy, blockSize), 0).r < 0.5) {
        vec2 place = nodePlace(gl_FragCoord.xy, blockSize, nodes);
        radiance = vec4(fromNode(textureLod(nodes, place, 0.0)), 1.0);
        return;
    }
#endif
    Direction ray = rayThrough(camera, gl_FragCoord.xy);
    Angle above = altitudeOf(ray) - sky.horizon;
    Number away = length(ray - sky.towards);
    Direction onward = ray;
#if WATER
    if (above < 0.0) onward = mirrored(sky, ray);
    Number beside = length(onward - sky.towards);
#endif
#if PIXEL_AREA
    Angle rise = abs(dFdx(above)) + abs(dFdy(above));
    Number turn = abs(dFdx(away)) + abs(dFdy(away));
#else
    const Angle rise = 0.0;
    const Number turn = 0.0;
#endif
    Number disc = sky.disc > 0.0 ? shareBefore(sky.disc - away, turn) : 0.0;
#if POLARIZER
    disc *= 0.5;
#endif
    Number below = 0.0;
#if WATER
#if PIXEL_AREA
    Number sweep = abs(dFdx(beside)) + abs(dFdy(beside));
#else
    const Number sweep = 0.0;
#endif
    if (sky.disc > 0.0) below = shareBefore(sky.disc - beside, sweep);
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
