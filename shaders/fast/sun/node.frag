#include "fast/sun/path.glsl"
#include "fast/blocks.glsl"

// A node of method `fast`: what its ray gathers for one sun.

layout(location = 0) out vec4 path;
#if SEVERAL_RADII
layout(location = 1) out vec4 hats[HAT_GROUPS];
#endif

void main() {
    Direction ray = rayAt(nodePixel(gl_FragCoord.xy));
    vec2 span = boxSpan(ray, boxLow, boxHigh);
    path = vec4(MISS, 0.0, 0.0, 0.0);
    int count = 0;
    if (span.x < span.y) {
        count = stepCount(span.y - span.x, ray, cellsPerMetre, airPerMetre, fixedSteps);
    }
#if SEVERAL_RADII
    Radii radii;
    clear(radii);
    SunPath found = gatherSun(ray, span, count, radii);
    Number perMetre = count > 0 ? 1.0 / (span.y - span.x) : 0.0;
    for (int g = 0; g < HAT_GROUPS; ++g) hats[g] = perMetre * radii.weights[g];
#else
    SunPath found = gatherSun(ray, span, count);
#endif
    if (count > 0) path = vec4(found.weight, found.column, found.depth, 0.0);
}
