#include "common/definitions.glsl"
#include "common/math.glsl"

struct Air {
    Length eyeHeight;
#if AIR && SUN_COUNT
    sampler2D columns;     // logarithms of the columns towards the sun (sunColumn)
#endif
};

// Altitude (negative) at which a ray from a height grazes the ground. The argument of the arc sine
// is below 0.04, where its series is exact in float32 and Mesa's asin is not.
Angle horizonAltitude(Length height) {
    float x = sqrt(0.5 * height / (EARTH_RADIUS_M + height));
    return -2.0 * x * (1.0 + x * x / 6.0);
}

// Texture coordinates of a height and an altitude above its horizon (ColumnTable on the host).
vec2 columnTexel(Length height, Angle altitude, vec2 size) {
    Angle horizon = horizonAltitude(height);
    float above = clamp((altitude - horizon) / (0.5 * PI - horizon), 0.0, 1.0);
    float q = log(1.0 + above * (exp(ALTITUDE_CURVE) - 1.0)) / ALTITUDE_CURVE;
    return vec2(texelCentred(q, size.x), texelCentred(sqrt(height / MAX_HEIGHT_M), size.y));
}

// Air column from a height towards a sun that the Earth is not in the way of. Within 1e-4 of the
// integral up to MAX_HEIGHT_M.
Column litColumn(sampler2D logColumn, Length height, Angle altitude) {
    Length h = clamp(height, 0.0, MAX_HEIGHT_M);
    vec2 size = vec2(textureSize(logColumn, 0));
    Column column = exp(texture(logColumn, columnTexel(h, altitude, size)).r);
    // Beyond both ends of the texture the column follows the density.
    return column * exp((h - height) / SCALE_HEIGHT_M);
}

// The same for any sun: so large that nothing passes where the Earth is in the way.
Column sunColumn(sampler2D logColumn, Length height, Angle altitude) {
    if (altitude < horizonAltitude(clamp(height, 0.0, MAX_HEIGHT_M))) return 1.0e30;
    return litColumn(logColumn, height, altitude);
}

// Air column of a straight segment that starts at a height and rises by `rise` per metre.
Column segmentColumn(Length height, Number rise, Length distance) {
    // From the lower end: exp(-u) would overflow on a long way down from thin air.
    float u = rise * distance / SCALE_HEIGHT_M;
    Length low = height + min(rise * distance, 0.0);
    return exp(-low / SCALE_HEIGHT_M) * distance / SCALE_HEIGHT_M * meanDecay(abs(u));
}
