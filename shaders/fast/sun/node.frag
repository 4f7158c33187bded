#include "common/box.glsl"
#include "common/camera.glsl"
#include "fast/blocks.glsl"
#include "fast/sun/row_weights.glsl"
#include "fast/sun/path.glsl"

// A node of method `fast` under a sun: what its ray gathers.

uniform Camera camera;
uniform Volume volume;
uniform March march;
uniform Columns air;
uniform RadiusRows rows;
uniform ColourTable table;          // never read: nodes keep weights
uniform vec3 sunDirection;          // towards the sun
#if HAZE
uniform Haze haze;
uniform float hazeMiddle;           // depth at 550 nm that the tables are behind
uniform vec3 hazeExcess;            // of X, Y and Z over that at 550 nm, per depth
#endif
uniform float blockSize;            // pixels between nodes
uniform float firstRow;             // of the rows that this pass keeps

layout(location = 0) out vec4 path;
#if SEVERAL_RADII
layout(location = 1) out vec4 hats[HAT_GROUPS];
#endif

void main() {
    Direction ray = rayThrough(camera, nodePixel(gl_FragCoord.xy, blockSize));
    vec2 span = boxSpan(ray, volume.low, volume.high);
    path = vec4(MISS, 0.0, 0.0, 0.0);
    Way way = wayAlong(ray, span, march, air);
    Gathered gathered = nothingYet(firstRow);
    SunPath sunPath = gatherSun(ray, way, sunDirection, volume, air, rows, table, gathered
#if HAZE
                              , haze, hazeMiddle
#endif
                              );
#if SEVERAL_RADII
    Number perMetre = way.lit > 0.0 ? 1.0 / way.lit : 0.0;
    for (int g = 0; g < HAT_GROUPS; ++g) hats[g] = perMetre * gathered.weights[g];
#endif
    if (way.lit > 0.0) path = vec4(sunPath.weight, sunPath.column, sunPath.depth, sunPath.haze);
}
