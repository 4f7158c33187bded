#include "common/box.glsl"
#include "common/camera.glsl"
#include "rain/dimming.glsl"

// The rain's own glow along a ray (rtbow/render/glow/map.py): its brightness by direction, times the
// share of light that the rain takes.

struct Glow {
    sampler2D brightness;      // over azimuth and altitude, linear Rec. 709 in cd/m²
    sampler2D columns;         // of these, by share of the range of azimuths
    sampler2D rows;            // of altitudes
    vec2 first;                // least azimuth and altitude
    vec2 range;                // how far they reach
};

Tristimulus glowBehind(Glow glow, Direction ray) {
    Angle azimuth = atan(ray.x, ray.y) - glow.first.x;
    azimuth -= 2.0 * PI * floor(azimuth / (2.0 * PI));
    vec2 share = vec2(azimuth, atan(ray.z, length(ray.xy)) - glow.first.y) / glow.range;
    Number column = textureLod(glow.columns, vec2(share.x, 0.5), 0.0).r;
    Number row = textureLod(glow.rows, vec2(share.y, 0.5), 0.0).r;
    return textureLod(glow.brightness, vec2(column, row), 0.0).rgb;
}

Number rainDepth(Volume volume, Direction ray) {
    vec2 span = boxSpan(ray, volume.low, volume.high);
    return max(span.y - span.x, 0.0) * volume.extinction;
}

// Share of light that rain of some depth takes; without loss of digits where that is thin.
Number taken(Number depth) {
    return depth > 0.03 ? 1.0 - exp(-depth) : depth * (1.0 - depth * (0.5 - depth / 6.0));
}

Tristimulus glowAlong(Glow glow, Volume volume, Direction ray) {
    return taken(rainDepth(volume, ray)) * glowBehind(glow, ray);
}
