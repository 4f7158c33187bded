#include "common/definitions.glsl"
#include "common/box.glsl"
#include "common/math.glsl"

// The rain's own extinction, at the middle of the visible; wavelengths differ by a factor each.

#if EXTINCTION
// Optical depth from a place in the box towards a light. The texture holds the mean extinction
// along that path, one block of levels per light; times the path's own length it is exact for even
// rain up to the box's edges. `place`: 0..1 along each side.
Number depthTowards(sampler3D towardsLights, vec3 place, int light, float lights, Length path) {
    vec3 size = vec3(textureSize(towardsLights, 0));
    float levels = size.z / lights;
    vec3 at = 0.5 + clamp(place, 0.0, 1.0) * (vec3(size.xy, levels) - 1.0);
    at.z += float(light) * levels;
    return textureLod(towardsLights, at / size, 0.0).r * path;
}

// A corner of the box from a place along a ray: exactly 0 on the face where the ray enters. In dense
// fog a rounding of the place by a tenth of a millimetre would be many optical depths.
Position cornerFrom(Position corner, Direction ray, Length distance) {
    Position from;
    for (int axis = 0; axis < 3; ++axis) {
        Number along = ray[axis];
        from[axis] = along == 0.0 ? corner[axis] : (corner[axis] / along - distance) * along;
    }
    return from;
}

// Length of the path out of the box from a place in it, given the corners from there.
Length pathOut(Direction towards, Position low, Position high) {
    // Rounding may put a place on a face a hair outside.
    return boxSpan(towards, min(low, 0.0), max(high, 0.0)).y;
}
#endif

#if EXTINCTION
// The rain's depth on light's way to a drop and on to the eye, over one step of a march.
struct RainDepth {
    Number toEye;          // from the eye to the end of the step
    Number toLight;        // from there to the light
    Number before;         // the whole way by the start of the step
    Number behind;         // and by its end
};

// The part of a ray's way through rain that is seen: beyond a depth of UNSEEN_DEPTH nothing is. Steps
// that follow the angle at a lamp would be many optical depths long otherwise. No shorter than a part
// of the distance that float32 still divides into steps; there rain and angle change evenly.
Length leastSeen(vec2 span) {
    return LEAST_SEEN * span.x;
}

// The same of even rain.
vec2 seenSpan(vec2 span, Number extinction) {
    Length deep = max(UNSEEN_DEPTH / max(extinction, 1.0e-30), leastSeen(span));
    return vec2(span.x, min(span.y, span.x + deep));
}

// Over a step between two places, from the depths to the eye (x) and to the light (y) of each.
RainDepth rainOver(vec2 start, vec2 end) {
    return RainDepth(end.x, end.y, start.x + start.y, end.x + end.y);
}

// At the start of a march, or of a part of it that begins `toEye` deep.
RainDepth rainDepth(Number toEye, Number toLight) {
    return rainOver(vec2(toEye, toLight), vec2(toEye, toLight));
}

// Takes a step through `passed` of depth, to a place `toLight` deep.
void advance(inout RainDepth rain, Number passed, Number toLight) {
    rain = rainOver(vec2(rain.toEye, rain.toLight), vec2(rain.toEye + passed, toLight));
}

// The lesser depth of the step's ends.
Number leastDepth(RainDepth rain) {
    return min(rain.before, rain.behind);
}

// By how much its ends differ.
Number depthRise(RainDepth rain) {
    return abs(rain.behind - rain.before);
}

// What a step leaves of the light: the mean over it, its depth growing evenly.
Number rainLeft(RainDepth rain) {
    return exp(-leastDepth(rain)) * meanDecay(depthRise(rain));
}
#endif

#if ATTENUATION
// What air and rain leave of a wavelength's light, as the mean over a step on which the rain's depth
// grows from `depth` by `rise`. weight: depth of the air per column; haze: depth of aerosol at 550 nm.
Number attenuation(sampler2D spectral, int wavelength, Number weight, Column column, Number depth,
                   Number rise, Number haze) {
    Number passed = 1.0;
#if HAZE
    passed = exp(-texelFetch(spectral, ivec2(wavelength, HAZE_ROW), 0).r * haze);
#endif
#if EXTINCTION
    // Small drops' extinction differs between wavelengths by up to a factor of two.
    Number ratio = texelFetch(spectral, ivec2(wavelength, RAIN_ROW), 0).r;
    return passed * exp(-weight * column - ratio * depth) * meanDecay(ratio * rise);
#else
    return passed * exp(-weight * column);
#endif
}
#endif
