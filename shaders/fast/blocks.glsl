#include "common/definitions.glsl"

// What varies smoothly over the picture is computed at nodes some pixels apart, on the corners of
// blocks of pixels, and interpolated within each block; blocks where that would not do are flagged.

#if BLOCKS
const Number MISS = -1.0;           // stored where a node's ray misses the rain

// Where in the picture a node lies; `block`: pixels between nodes, a whole number.
vec2 nodePixel(vec2 fragment, float block) {
    // One ring of nodes lies outside of the picture.
    return (fragment - 1.5) * block;
}

// The block that a pixel is in.
ivec2 blockOf(vec2 pixel, float block) {
    return ivec2(pixel / block);
}

// Texture coordinate of a pixel among the nodes.
vec2 nodePlace(vec2 pixel, float block, sampler2D nodes) {
    return (pixel / block + 1.5) / vec2(textureSize(nodes, 0));
}

// Error of a linear interpolation half-way between b and c at most, from the nodes beyond them: a kink
// there is a quarter of its second difference. Where one of these misses, a part of their difference.
vec4 bend(vec4 a, vec4 b, vec4 c, vec4 d) {
    return a.x < 0.0 || d.x < 0.0 ? 0.25 * abs(c - b)
                                  : 0.25 * max(abs(a - 2.0 * b + c), abs(b - 2.0 * c + d));
}
#endif
