#include "common/definitions.glsl"
#include "common/camera.glsl"
#include "common/box.glsl"
#include "common/pixel_points.glsl"

// What a pixel that is a mean over its solid angle needs beside the ray through its centre.

#if PIXEL_AREA
// A pixel's extents across the scattering angle: its cosine changes by its sine. Both vanish at the
// poles, where the angle has no direction.
vec2 pixelExtent(Camera camera, Direction towardsLight, Direction ray) {
    Number cosine = dot(towardsLight, ray);
    return cosineRise(camera, towardsLight, ray, cosine)
        * inversesqrt(max(1.0 - cosine * cosine, 1.0e-6));
}

// The same across the folded chord, which grows by cos(theta / 2) per angle up to a right one:
// cos(theta / 2) / sin(theta) is the inverse of the chord, 2 sin(theta / 2), mirrored beyond.
vec2 chordExtent(Camera camera, Direction towardsLight, Direction ray) {
    Number cosine = dot(towardsLight, ray);
    return cosineRise(camera, towardsLight, ray, cosine)
        * inversesqrt(max(2.0 - 2.0 * abs(cosine), 1.0e-6));
}

const Length FARTHEST = 3.0e38;

// Whether the length inside a box is as good as linear over a pixel: all of the pixel's rays miss it,
// or they meet faces at no grazing angles and, as good as all, the same face first and the same last.
bool meetsEvenly(Direction ray, vec3 extent, Position low, Position high) {
    // At a corner of the pixel components differ by half the sum over both sides, at most.
    vec3 reach = 0.71 * extent;
    // Some ray of the pixel may be level with these faces.
    bvec3 level = lessThanEqual(abs(ray), reach);
    vec3 steep = mix(ray, vec3(1.0), level);
    vec3 first = low / steep;
    vec3 second = high / steep;
    vec3 bend = mix(reach / abs(steep), vec3(FARTHEST), level);
    vec3 near = min(first, second);
    vec3 far = max(first, second);
    vec3 nearWide = abs(near) * min(bend, vec3(1.0));
    vec3 farWide = abs(far) * min(bend, vec3(1.0));
    vec3 closest = min(abs(low), abs(high)) / max(abs(ray) + reach, vec3(1.0e-30));
    vec3 between = vec3(lessThanEqual(low, vec3(0.0))) * vec3(greaterThanEqual(high, vec3(0.0)));
    vec3 soonest = mix(near - nearWide, mix(closest, vec3(-FARTHEST), between), level);
    vec3 latestEntry = mix(near + nearWide, mix(vec3(FARTHEST), vec3(-FARTHEST), between), level);
    vec3 earliestExit = mix(far - farWide, closest, level);
    vec3 latest = mix(far + farWide, vec3(FARTHEST), level);
    Number entry = max(max(soonest.x, soonest.y), max(soonest.z, 0.0));
    Number exit = min(min(latest.x, latest.y), latest.z);
    if (entry > exit) return true;
    // Faces that may be the first, or the last, one met by some ray of the pixel.
    vec3 firsts = vec3(greaterThan(latestEntry, vec3(entry)));
    vec3 lasts = vec3(lessThan(earliestExit, vec3(exit)));
    // Where two such faces meet, the length has a kink: its mean misses by up to a sixth of this.
    Length kink = (dot(firsts, vec3(1.0)) > 1.0 ? dot(firsts, nearWide) : 0.0)
        + (dot(lasts, vec3(1.0)) > 1.0 ? dot(lasts, farWide) : 0.0);
    vec3 entries = mix(vec3(0.0), latestEntry, greaterThan(firsts, vec3(0.5)));
    vec3 exits = mix(vec3(FARTHEST), earliestExit, greaterThan(lasts, vec3(0.5)));
    Length least = min(min(exits.x, exits.y), exits.z)
        - max(max(entries.x, entries.y), max(entries.z, 0.0));
    return kink < MOST_KINK * least && all(lessThan((firsts + lasts) * bend, vec3(MOST_BEND)));
}

// How a box lies in a pixel: the ray through the middle of what of it is seen, what of that ray is
// inside, the mean length inside over the pixel as a share of that, and the extents of what is seen
// as shares of the pixel's.
struct PixelSpan {
    Direction ray;
    vec2 span;
    Number share;
    vec2 extents;
};

// Points over the pixel at a box's edges: a lattice of thirteen, mirrored at both axes.
const int EDGE_POINTS = 52;

vec2 edgePoint(int k) {
    vec2 away = 0.5 * latticePoint(k >> 2, EDGE_POINTS / 4, 5) + 0.25;
    return away * vec2((k & 1) == 0 ? 1.0 : -1.0, (k & 2) == 0 ? 1.0 : -1.0);
}

// A length of rain, as much of it as shows through itself.
Length seenLength(Length along, Number extinction) {
#if EXTINCTION
    // Towards the eye, and about as much towards the light.
    Number depth = 2.0 * extinction * along;
    // By its series where a difference of like numbers would lose its digits.
    return along * (depth < 0.01 ? 1.0 - 0.5 * depth : (1.0 - exp(-depth)) / depth);
#else
    return along;
#endif
}

// At a box's edges the mean place in the pixel, weighted by the length inside, has a ray of its own:
// the places inside form a convex region, so that this is one of them. Extents are those of a box of
// the same variance. `span`: of the ray through the pixel's centre. `extinction`: of the rain, 1/m,
// whose far parts are dimmed by its near ones.
PixelSpan pixelSpan(Camera camera, vec2 pixel, Direction ray, vec2 span, Position low, Position high,
                    Number extinction) {
    // No branch: Mesa's CPU driver runs through one that no pixel takes, but ends a loop at once.
    int points = meetsEvenly(ray, rayExtent(camera, ray), low, high) ? 0 : EDGE_POINTS;
    PixelRays rays = pixelRays(camera, pixel);
    Length total = 0.0;
    vec2 place = vec2(0.0);
    vec2 squares = vec2(0.0);
    vec2 ends = vec2(0.0);
    for (int k = 0; k < points; ++k) {
        vec2 at = evenPlace(rays, edgePoint(k));
        vec3 inverse = 1.0 / rayAt(rays, at);
        vec3 first = low * inverse;
        vec3 second = high * inverse;
        vec3 near = min(first, second);
        vec3 far = max(first, second);
        vec2 within = rays.toPlane * vec2(max(max(near.x, near.y), max(near.z, 0.0)),
                                     min(min(far.x, far.y), far.z));
        Length chord = seenLength(max(within.y - within.x, 0.0), extinction);
        total += chord;
        place += chord * at;
        squares += chord * at * at;
        ends += chord * within;
    }
    PixelSpan seen = PixelSpan(ray, span, 1.0, vec2(1.0));
    if (total > 0.0) {
        place /= total;
        seen.ray = rayThrough(camera, pixel + place);
        seen.span = ends / total;
        Length mean = seenLength(seen.span.y - seen.span.x, extinction);
        seen.share = total / (float(EDGE_POINTS) * max(mean, 1.0e-30));
        seen.extents = sqrt(12.0 * max(squares / total - place * place, 0.0));
    }
    return seen;
}

#if LAMP_COUNT
const int LAMP_GENERATOR = 5;

// How many rays of a pixel a lamp's light is averaged over. The angle at the lamp sweeps along a ray,
// which leaves fringes where it enters and leaves the rain alone: LAMP_WIDE where pixels are wider than
// these. Otherwise the light has nothing finer than a pixel but at the edges of the rain, and in the few
// pixels about the lamp, where it grows as the inverse of the distance.
int lampPoints(Camera camera, Direction ray, Position low, Position high, Position lamp) {
    bool near = length(cross(lamp, ray)) < NEAR_LAMP * pixelWidth(camera) * dot(lamp, ray);
    return !LAMP_WIDE && !near && meetsEvenly(ray, rayExtent(camera, ray), low, high) ? 1 : LAMP_POINTS;
}

// The k-th of so many rays.
Direction lampPointRay(Camera camera, vec2 pixel, int k, int points) {
    if (points == 1) return pixelRay(camera, pixel);
    vec2 at = latticePoint(k, LAMP_POINTS, LAMP_GENERATOR);
    return rayThrough(camera, pixel + evenPlace(pixelRays(camera, pixel), at));
}
#endif

// A box as a pixel sees it: at its edges some of the pixel's rays are inside and some are not.
struct SoftBox {
    vec2 span;             // distances between which some ray is inside
    vec3 extent;           // of the pixel's rays; 0 where its centre stands for all of it
};

SoftBox softBox(Camera camera, Direction ray, Position low, Position high) {
    vec3 extent = rayExtent(camera, ray);
    if (meetsEvenly(ray, extent, low, high)) return SoftBox(boxSpan(ray, low, high), vec3(0.0));
    vec2 span = vec2(0.0, FARTHEST);
    for (int axis = 0; axis < 3; ++axis) {
        vec2 rays = ray[axis] + vec2(-0.5, 0.5) * extent[axis];
        bool within = low[axis] <= 0.0 && high[axis] >= 0.0;
        bool turns = rays.x < 0.0 && rays.y > 0.0;
        // Towards the box, where the eye is beside it.
        Number side = high[axis] < 0.0 ? rays.x : rays.y;
        Number face = high[axis] < 0.0 ? high[axis] : low[axis];
        if (!within) {
            span.x = max(span.x, side * face > 0.0 ? face / side : FARTHEST);
            Number least = high[axis] < 0.0 ? rays.y : rays.x;
            Number back = high[axis] < 0.0 ? low[axis] : high[axis];
            if (least * back > 0.0) span.y = min(span.y, back / least);
        } else if (!turns) {
            Number least = rays.x >= 0.0 ? rays.x : rays.y;
            span.y = min(span.y, (rays.x >= 0.0 ? high[axis] : low[axis])
                / (abs(least) < 1.0e-30 ? 1.0e-30 : least));
        }
    }
    return SoftBox(span, extent);
}

// Share of the pixel's rays that are inside at a distance, whose place there is `at`.
Number inside(SoftBox box, Position at, Length distance, Position low, Position high) {
    if (box.extent.x <= 0.0) return 1.0;
    vec3 reach = 0.5 * distance * box.extent;
    vec3 share = (min(at + reach, high) - max(at - reach, low)) / max(2.0 * reach, vec3(1.0e-6));
    // Where rays do not differ along an axis, all are where their middle is.
    vec3 alike = vec3(greaterThanEqual(at, low)) * vec3(lessThanEqual(at, high));
    share = mix(clamp(share, 0.0, 1.0), alike, lessThan(reach, vec3(5.0e-7)));
    return share.x * share.y * share.z;
}
#endif
