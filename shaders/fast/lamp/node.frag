#include "common/box.glsl"
#include "common/camera.glsl"
#include "fast/blocks.glsl"
#include "fast/lamp/path.glsl"

// A node of method `fast` under a lamp: by how much a few steps along its ray miss what many give.

uniform Camera camera;
uniform Volume volume;
uniform Columns air;
uniform RadiusRows rows;
uniform LampScene scene;
uniform float blockSize;            // pixels between nodes
uniform int fewSteps;
uniform int manySteps;

out vec4 rest;                      // luminance of the whole; X, Y, Z of the difference

void main() {
    Direction ray = rayThrough(camera, nodePixel(gl_FragCoord.xy, blockSize));
    vec2 span = boxSpan(ray, volume.low, volume.high);
    bool hits = span.x < span.y;
    Number across = shareAcross(camera, scene.lamp.centre, ray);
    Tristimulus many =
        marchLamp(ray, span, hits ? manySteps : 0, scene, volume, air, rows, across);
    Tristimulus few = marchLamp(ray, span, hits ? fewSteps : 0, scene, volume, air, rows, across);
    rest = hits ? vec4(many.y, many - few) : vec4(MISS, 0.0, 0.0, 0.0);
}
