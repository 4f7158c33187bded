#include "common/definitions.glsl"

struct Droplets {
    NumberDensity density;
    Length radius;
#if EXTINCTION
    Number extinction;      // 1/m
#endif
};

// Drops at a place, 0..1 along each side of the box. The texture holds density and density * radius
// at grid points on the box faces (paper, section 5.2, step 3); their ratio weights the radius by
// density, so that an empty grid point pulls nothing. Where rain dims rain, extinction is third.
Droplets sampleDroplets(sampler3D moments, vec3 place) {
    vec3 size = vec3(textureSize(moments, 0));
    vec3 m = textureLod(moments, (0.5 + clamp(place, 0.0, 1.0) * (size - 1.0)) / size, 0.0).rgb;
#if EXTINCTION
    return Droplets(m.r, m.r > 0.0 ? m.g / m.r : 0.0, m.b);
#else
    return Droplets(m.r, m.r > 0.0 ? m.g / m.r : 0.0);
#endif
}
