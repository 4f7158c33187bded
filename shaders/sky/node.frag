#include "fast/blocks.glsl"
#include "sky/along.glsl"

// A node of what is around the drops under one sun.

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
    node = toNode(around(ray, skyPlace(sky, ray, above, falls), onward, 0.0), falls);
    if (length(onward - sky.towards) < nearSun) node.x = MISS;
}
