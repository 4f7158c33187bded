#include "common/box.glsl"
#include "common/camera.glsl"
#include "rain/dimming.glsl"
#include "sky/table.glsl"
#include "sky/water.glsl"

// What is around the drops along a ray: the air before, within and behind the rain, the ground and the
// sun's disc, each behind what lies before it: linear Rec. 709 in cd/m².

#if EXTINCTION
struct Through {
    Tristimulus light;     // of the air before and within the rain
    Number passed;         // share of light from behind that passes the rain
    Tristimulus air;       // of the air up to the rain's end, were there no rain
};

// Along a ray: the air's light up to the end of each step is looked up; what it adds over the step is
// dimmed as the mean of the step's samples of the rain.
// `start`: of the ray; the air's light is that of a ray from the eye.
Through throughRain(Camera camera, Sky sky, Volume volume, SkyPlace at, Position start,
                    Direction ray) {
    vec2 span = boxSpan(ray, volume.low - start, volume.high - start);
    Through rain = Through(vec3(0.0), 1.0, vec3(0.0));
    if (span.x >= span.y) return rain;
    Number depth = 0.0;
    Length step = (span.y - span.x) / float(SKY_STEPS * SKY_SAMPLES);
    rain.air = skyUpTo(camera, sky, at, ray, span.x);
    rain.light = rain.air;
    Length distance = span.x;
    for (int k = 0; k < SKY_STEPS; ++k) {
        Number left = 0.0;
        for (int j = 0; j < SKY_SAMPLES; ++j) {
            Number thick = step * extinctionAt(volume, start + (distance + 0.5 * step) * ray);
            left += exp(-depth) * meanDecay(thick);
            depth += thick;
            distance += step;
        }
        Tristimulus next = skyUpTo(camera, sky, at, ray, distance);
        rain.light += left / float(SKY_SAMPLES) * (next - rain.air);
        rain.air = next;
    }
    rain.passed = exp(-depth);
    return rain;
}
#endif

#if WATER && EXTINCTION
// Where the rain behind the mirror begins: at the water; where a ray leaves through the floor of rain
// that stands on it, already there: the water is a sphere and falls away from the flat floor.
Length mirrorDistance(Sky sky, Volume volume, Direction ray) {
    Length distance = waterDistance(sky, ray), floorAt = volume.low.z;
    vec2 span = boxSpan(ray, volume.low, volume.high);
    bool stands = floorAt < STANDS_M - sky.height && span.x < span.y;
    return stands && ray.z * span.y < floorAt + 1.0e-3 ? min(span.y, distance) : distance;
}

// What rain leaves of light on its way to the water, along a mirrored ray; of the sky's as of one that
// is seen from the eye in that direction, of which as much lies before the rain and within it.
Left leftBeyond(Camera camera, Sky sky, Volume volume, Position water, Direction onward) {
    Angle above = altitudeOf(onward) - sky.horizon;
    SkyPlace at = skyPlace(sky, onward, max(above, 0.0), false);
    Tristimulus whole = max(skyWhole(camera, sky, at, onward), vec3(1.0e-30));
    Through rain = throughRain(camera, sky, volume, at, water, onward);
    return Left((rain.light + rain.passed * (whole - rain.air)) / whole, rain.passed);
}
#endif

// `onward`: the ray's mirror at the water, if it falls on water; `disc`: share of the pixel that the
// sun's disc fills, or its mirror image.
Tristimulus around(Camera camera, Sky sky,
#if EXTINCTION
                   Volume volume,
#endif
                   Direction ray, SkyPlace at, Direction onward, Number disc) {
    Tristimulus light = skyWhole(camera, sky, at, ray);
    if (disc > 0.0 && !at.falls) light += disc * sunBeyond(sky, at);
#if WATER
    if (at.falls) {
#if EXTINCTION
        Left left = leftBeyond(camera, sky, volume, mirrorDistance(sky, volume, ray) * ray,
                               onward);
#else
        const Left left = Left(vec3(1.0), 1.0);
#endif
        light += mirroredLight(camera, sky, at, ray, onward, disc, left);
    }
#endif
#if EXTINCTION
    Through rain = throughRain(camera, sky, volume, at, vec3(0.0), ray);
    light = rain.light + rain.passed * (light - rain.air);
#endif
    return light;
}
