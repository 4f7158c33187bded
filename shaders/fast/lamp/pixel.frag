#include "fast/lamp/path.glsl"
#include "fast/blocks.glsl"
#include "common/colour.glsl"

// One pixel of method `fast` under one lamp: few steps along its own ray, and what they miss from the
// nodes around it; in flagged blocks many steps.

uniform int fewSteps;
#if BLOCKS
uniform int manySteps;
uniform sampler2D nodes;
uniform sampler2D flags;
#endif

out vec4 radiance;

void main() {
    Direction ray = rayAt(gl_FragCoord.xy);
    vec2 span = boxSpan(ray, boxLow, boxHigh);
    radiance = vec4(0.0, 0.0, 0.0, 1.0);
    if (span.x < span.y) {
        int steps = fewSteps;
        Tristimulus rest = vec3(0.0);
#if BLOCKS
        bool flagged = texelFetch(flags, blockOf(gl_FragCoord.xy), 0).r > 0.5;
        if (flagged) steps = manySteps;
        else rest = textureLod(nodes, nodePlace(gl_FragCoord.xy, nodes), 0.0).gba;
#endif
        radiance.rgb = xyzToRgb(marchLamp(ray, span, steps) + rest);
    }
}
