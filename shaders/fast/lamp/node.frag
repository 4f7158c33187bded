#include "fast/lamp/path.glsl"
#include "fast/blocks.glsl"

// A node of method `fast` under a lamp: by how much a few steps along its ray miss what many give.

uniform int fewSteps;
uniform int manySteps;

out vec4 rest;                      // luminance of the whole; X, Y, Z of the difference

void main() {
    Direction ray = rayAt(nodePixel(gl_FragCoord.xy));
    vec2 span = boxSpan(ray, boxLow, boxHigh);
    bool hits = span.x < span.y;
    Tristimulus many = marchLamp(ray, span, hits ? manySteps : 0);
    Tristimulus few = marchLamp(ray, span, hits ? fewSteps : 0);
    rest = hits ? vec4(many.y, many - few) : vec4(MISS, 0.0, 0.0, 0.0);
}
