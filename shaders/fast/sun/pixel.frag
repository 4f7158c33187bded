#include "common/box.glsl"
#include "common/camera.glsl"
#include "common/colour.glsl"
#include "common/footprint.glsl"
#include "fast/blocks.glsl"
#include "fast/sun/row_light.glsl"
#include "fast/sun/path.glsl"

// One pixel of method `fast` under one sun: what its ray gathers, from the nodes around it or its own
// march, times the colours of its own scattering angle.

uniform Camera camera;
uniform Volume volume;
uniform March march;
uniform Columns air;
uniform RadiusRows rows;
uniform ColourTable table;
uniform vec3 sunDirection;          // towards the sun
#if HAZE
uniform Haze haze;
uniform float hazeMiddle;           // depth at 550 nm that the tables are behind
uniform vec3 hazeExcess;            // of X, Y and Z over that at 550 nm, per depth
#endif
#if BLOCKS
uniform float blockSize;            // pixels between nodes
uniform sampler2D nodes;
uniform sampler2D flags;
#if SEVERAL_RADII
uniform sampler2D hats;
uniform float hatRow;               // row of the first hat, for volumes with more than one pass holds
uniform bool marching;              // flagged blocks march in the first pass, others' share is in all
#endif
#endif

out vec4 radiance;

#if BLOCKS && SEVERAL_RADII
// Sum over the groups of rows that the block has drops of: light per metre. `place`: of the pixel
// among the nodes, whose groups lie above each other in `hats`.
Tristimulus hatLight(sampler2D hats, vec2 place, Number firstRow, vec2 groups, ColourTable table,
                     Texel texel, Number perpendicular) {
    vec2 size = vec2(textureSize(hats, 0));
    float height = size.y / float(HAT_GROUPS);
    Tristimulus light = vec3(0.0);
    float g = groups.x;
    do {
        vec4 weight = textureLod(hats, (place + vec2(0.0, g * height)) / size, 0.0);
        Number row = firstRow + 4.0 * g;
        for (int k = 0; k < 4; ++k) {
            light += weight[k] * colourOf(table.values, texel, row + float(k), perpendicular);
        }
        g += 1.0;
    } while (g <= groups.y);
    return light;
}
#endif

void main() {
    Direction ray = pixelRay(camera, gl_FragCoord.xy);
    vec2 span = boxSpan(ray, volume.low, volume.high);
#if PIXEL_EDGES
    PixelSpan seen = PixelSpan(ray, span, 1.0, vec2(1.0));
    SoftBox box = SoftBox(span, vec3(0.0));
#if BLOCKS
    if (texelFetch(flags, blockOf(gl_FragCoord.xy, blockSize), 0).r > 0.5)
#endif
    {
#if EXTINCTION && !GRID
        Number extinction = volume.extinction;
#else
        const Number extinction = 0.0;
#endif
        seen = pixelSpan(camera, gl_FragCoord.xy, ray, span, volume.low, volume.high, extinction);
#if GRID
        // Drops differ along the ray: it is marched with the share of the pixel that is inside.
        box = softBox(camera, ray, volume.low, volume.high);
        seen.span = box.span;
        seen.share = 1.0;
#else
        ray = seen.ray;
#endif
    }
    span = seen.span;
#endif
    radiance = vec4(0.0, 0.0, 0.0, 1.0);
    Way way = wayAlong(ray, span, march, air);
    if (way.lit <= 0.0) return;
#if PIXEL_LEVELS && PIXEL_EDGES
    Texel texel = texelOver(table, foldedChord(sunDirection, seen.ray),
                            seen.extents * chordExtent(camera, sunDirection, seen.ray));
#elif PIXEL_LEVELS
    Texel texel = texelOver(table, foldedChord(sunDirection, ray),
                            chordExtent(camera, sunDirection, ray));
#else
    Texel texel = texelOf(table, foldedChord(sunDirection, ray));
#endif
    Number perpendicular = shareAcross(camera, sunDirection, ray);
#if DIRECT == 1
    // Even drops in clear space: no march.
    SunPath path = SunPath(volume.density, 0.0, 0.0, 0.0);
#else
#if BLOCKS
    vec4 flag = texelFetch(flags, blockOf(gl_FragCoord.xy, blockSize), 0);
    bool flagged = flag.r > 0.5;
    if (!flagged) way = unmarched(way);
#if SEVERAL_RADII
    if (!marching) way = unmarched(way);
#endif
#endif
    Gathered gathered = Gathered(texel, perpendicular, vec3(0.0));
    SunPath path = gatherSun(ray, way, sunDirection, volume, air, rows, table, gathered
#if HAZE
                             , haze, hazeMiddle
#endif
#if PIXEL_EDGES
                             , box
#endif
                             );
#if SEVERAL_RADII
    Tristimulus light = gathered.light;
#endif
#endif
#if BLOCKS
    if (!flagged) {
        vec4 between = textureLod(nodes, nodePlace(gl_FragCoord.xy, blockSize, nodes), 0.0);
        path = SunPath(between.x, between.y, between.z, between.w);
#if SEVERAL_RADII
        light = way.lit * hatLight(hats, gl_FragCoord.xy / blockSize + 1.5, hatRow, 255.0 * flag.gb,
                                 table, texel, perpendicular);
#endif
    }
#endif
#if !SEVERAL_RADII
    Tristimulus light = path.weight * way.lit * colourOf(table.values, texel, 0.0, perpendicular);
#endif
#if PIXEL_EDGES
    light *= seen.share;
#endif
#if AIR
    // Beyond the tables' columns there is no light to colour, and no polynomial to trust.
    path.column = clamp(path.column, -air.reach, air.reach);
#endif
#if HAZE
    light *= exp(-hazeExcess * path.haze);
#endif
    radiance.rgb = xyzToRgb(light * fallOff(table.values, texel, path.column, path.depth));
}
