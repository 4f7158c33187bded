#include "definitions.glsl"
#include "box.glsl"
#include "math.glsl"

// The rain's own extinction, at the middle of the visible; wavelengths differ by a factor each.

#if EXTINCTION
// Optical depth from a place in the box towards a light. The texture holds the mean extinction
// along that path, one block of levels per light; times the path's own length it is exact for even
// rain up to the box's edges. `place`: 0..1 along each side.
Number depthTowards(sampler3D towardsLights, vec3 place, int light, float lights, Length path) {
    vec3 size = vec3(textureSize(towardsLights, 0));
    float levels = size.z / lights;
    vec3 at = 0.5 + clamp(place, 0.0, 1.0) * (vec3(size.xy, levels) - 1.0);
    at.z += float(light) * levels;
    return textureLod(towardsLights, at / size, 0.0).r * path;
}

// Length of the path from a place (relative to the corners) out of the box.
Length pathOut(Position at, Direction towards, Position low, Position high) {
    return max(boxSpan(towards, low - at, high - at).y, 0.0);
}
#endif
