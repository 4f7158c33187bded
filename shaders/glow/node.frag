#include "fast/blocks.glsl"
#include "glow/along.glsl"
#include "sky/node.glsl"

// A node of the rain's own glow.

uniform Camera camera;
uniform Glow glow;
uniform Volume volume;
uniform float blockSize;            // pixels between nodes

out vec4 node;

void main() {
    Direction ray = rayThrough(camera, nodePixel(gl_FragCoord.xy, blockSize));
    node = toNode(glowAlong(glow, volume, ray), false, 0.0);
}
