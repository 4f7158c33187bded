#include "common/definitions.glsl"
#include "common/math.glsl"
#include "fast/scene.glsl"
#include "fast/sun/radii.glsl"

// What a ray through the rain gathers for one sun, before any colour: its drops' weight and the mean
// circumstances of their light. The light itself follows from a table at the pixel's own angle.

#if SUN
uniform vec3 sunDirection;      // towards the sun
#if AIR
uniform vec4 sunCubic;          // air column towards it less the middle column: cubic in the height
#if SHADOW
uniform sampler2D columnTable;  // where no cubic will do: a sun at the horizon
uniform vec2 sunShadow;         // its altitude; the middle column
#endif
#endif

struct SunPath {
    Number weight;         // per metre: density, times radius^(7/3) where radii differ, attenuated
    Column column;         // mean air column towards sun and eye, above the middle
    Number depth;          // mean depth of the rain
};

#if AIR
// Air column towards sun and eye, less the middle column.
Column columnAt(Position at, Direction ray, Length distance) {
    Length height = eyeHeight + at.z;
#if SHADOW
    Column towards = sunColumn(columnTable, height, sunShadow.x) - sunShadow.y;
#else
    Column towards = sunCubic.x + height * (sunCubic.y + height * (sunCubic.z + height * sunCubic.w));
#endif
#if NEAR_AIR
    // The closed form's series: heights change by a part of the scale height along the ray.
    float u = ray.z * distance / SCALE_HEIGHT_M;
    return towards + eyeAir * distance
        * (1.0 - u * (0.5 - u * (1.0 / 6.0 - u * (1.0 / 24.0 - u / 120.0))));
#else
    // Far below the ground, or in the Earth's shadow: no light, but a number all the same.
    return min(towards + segmentColumn(eyeHeight, ray.z, distance), DARK);
#endif
}

// What the grey part of that column leaves.
Number greyLeft(Column column) {
    Number depth = greyAir * column;
#if NEAR_AIR
    return 1.0 - depth * (1.0 - depth * (0.5 - depth * (1.0 / 6.0 - depth / 24.0)));
#else
    return exp(-depth);
#endif
}
#endif

// Equation 2 without its wavelengths, by the midpoint rule. `count` of 0 gathers nothing.
#if SEVERAL_RADII
#define RADII , inout Radii radii
#else
#define RADII
#endif
SunPath gatherSun(Direction ray, vec2 span, int count RADII) {
    SunPath sums = SunPath(0.0, 0.0, 0.0);
    Length stepLength = (span.y - span.x) / float(max(count, 1));
#if EXTINCTION
    Number toEye = 0.0;
    Number toSun = rainTowards(ray, span.x, sunDirection, 3.0e38);
#endif
    for (int i = 0; i < count; ++i) {
        Length distance = span.x + (float(i) + 0.5) * stepLength;
        Position at = distance * ray;
        Droplets drops = dropletsAt(at);
        Number reach = drops.density * stepLength;
        Number depth = 0.0;
        Column column = 0.0;
#if SEVERAL_RADII
        Number logRadius = log(max(drops.radius, 1.0e-7)) - middleRadius;
        reach *= exp(RADIUS_POWER * logRadius);
#endif
#if AIR
        column = columnAt(at, ray, distance);
        reach *= greyLeft(column);
#endif
#if EXTINCTION
        Number before = toEye + toSun;
        toEye += stepLength * drops.extinction;
        toSun = rainTowards(ray, distance + 0.5 * stepLength, sunDirection, 3.0e38);
        Number behind = toEye + toSun;
        depth = 0.5 * (before + behind);
        reach *= exp(-min(before, behind)) * meanDecay(abs(behind - before));
#endif
        sums.weight += reach;
        sums.column += reach * column;
        sums.depth += reach * depth;
#if SEVERAL_RADII
        Number row = (logRadius - radiusRows.x) * radiusRows.y;
        gatherRow(radii, reach, clamp(row, 0.0, float(RADIUS_ROWS - 1)));
#endif
    }
    Number whole = 1.0 / max(sums.weight, 1.0e-30);
    return SunPath(sums.weight / (span.y - span.x), sums.column * whole, sums.depth * whole);
}
#endif
