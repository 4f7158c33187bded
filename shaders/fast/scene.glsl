#include "common/definitions.glsl"
#include "common/camera.glsl"
#include "common/box.glsl"
#include "rain/droplets.glsl"
#include "air/atmosphere.glsl"
#include "rain/march.glsl"
#include "rain/extinction.glsl"

// The scene as the mains of method `fast` see it: uniforms that they share, and drops at a place.

// Camera
uniform vec2 frameSize;
uniform mat3 cameraBasis;
#if AIR
uniform float eyeHeight;
uniform float eyeAir;               // column per metre at the eye
uniform float columnReach;          // of the tables, about their middle column
uniform float greyAir;              // depth per column that weights carry; tables have the rest
#endif
#if POLARIZER
uniform vec3 polarizerPass;         // direction in the filter whose field it lets pass
#endif

// Drops, relative to the eye: the part of the volume that has any, and the whole of its grid.
uniform vec3 boxLow;
uniform vec3 boxHigh;
#if GRID
uniform vec3 gridLow;
uniform vec3 gridPerMetre;          // 0..1 per metre
uniform sampler3D dropletMoments;
#else
uniform float uniformDensity;       // 1/m^3
#endif
#if SEVERAL_RADII
uniform float middleRadius;         // logarithm of the radius that weights are counted from
uniform vec2 radiusRows;            // first row's from there; rows per factor e
#endif
#if EXTINCTION
#if GRID
uniform sampler3D rainToLight;
#else
uniform float uniformExtinction;    // 1/m
#endif
#endif

// March
uniform vec3 cellsPerMetre;
uniform float airPerMetre;
uniform int fixedSteps;

Direction rayAt(vec2 pixel) {
    return cameraRay(2.0 * pixel / frameSize - 1.0, cameraBasis);
}

Droplets dropletsAt(Position at) {
#if GRID
    return sampleDroplets(dropletMoments, (at - gridLow) * gridPerMetre);
#elif EXTINCTION
    return Droplets(uniformDensity, 0.0, uniformExtinction);
#else
    return Droplets(uniformDensity, 0.0);
#endif
}

#if EXTINCTION
// Optical depth of the rain from a place along the ray towards a light, which is `most` away.
Number rainTowards(Direction ray, Length distance, Direction towards, Length most) {
    // The grid's own box, whose faces the stored means end at.
#if GRID
    vec3 low = gridLow;
    vec3 high = gridLow + 1.0 / gridPerMetre;
#else
    vec3 low = boxLow;
    vec3 high = boxHigh;
#endif
    Length path = min(pathOut(towards, cornerFrom(low, ray, distance),
                              cornerFrom(high, ray, distance)), most);
#if GRID
    return depthTowards(rainToLight, (distance * ray - gridLow) * gridPerMetre, 0, 1.0, path);
#else
    return uniformExtinction * path;
#endif
}
#endif
