#include "rain/droplets.glsl"

// The rain as what dims light along a ray.

#if EXTINCTION
// The rain that dims, relative to the eye.
struct Volume {
    Position low;
    Position high;
#if GRID
    sampler3D moments;
#else
    Number extinction;     // 1/m
#endif
};

Number extinctionAt(Volume volume, Position at) {
#if GRID
    return sampleDroplets(volume.moments, (at - volume.low) / (volume.high - volume.low)).extinction;
#else
    return volume.extinction;
#endif
}
#endif
