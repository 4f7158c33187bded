#include "fast/blocks.glsl"

// Puts the groups of rows that nodes have weights of side by side in one texture, so that a pixel can
// loop over the few that its ray has drops of.

uniform sampler2D hats0;
#if HAT_GROUPS > 1
uniform sampler2D hats1;
#endif
#if HAT_GROUPS > 2
uniform sampler2D hats2;
#endif
#if HAT_GROUPS > 3
uniform sampler2D hats3;
#endif
#if HAT_GROUPS > 4
uniform sampler2D hats4;
#endif
#if HAT_GROUPS > 5
uniform sampler2D hats5;
#endif
#if HAT_GROUPS > 6
uniform sampler2D hats6;
#endif

out vec4 weights;

void main() {
    ivec2 size = textureSize(hats0, 0);
    ivec2 at = ivec2(gl_FragCoord.xy);
    int group = at.y / size.y;
    at.y -= group * size.y;
    weights = texelFetch(hats0, at, 0);
#if HAT_GROUPS > 1
    if (group == 1) weights = texelFetch(hats1, at, 0);
#endif
#if HAT_GROUPS > 2
    if (group == 2) weights = texelFetch(hats2, at, 0);
#endif
#if HAT_GROUPS > 3
    if (group == 3) weights = texelFetch(hats3, at, 0);
#endif
#if HAT_GROUPS > 4
    if (group == 4) weights = texelFetch(hats4, at, 0);
#endif
#if HAT_GROUPS > 5
    if (group == 5) weights = texelFetch(hats5, at, 0);
#endif
#if HAT_GROUPS > 6
    if (group == 6) weights = texelFetch(hats6, at, 0);
#endif
}
