#include "common/definitions.glsl"

// Linear Rec. 709, D65, of the same luminance unit; XYZ_TO_RGB comes from the host.
vec3 xyzToRgb(Tristimulus xyz) {
    return XYZ_TO_RGB * xyz;
}
