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
#endif
