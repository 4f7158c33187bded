#include "common/definitions.glsl"
#include "rain/droplets.glsl"
#include "rain/extinction.glsl"

// The drops as method `fast` marches through them, relative to the eye: the part of the volume that
// has any, and the whole of its grid. An even volume has the numbers, another the textures.
struct Volume {
    Position low;
    Position high;
#if !GRID
    NumberDensity density;
#if EXTINCTION
    Number extinction;     // 1/m
#endif
#else
    Position gridLow;
    vec3 gridPerMetre;     // 0..1 per metre
    sampler3D moments;
#if EXTINCTION
    sampler3D toLight;     // mean extinction towards the light
#endif
#endif
};

Droplets dropletsAt(Volume volume, Position at) {
#if GRID
    return sampleDroplets(volume.moments, (at - volume.gridLow) * volume.gridPerMetre);
#elif EXTINCTION
    return Droplets(volume.density, 0.0, volume.extinction);
#else
    return Droplets(volume.density, 0.0);
#endif
}

#if EXTINCTION
// Optical depth of the rain from a place along the ray towards a light, which is `most` away.
Number rainTowards(Volume volume, Direction ray, Length distance, Direction towards, Length most) {
    // The grid's own box, whose faces the stored means end at.
#if GRID
    vec3 low = volume.gridLow;
    vec3 high = volume.gridLow + 1.0 / volume.gridPerMetre;
#else
    vec3 low = volume.low;
    vec3 high = volume.high;
#endif
    Length path = min(pathOut(towards, cornerFrom(low, ray, distance),
                              cornerFrom(high, ray, distance)), most);
#if GRID
    return depthTowards(volume.toLight, (distance * ray - volume.gridLow) * volume.gridPerMetre, 0,
                        1.0, path);
#else
    return volume.extinction * path;
#endif
}
#endif
