#include "common/definitions.glsl"

// What varies smoothly over the picture is computed at nodes some pixels apart, on the corners of
// blocks of pixels, and interpolated within each block; blocks where that would not do are flagged.

#if BLOCKS
const Number MISS = -1.0;           // stored where a node's ray misses the rain

// Place of a node in the picture, pixels; `block`: pixels between nodes, a whole number.
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

// Estimates by how much linear interpolation between the nodes b and c misses, from the nodes a and d
// beyond them. A smooth f misses by h^2 f'' / 8 at most, half-way between nodes h apart, and h^2 f'' is
// its second difference: the error is an eighth of that. A kink at a share t of the way, where the
// slope changes by s per node, misses by t (1 - t) s at the kink, and the second differences at b and
// c are (1 - t) s and t s: the error is a share min(t, 1 - t) of the greater one, which is a half at
// most and a quarter in the mean over t. So a quarter of the greater second difference is twice the
// error of a smooth f, and that of a kink at an ordinary place; one half-way between nodes, at
// most s / 4, is taken for half of that. Where a or d misses the rain, f is taken to be level beyond
// b or c: what is left of the second difference is c - b. Where there is something on both sides of an
// edge, f is taken to go on across it.
vec4 bend(vec4 a, vec4 b, vec4 c, vec4 d) {
#if SIDES
    if (a.x < 0.0) a = 2.0 * b - c;
    if (d.x < 0.0) d = 2.0 * c - b;
#endif
    return a.x < 0.0 || d.x < 0.0 ? 0.25 * abs(c - b)
                                  : 0.25 * max(abs(a - 2.0 * b + c), abs(b - 2.0 * c + d));
}
#endif
