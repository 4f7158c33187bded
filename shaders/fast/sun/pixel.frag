#include "fast/sun/path.glsl"
#include "fast/blocks.glsl"
#include "fast/colours.glsl"
#include "common/polarizer.glsl"
#include "common/colour.glsl"

// One pixel of method `fast` under one sun: what its ray gathers, from the nodes around it or its own
// march, times the colours of its own scattering angle.

uniform vec2 chordAxis;             // folded chord of the table's first texel; texels per unit
#if !SEVERAL_RADII
uniform sampler2D colours;
#endif
#if BLOCKS
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
// Sum over the groups of rows that the block has drops of: light per metre.
Tristimulus hatLight(Number texel, Number perpendicular, vec2 groups) {
    vec2 size = vec2(textureSize(hats, 0));
    float rows = size.y / float(HAT_GROUPS);
    vec2 at = gl_FragCoord.xy / blockSize + 1.5;
    Tristimulus light = vec3(0.0);
    float g = groups.x;
    do {
        vec4 weight = textureLod(hats, (at + vec2(0.0, g * rows)) / size, 0.0);
        Number row = hatRow + 4.0 * g;
        for (int k = 0; k < 4; ++k) {
            light += weight[k] * colourOf(colours, texel, row + float(k), perpendicular);
        }
        g += 1.0;
    } while (g <= groups.y);
    return light;
}
#endif

void main() {
    Direction ray = rayAt(gl_FragCoord.xy);
    vec2 span = boxSpan(ray, boxLow, boxHigh);
    radiance = vec4(0.0, 0.0, 0.0, 1.0);
    if (span.x < span.y) {
        Number texel = (foldedChord(sunDirection, ray) - chordAxis.x) * chordAxis.y;
#if POLARIZER
        Number perpendicular = perpendicularShare(sunDirection, ray, polarizerPass);
#else
        Number perpendicular = 0.5;
#endif
        Length along = span.y - span.x;
#if DIRECT == 1
        // Even drops in clear space: no march.
        SunPath path = SunPath(uniformDensity, 0.0, 0.0);
#else
#if DIRECT
        int count = DIRECT;
#else
        int count = stepCount(along, ray, cellsPerMetre, airPerMetre, fixedSteps);
#endif
#if BLOCKS
        vec4 flag = texelFetch(flags, blockOf(gl_FragCoord.xy), 0);
        bool flagged = flag.r > 0.5;
        if (!flagged) count = 0;
#endif
#if SEVERAL_RADII
        Radii radii = Radii(texel, perpendicular, vec3(0.0));
#if BLOCKS
        if (!marching) count = 0;
#endif
        SunPath path = gatherSun(ray, span, count, radii);
        Tristimulus light = radii.light;
#else
        SunPath path = gatherSun(ray, span, count);
#endif
#endif
#if BLOCKS
        if (!flagged) {
            vec4 between = textureLod(nodes, nodePlace(gl_FragCoord.xy, nodes), 0.0);
            path = SunPath(between.x, between.y, between.z);
#if SEVERAL_RADII
            light = along * hatLight(texel, perpendicular, 255.0 * flag.gb);
#endif
        }
#endif
#if !SEVERAL_RADII
        Tristimulus light = path.weight * along * colourOf(colours, texel, 0.0, perpendicular);
#endif
#if AIR
        // Beyond the tables' columns there is no light to colour, and no polynomial to trust.
        path.column = clamp(path.column, -columnReach, columnReach);
#endif
        radiance.rgb = xyzToRgb(light * fallOff(colours, texel, path.column, path.depth));
    }
}
