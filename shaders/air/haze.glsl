#include "common/definitions.glsl"
#include "common/math.glsl"

// Aerosol on the way of light to drops and on to the eye: optical depths at 550 nm
// (rtbow/render/haze.py).

#if HAZE
struct Haze {
    sampler2D depths;      // from heights to each sun, and to the ground; a row for each sun
    Number perHeight;      // inverse of the last of these heights
    Length eyeHeight;
};

vec2 hazeAt(Haze haze, Length height, float row) {
    vec2 size = vec2(textureSize(haze.depths, 0));
    vec2 texel = vec2(texelCentred(height * haze.perHeight, size.x), (row + 0.5) / size.y);
    return textureLod(haze.depths, texel, 0.0).rg;
}

// Depth from a sun to a place at a distance along a ray from the eye, and on to the eye. Level ways are
// taken over the least rise whose depth keeps its digits.
Number hazeAlong(Haze haze, Direction ray, Length distance, int sun) {
    const Length LEAST = 8.0;
    Length height = max(haze.eyeHeight + ray.z * distance, 0.0);
    Length low = min(height, haze.eyeHeight);
    Length high = max(max(height, haze.eyeHeight), low + LEAST);
    Number between = hazeAt(haze, high, float(sun)).y - hazeAt(haze, low, float(sun)).y;
    return hazeAt(haze, height, float(sun)).x + between / (high - low) * distance;
}
#endif
