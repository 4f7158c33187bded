#include "common/box.glsl"
#include "common/camera.glsl"
#include "common/colour.glsl"
#include "common/footprint.glsl"
#include "fast/blocks.glsl"
#include "fast/lamp/path.glsl"

// One pixel of method `fast` under one lamp: few steps along its own ray, and what they miss from the
// nodes around it; in flagged blocks many steps.

uniform Camera camera;
uniform Volume volume;
uniform Columns air;
uniform RadiusRows rows;
uniform LampScene scene;
uniform int fewSteps;
#if BLOCKS
uniform float blockSize;            // pixels between nodes
uniform int manySteps;
uniform sampler2D nodes;
uniform sampler2D flags;
#endif

out vec4 radiance;

void main() {
    Direction ray = pixelRay(camera, gl_FragCoord.xy);
    vec2 span = boxSpan(ray, volume.low, volume.high);
    radiance = vec4(0.0, 0.0, 0.0, 1.0);
#if !PIXEL_EDGES
    if (span.x >= span.y) return;
#endif
    int steps = fewSteps;
    Tristimulus rest = vec3(0.0);
#if BLOCKS
    bool flagged = texelFetch(flags, blockOf(gl_FragCoord.xy, blockSize), 0).r > 0.5;
    if (flagged) steps = manySteps;
    else rest = textureLod(nodes, nodePlace(gl_FragCoord.xy, blockSize, nodes), 0.0).gba;
#endif
    Number perpendicular = shareAcross(camera, scene.lamp.centre, ray);
#if PIXEL_EDGES
    int points = 1;
#if BLOCKS
    if (flagged || LAMP_WIDE)
#endif
    points = lampPoints(camera, ray, volume.low, volume.high, scene.lamp.centre);
    Tristimulus sum = vec3(0.0);
    for (int k = 0; k < points; ++k) {
        Direction one = lampPointRay(camera, gl_FragCoord.xy, k, points);
        vec2 within = boxSpan(one, volume.low, volume.high);
        if (within.x >= within.y) continue;
        sum += rest + marchLamp(one, within, steps, scene, volume, air, rows, perpendicular);
    }
    radiance.rgb = xyzToRgb(sum / float(points));
#else
    radiance.rgb = xyzToRgb(
        marchLamp(ray, span, steps, scene, volume, air, rows, perpendicular) + rest);
#endif
}
