#include "fast/blocks.glsl"
#include "sky/along.glsl"
#include "sky/node.glsl"

// A node of what is around the drops under one sun.

uniform Camera camera;
uniform Sky sky;
#if EXTINCTION
uniform Volume volume;
#define RAIN volume,
#else
#define RAIN
#endif
uniform float blockSize;            // pixels between nodes
uniform Angle nearSun;              // chord about the sun within which it is drawn at every pixel

out vec4 node;

void main() {
    Direction ray = rayThrough(camera, nodePixel(gl_FragCoord.xy, blockSize));
    Angle above = altitudeOf(ray) - sky.horizon;
    bool falls = above < 0.0;
    Direction onward = ray;
#if WATER
    if (falls) onward = mirrored(sky, ray);
#endif
    // From one node about the sun to the next that changes.
    ivec2 at = ivec2(gl_FragCoord.xy);
    Number rough = length(onward - sky.towards) < nearSun ? float((at.x + at.y) % 2) : 0.0;
    node = toNode(around(camera, sky, RAIN ray, skyPlace(sky, ray, above, falls), onward, 0.0), falls, rough);
}
