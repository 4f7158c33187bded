#include "fast/blocks.glsl"
#include "sky/node.glsl"

// One pixel of what is around the drops, from the nodes about it, where its block is smooth.

uniform float blockSize;            // pixels between nodes
uniform sampler2D nodes;
uniform sampler2D flags;

out vec4 radiance;

void main() {
    bool rough = texelFetch(flags, blockOf(gl_FragCoord.xy, blockSize), 0).r > 0.5;
    vec2 place = nodePlace(gl_FragCoord.xy, blockSize, nodes);
    radiance = rough ? vec4(0.0) : vec4(fromNode(textureLod(nodes, place, 0.0)), 1.0);
}
