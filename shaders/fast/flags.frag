#include "fast/blocks.glsl"

// Which blocks of pixels are not to be interpolated: those at the edge of the rain, and those whose
// nodes say that a straight line between them errs by more than the tolerance. And which groups of
// rows of radius any node of the block has drops of.

uniform sampler2D nodes;
struct Tolerance {
    Number first;                   // of the nodes' first channel, as a share of its mean
    vec3 others;                    // absolute; with PARTS as shares of the first channel's mean, too
};
uniform Tolerance tolerance;
#if SEVERAL_RADII
uniform sampler2D hats;             // groups side by side, as fast/sun/hats.frag puts them
uniform float leastShare;           // of a block's weight that a group must have to count
#endif

out vec4 flag;                      // flagged; first and last group over 255

void main() {
    ivec2 last = textureSize(nodes, 0) - 1;
    ivec2 corner = ivec2(gl_FragCoord.xy) + 1;
    vec4 n[16];
    for (int y = 0; y < 4; ++y) {
        for (int x = 0; x < 4; ++x) {
            n[4 * y + x] = texelFetch(nodes, corner + ivec2(x - 1, y - 1), 0);
        }
    }
#if SIDES
    // On the other side of an edge than the block's first corner the first channel counts as a miss.
    if (n[5].x < 0.0) {
        for (int k = 0; k < 16; ++k) n[k].x = -n[k].x;
    }
#endif
    // Bilinear interpolation is linear along x, then along y, so that both errors add: each from the
    // worse of the block's two rows, or columns, of nodes.
    vec4 error = max(bend(n[4], n[5], n[6], n[7]), bend(n[8], n[9], n[10], n[11]))
        + max(bend(n[1], n[5], n[9], n[13]), bend(n[2], n[6], n[10], n[14]));
    float level = 0.25 * (n[5].x + n[6].x + n[9].x + n[10].x);
    float least = min(min(n[5].x, n[6].x), min(n[9].x, n[10].x));
    float most = max(max(n[5].x, n[6].x), max(n[9].x, n[10].x));
#if PARTS
    error /= max(level, 1.0e-30);
#else
    error.x /= max(level, 1.0e-30);
#endif
    bool rough = most > 0.0 && any(greaterThan(error, vec4(tolerance.first, tolerance.others)));
    // Pixels between nodes that all miss may hit a thin part of the rain.
    bool edge = least < 0.0;
    flag = vec4(edge || rough ? 1.0 : 0.0, 0.0, 0.0, 0.0);
#if SEVERAL_RADII
    int first = HAT_GROUPS - 1;
    int end = 0;
    for (int g = 0; g < HAT_GROUPS; ++g) {
        ivec2 at = corner + ivec2(0, g * (last.y + 1));
        vec4 sum = texelFetch(hats, at, 0) + texelFetch(hats, at + ivec2(1, 0), 0)
            + texelFetch(hats, at + ivec2(0, 1), 0) + texelFetch(hats, at + ivec2(1, 1), 0);
        if (dot(sum, vec4(1.0)) > leastShare * 4.0 * max(level, 0.0)) {
            first = min(first, g);
            end = g;
        }
    }
    flag.gb = vec2(min(first, end), end) / 255.0;
#endif
}
