#include "common/definitions.glsl"
#include "common/math.glsl"

// Light already summed over wavelengths (rtbow/render/colours/table.py): X, Y, Z per drop and
// scattering angle for one light behind the scene's middle air column, and how it falls off with more
// column and rain. Blocks of rows: one or two components, then the fall-offs; rows of radius in each.
struct ColourTable {
    sampler2D values;
    Number first;          // folded chord of the first texel
    Number perChord;       // texels per unit of it
#if PIXEL_LEVELS
    Number leastExtent;    // logarithm that the first level stands for, of a pixel's squared extent
    Number blur;           // and of the square of what is blurred anyway, rad
    Number perLevel;       // levels per unit of that logarithm
#endif
};

// A place in the table: its column; where it has levels of smoothing for pixels of several extents,
// the level, too. They lie above each other for each row.
#if PIXEL_LEVELS
#define Texel vec2
#else
#define Texel Number
#endif

// Rows of radius, evenly in the logarithm.
struct RadiusRows {
    Number middle;         // logarithm of the radius that weights are counted from
#if SEVERAL_RADII
    Number first;          // the first row's from there
    Number perFold;        // rows per factor e
#endif
};

Number texelOf(ColourTable table, Number chord) {
    return (chord - table.first) * table.perChord;
}

// Folded chord of the angle theta between unit vectors, 0 to 2 sqrt(2). Up to a right angle it is
// |u - v| = 2 sin(theta / 2). That would be level at theta = pi, where it would lose the angle's
// digits; so beyond a right angle it is 2 sqrt(2) - |u + v|, where |u + v| = 2 cos(theta / 2). Value
// and slope of both agree at the right angle. A root is all it costs, and float32 leaves 3.4e-7 rad at
// any angle, where an arc cosine of dot(u, v) leaves 5e-4 at the poles.
Number foldedChord(Direction u, Direction v) {
    bool back = dot(u, v) < 0.0;
    vec3 side = back ? u + v : u - v;
    Number chord = sqrt(dot(side, side));
    return back ? 2.0 * RIGHT_ANGLE_CHORD - chord : chord;
}

// Folded chord of the scattering angle at a place along a ray that passes a lamp at a distance `side`;
// `place` is counted from the foot, where the angle is a right one. In front of the foot
// cos(theta) = |place| / away, and 2 sin(theta / 2) = sqrt(2 (away - |place|) / away); a difference
// of like numbers is avoided by (away - |place|) (away + |place|) = side^2. Behind it all is mirrored.
Number foldedChordAt(Length side, Length place) {
    Length away = length(vec2(side, place));
    Number chord = side * inversesqrt(0.5 * away * (away + abs(place)));
    return place > 0.0 ? 2.0 * RIGHT_ANGLE_CHORD - chord : chord;
}

// How fast that folded chord grows with the angle: by cos(theta / 2) = sqrt((1 + cos(theta)) / 2) up
// to a right angle, mirrored beyond.
Number chordSlopeAt(Length side, Length place) {
    Length away = length(vec2(side, place));
    return sqrt(0.5 * (1.0 + abs(place) / away));
}

#if PIXEL_LEVELS
// `row` is a whole one.
vec4 colourAt(sampler2D colours, Texel texel, Number row) {
    vec2 size = vec2(textureSize(colours, 0));
    Number column = clamp(texel.x, 0.0, size.x - 1.0) + 0.5;
    Number line = row * float(PIXEL_LEVELS * PIXEL_SHAPES) + texel.y + 0.5;
    return textureLod(colours, vec2(column, line) / size, 0.0);
}
#elif SEVERAL_RADII
// `row` need not be whole.
vec4 colourAt(sampler2D colours, Number texel, Number row) {
    vec2 size = vec2(textureSize(colours, 0));
    Number column = clamp(texel, 0.0, size.x - 1.0) + 0.5;
    return textureLod(colours, vec2(column, row + 0.5) / size, 0.0);
}
#else
// Two fetches by hand: a filtered one would read two more of the row beside.
vec4 colourAt(sampler2D colours, Number texel, Number row) {
    int last = textureSize(colours, 0).x - 1;
    Number column = clamp(texel, 0.0, float(last));
    int left = min(int(column), last - 1);
    return mix(texelFetch(colours, ivec2(left, int(row)), 0),
               texelFetch(colours, ivec2(left + 1, int(row)), 0), column - float(left));
}
#endif

#if PIXEL_LEVELS
// Place of a pixel in the table, from its extents u and v across the chord: the level by
// u^2 + v^2, of the nearest of the shapes, which are even in 2 u v / (u^2 + v^2).
Texel texelOver(ColourTable table, Number chord, vec2 extent) {
    Number squared = dot(extent, extent);
    Number level = (log(squared + table.blur) - table.leastExtent) * table.perLevel;
    Number line = clamp(level, 0.0, float(PIXEL_LEVELS - 1));
#if PIXEL_SHAPES > 1
    Number shape = 2.0 * abs(extent.x * extent.y) / max(squared, 1.0e-30) * float(PIXEL_SHAPES);
    line += float(PIXEL_LEVELS) * min(floor(shape), float(PIXEL_SHAPES - 1));
#endif
    return vec2(texelOf(table, chord), line);
}
#endif

// What is left of X, Y and Z behind `column` of air beyond the middle one and `depth` of rain.
Tristimulus fallOff(sampler2D colours, Texel texel, Column column, Number depth) {
    vec3 logarithm = vec3(0.0);
#if COLUMN_DEGREE
    for (int k = COLUMN_DEGREE; k > 0; --k) {
        vec3 coefficient = colourAt(colours, texel, float(COMPONENTS * RADIUS_ROWS + k - 1)).rgb;
        logarithm = (logarithm + coefficient) * column;
    }
#endif
#if RAIN_COLOUR
    logarithm += colourAt(colours, texel, float(COMPONENTS * RADIUS_ROWS + COLUMN_DEGREE)).rgb
        * depth;
#endif
#if COLUMN_DEGREE || RAIN_COLOUR
    return exp(logarithm);
#else
    return vec3(1.0);
#endif
}

// X, Y, Z per drop: of the radius of a row, times (radius / middle radius)^(7/3) for another.
// `perpendicular` is that component's share.
Tristimulus colourOf(sampler2D colours, Texel texel, Number row, Number perpendicular) {
    Number inside = clamp(row, 0.0, float(RADIUS_ROWS - 1));
#if POLARIZER
    vec3 parallel = colourAt(colours, texel, float(RADIUS_ROWS) + inside).rgb;
    return 0.5 * mix(parallel, colourAt(colours, texel, inside).rgb, perpendicular);
#else
    return colourAt(colours, texel, inside).rgb;
#endif
}
