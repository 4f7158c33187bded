#include "common/definitions.glsl"
#include "fast/colours.glsl"

// Where drops differ in size, a ray's light is a sum over rows of radius: each drop counts at its two
// neighbours among the rows, linearly. Nodes keep the rows' weights, a pixel that marches by itself
// keeps the light that they come to. Rows are fitted to all radii between them (rtbow/render/colours/table.py).

#if SEVERAL_RADII
#if NODES
uniform float firstRow;             // of the rows that this pass keeps, HAT_GROUPS times four
struct Radii {
    vec4 weights[HAT_GROUPS];
};

void clear(out Radii radii) {
    for (int g = 0; g < HAT_GROUPS; ++g) radii.weights[g] = vec4(0.0);
}

void gatherRow(inout Radii radii, Number reach, Number row) {
    for (int g = 0; g < HAT_GROUPS; ++g) {
        vec4 away = abs(vec4(0.0, 1.0, 2.0, 3.0) + (firstRow + float(4 * g) - row));
        radii.weights[g] += reach * max(1.0 - away, 0.0);
    }
}
#else
uniform sampler2D colours;
struct Radii {
    Number texel;
    Number perpendicular;
    Tristimulus light;
};

void gatherRow(inout Radii radii, Number reach, Number row) {
    radii.light += reach * colourOf(colours, radii.texel, row, radii.perpendicular);
}
#endif
#endif
