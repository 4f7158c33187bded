#include "common/definitions.glsl"

// What a node keeps: the luminance, by which errors are judged, negative below the horizon; red, blue;
// and what makes blocks about it rough.
vec4 toNode(Tristimulus light, bool falls, Number rough) {
    Number luminance = max(dot(LUMINANCE, light), 1.0e-30);
    return vec4(falls ? -luminance : luminance, light.r, light.b, rough * luminance);
}

Tristimulus fromNode(vec4 node) {
    Number green = (abs(node.x) - LUMINANCE.r * node.y - LUMINANCE.b * node.z) / LUMINANCE.g;
    return vec3(node.y, green, node.z);
}
