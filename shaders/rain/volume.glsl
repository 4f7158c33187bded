#include "common/definitions.glsl"
#include "rain/droplets.glsl"
#include "rain/extinction.glsl"

// The droplet volume, relative to the eye. An even one has the numbers, another the textures.
struct Volume {
    Position low;
    Position high;
#if ONE_RADIUS || !GRID
    Length radius;         // of drops that are all alike
#endif
#if !GRID
    NumberDensity density;
#if EXTINCTION
    Number extinction;     // 1/m
#endif
#else
    sampler3D moments;
#if EXTINCTION
    sampler3D toLights;    // mean extinction towards each light
#endif
#endif
};

Droplets dropletsAt(Volume volume, Position at) {
#if GRID
    Droplets drops = sampleDroplets(volume.moments, (at - volume.low) / (volume.high - volume.low));
#if ONE_RADIUS
    drops.radius = volume.radius;   // the very radius that its table row was made for
#endif
    return drops;
#elif EXTINCTION
    return Droplets(volume.density, volume.radius, volume.extinction);
#else
    return Droplets(volume.density, volume.radius);
#endif
}

#if EXTINCTION
// Optical depth of the rain from a place along the ray towards a light, which is `most` away.
Number rainTowards(Volume volume, Direction ray, Length distance, int light, Direction towards,
                   Length most) {
    Length path = min(pathOut(towards, cornerFrom(volume.low, ray, distance),
                              cornerFrom(volume.high, ray, distance)), most);
#if GRID
    return depthTowards(volume.toLights, (distance * ray - volume.low) / (volume.high - volume.low),
                        light, float(SUN_COUNT + LAMP_COUNT), path);
#else
    return volume.extinction * path;
#endif
}

// The part of a ray's way that is seen (seenSpan of even rain). `samples`: enough for the grid.
vec2 seenSpan(Volume volume, Direction ray, vec2 span, int samples) {
#if GRID
    // Each round divides anew what the last one left.
    for (int round = 0; round < SEEN_ROUNDS; ++round) {
        int count = round == 0 ? samples : SEEN_SAMPLES;
        Length step = (span.y - span.x) / float(count);
        Number depth = 0.0;
        int reached = 0;
        for (; reached < count && depth < UNSEEN_DEPTH; ++reached) {
            Position at = (span.x + (float(reached) + 0.5) * step) * ray;
            depth += step * dropletsAt(volume, at).extinction;
        }
        if (reached == count) return span;
        span.y = span.x + max(float(reached) * step, leastSeen(span));
    }
    return span;
#else
    return seenSpan(span, volume.extinction);
#endif
}
#endif
