#include "common/definitions.glsl"
#include "fast/colours.glsl"

// Where drops differ in size, a ray's light is a sum over rows of radius: each drop counts at its two
// neighbours among the rows, linearly; the rows are fitted to all radii between them
// (rtbow/render/colours/table.py). A node keeps the weights of four rows in each group.

struct Gathered {
    Number firstRow;       // of the rows that this pass keeps, HAT_GROUPS times four
#if SEVERAL_RADII
    vec4 weights[HAT_GROUPS];
#endif
};

Gathered nothingYet(Number firstRow) {
    Gathered gathered;
    gathered.firstRow = firstRow;
#if SEVERAL_RADII
    for (int g = 0; g < HAT_GROUPS; ++g) gathered.weights[g] = vec4(0.0);
#endif
    return gathered;
}

#if SEVERAL_RADII
void gatherRow(inout Gathered gathered, ColourTable table, Number reach, Number row) {
    for (int g = 0; g < HAT_GROUPS; ++g) {
        vec4 away = abs(vec4(0.0, 1.0, 2.0, 3.0) + (gathered.firstRow + float(4 * g) - row));
        gathered.weights[g] += reach * max(1.0 - away, 0.0);
    }
}
#endif
