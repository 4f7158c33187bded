#include "common/definitions.glsl"
#include "common/math.glsl"
#include "air/atmosphere.glsl"
#include "air/earth_shadow.glsl"

// Air columns as method `fast` counts them: from the middle of the range that its tables cover. The
// weights of a path carry the depth of a grey air; the tables have the rest.
struct Columns {
    Length eyeHeight;
#if AIR
    Column reach;          // of the tables, about the middle
    Number grey;           // depth per column that weights carry
#if NEAR_AIR
    Column perMetre;       // at the eye
#endif
#if SHADOW || !SUN
    Column middle;
#endif
#if SHADOW
    Angle sunAltitude;     // of a sun at the horizon, whose columns no cubic follows
    sampler2D table;       // of the columns towards it (sunColumn)
#if PIECES > 1
    EarthShadow shadow;    // whose edge crosses the rain
#endif
#elif SUN
    vec4 sunward;          // column towards the sun less the middle: cubic in the height
#endif
#endif
};

#if AIR && SUN
// Air column towards sun and eye, less the middle column.
Column columnAt(Columns air, Position at, Direction ray, Length distance) {
    Length height = air.eyeHeight + at.z;
#if PIECES > 1
    Column towards = columnOverSphere(air.table, air.shadow, air.eyeHeight, ray, distance)
        - air.middle;
#elif SHADOW
    Column towards = sunColumn(air.table, height, air.sunAltitude) - air.middle;
#else
    vec4 c = air.sunward;
    Column towards = c.x + height * (c.y + height * (c.z + height * c.w));
#endif
#if NEAR_AIR
    // The closed form's series: heights change by a part of the scale height along the ray.
    return towards + air.perMetre * distance
        * meanDecayNearby(ray.z * distance / SCALE_HEIGHT_M);
#else
    // Far below the ground, or in the Earth's shadow: no light, but a number all the same.
    return min(towards + segmentColumn(air.eyeHeight, ray.z, distance), DARK);
#endif
}

// What the grey part of that column leaves.
Number greyLeft(Columns air, Column column) {
    Number depth = air.grey * column;
#if NEAR_AIR
    return 1.0 - depth * (1.0 - depth * (0.5 - depth * (1.0 / 6.0 - depth / 24.0)));
#else
    return exp(-depth);
#endif
}
#endif
