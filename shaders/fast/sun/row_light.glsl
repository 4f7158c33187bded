#include "common/definitions.glsl"
#include "fast/colours.glsl"

// Where drops differ in size, a ray's light is a sum over rows of radius: each drop counts at its two
// neighbours among the rows, linearly; the rows are fitted to all radii between them
// (rtbow/render/colours/table.py). A pixel keeps the light of all rows.

struct Gathered {
    Texel texel;           // of the pixel's scattering angle along the table
    Number perpendicular;
    Tristimulus light;
};

#if SEVERAL_RADII
void gatherRow(inout Gathered gathered, ColourTable table, Number reach, Number row) {
#if PIXEL_LEVELS
    // Between rows by hand: the filter is for the levels.
    Number below = min(floor(row), float(RADIUS_ROWS - 2));
    gathered.light += reach
        * mix(colourOf(table.values, gathered.texel, below, gathered.perpendicular),
              colourOf(table.values, gathered.texel, below + 1.0, gathered.perpendicular),
              row - below);
#else
    gathered.light += reach * colourOf(table.values, gathered.texel, row, gathered.perpendicular);
#endif
}
#endif
