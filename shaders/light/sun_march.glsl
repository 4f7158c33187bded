#include "common/definitions.glsl"
#include "common/math.glsl"
#include "common/camera.glsl"
#include "air/atmosphere.glsl"
#include "air/haze.glsl"
#include "rain/march.glsl"
#include "rain/volume.glsl"
#include "light/sunlight.glsl"

// Equation 2 under suns: the march along a ray with its wavelengths, by the midpoint rule in distance.
// Where a sun is so low that the edge of the Earth's shadow crosses the rain, each piece of the ray
// between such edges has steps of its own.

#if SUN_COUNT
#if EXTINCTION
Number rainToSun(Volume volume, Direction ray, Length distance, int s, Sun sun) {
    return rainTowards(volume, ray, distance, s, sun.towards, 3.0e38);
}
#endif

#if PIECES > 1
// Where each sun leaves a ray dark.
struct Shadows {
    vec2 spans[SUN_COUNT];
};

Shadows shadowsAlong(Direction ray, Sun suns[SUN_COUNT]) {
    Shadows shadows;
    for (int s = 0; s < SUN_COUNT; ++s) {
        shadows.spans[s] = suns[s].shaded ? shadowSpan(suns[s].shadow, ray) : vec2(NOWHERE);
    }
    return shadows;
}

#endif

#if AIR
// Air column from a sun to a place along a ray and on to the eye.
Column columnBy(Air air, Sun sun, Direction ray, Length distance) {
    Column toEye = segmentColumn(air.eyeHeight, ray.z, distance);
#if PIECES > 1
    if (sun.shaded) {
        return columnOverSphere(air.columns, sun.shadow, air.eyeHeight, ray, distance) + toEye;
    }
#endif
    Position at = distance * ray;
    return sunColumn(air.columns, air.eyeHeight + at.z, sun.altitude) + toEye;
}
#endif

// `steps`: this pass draws steps first..last-1; passes add up.
Tristimulus sunlight(Camera camera, Direction ray, vec2 span, Volume volume, March march,
                     ivec2 steps, Air air, Sun suns[SUN_COUNT], sampler2D spectral,
                     Theory theory
#if HAZE
                     , Haze haze
#endif
#if PIXEL_AREA
                     , PixelSpan seen, SoftBox box
#endif
                     ) {
    SunView views[SUN_COUNT];
    bool dark = true;
    for (int s = 0; s < SUN_COUNT; ++s) {
        // Light travels from the sun and on to the eye along -ray.
#if PIXEL_AREA
        views[s] = sunView(theory, angleBetween(suns[s].towards, seen.ray), suns[s].disc,
                           suns[s].layer, shareAcross(camera, suns[s].towards, seen.ray),
                           seen.extents * pixelExtent(camera, suns[s].towards, seen.ray));
#else
        views[s] = sunView(theory, angleBetween(suns[s].towards, ray), suns[s].disc, suns[s].layer,
                           shareAcross(camera, suns[s].towards, ray));
#endif
        dark = dark && isDark(views[s]);
    }
    Tristimulus sum = vec3(0.0);
    if (dark) return sum;
#if ONE_RADIUS && ATTENUATION
    Sections sections[SUN_COUNT];
    for (int s = 0; s < SUN_COUNT; ++s) {
        if (isDark(views[s])) continue;
        sections[s] = crossSections(spectral, theory, views[s], volume.radius);
    }
#elif ONE_RADIUS
    ColumnDensity passed = 0.0;
#endif
    Cuts cuts = uncut(span);
#if PIECES > 1
    Shadows shadows = shadowsAlong(ray, suns);
    for (int s = 0; s < SUN_COUNT; ++s) {
        cut(cuts, shadows.spans[s].x);
        cut(cuts, shadows.spans[s].y);
    }
#endif
#if EXTINCTION
    Number toEye = 0.0;
    RainDepth rain[SUN_COUNT];
    bool begun = false;
#endif
    int before = 0;        // steps of the pieces before
    for (int p = 0; p < PIECES; ++p) {
        Piece piece = pieceOf(cuts.at[p], cuts.at[p + 1], ray, march);
        Length stepLength = piece.stepLength;
        int first = clamp(steps.x - before, 0, piece.count);
        int last = min(piece.count, steps.y - before);
        before += piece.count;
#if EXTINCTION
        for (int i = 0; i < first; ++i) {
            Position at = (piece.start + (float(i) + 0.5) * stepLength) * ray;
            toEye += stepLength * dropletsAt(volume, at).extinction;
        }
        if (first < last && !begun) {
            begun = true;
            Length start = piece.start + float(first) * stepLength;
            for (int s = 0; s < SUN_COUNT; ++s) {
                rain[s] = rainDepth(toEye, rainToSun(volume, ray, start, s, suns[s]));
            }
        }
#endif
        for (int i = first; i < last; ++i) {
            Length distance = piece.start + (float(i) + 0.5) * stepLength;
            Position at = distance * ray;
            Droplets drops = dropletsAt(volume, at);
#if PIXEL_AREA && GRID
            drops.density *= inside(box, at, distance, volume.low, volume.high);
#endif
#if !EXTINCTION
            if (drops.density <= 0.0) continue;
#endif
#if ONE_RADIUS && !ATTENUATION
            passed += drops.density * stepLength;
#else
            for (int s = 0; s < SUN_COUNT; ++s) {
                if (isDark(views[s])) continue;
                Column column = 0.0;
                Number depth = 0.0;
                Number rise = 0.0;
                Number reach = drops.density * stepLength;
#if EXTINCTION
                advance(rain[s], stepLength * drops.extinction,
                        rainToSun(volume, ray, distance + 0.5 * stepLength, s, suns[s]));
                if (drops.density <= 0.0) continue;
                depth = leastDepth(rain[s]);
                rise = depthRise(rain[s]);
#endif
#if PIECES > 1
                if (isInShadow(shadows.spans[s], distance)) continue;
#endif
#if AIR
                column = columnBy(air, suns[s], ray, distance);
#endif
                Number dimmed = 0.0;
#if HAZE
                dimmed = hazeAlong(haze, ray, distance, s);
#endif
#if ONE_RADIUS
                sum += reach * attenuatedLight(spectral, s, sections[s], column, depth, rise,
                                               dimmed);
#else
                sum += reach * scatteredLight(spectral, theory, s, views[s], drops.radius, column,
                                              depth, rise, dimmed);
#endif
            }
#endif
        }
    }
#if ONE_RADIUS && !ATTENUATION
    for (int s = 0; s < SUN_COUNT; ++s) {
        if (isDark(views[s])) continue;
        sum += passed * scatteredLight(spectral, theory, s, views[s], volume.radius, 0.0, 0.0, 0.0,
                                        0.0);
    }
#endif
    return sum;
}
#endif
