#include "common/definitions.glsl"
#include "common/math.glsl"
#include "fast/air.glsl"
#include "fast/volume.glsl"
#include "fast/colours.glsl"
#include "light/lamp_ray.glsl"

// Light of one lamp along a ray, marched in the angle at the lamp with colours already summed over
// wavelengths: their running integral over the angle makes a step exact however many fringes it spans.

// Rows of the running integral averaged over discs, by the ratio of the lamp's radius and the
// distance at which a ray passes its centre.
struct DiscRows {
    Number first;          // logarithm of the second row's ratio; the first is a point's
    Number perFold;        // rows per factor e
};

// All that a march under a lamp reads.
struct LampScene {
    Lamp lamp;
    ColourTable table;
    sampler2D running;     // running integrals of the table's colours over the angle
#if LAMP_DISC && !SEVERAL_RADII
    DiscRows discs;
#endif
};

// The colours' running integral at a place along the tables, averaged over the lamp's disc.
#if LAMP_DISC && !SEVERAL_RADII
// The disc's sine is the lamp's radius over its distance, which is D / sin(theta): along one ray the
// disc is a function of the angle and of one ratio, radius / D, for which the table has rows.
Tristimulus runningRow(sampler2D running, Number texel, Number row, int component) {
    vec2 size = vec2(textureSize(running, 0));
    vec2 at = vec2(clamp(texel, 0.0, size.x - 1.0), float(component * DISC_ROWS) + row) + 0.5;
    return textureLod(running, at / size, 0.0).rgb;
}

Tristimulus runningAt(LampScene scene, Number texel, Number row, Number perpendicular, Angle disc,
                      Number slope) {
    Number at = clamp(row, 0.0, float(DISC_ROWS - 1));
#if POLARIZER
    return 0.5 * mix(runningRow(scene.running, texel, at, 1), runningRow(scene.running, texel, at, 0),
                     perpendicular);
#else
    return runningRow(scene.running, texel, at, 0);
#endif
}
#elif LAMP_DISC
// Gauss's rule for the disc's chords, with five nodes.
Tristimulus runningAt(LampScene scene, Number texel, Number row, Number perpendicular, Angle disc,
                      Number slope) {
    Number wide = disc * slope * scene.table.perChord;
    Tristimulus sum = 1.0 / 3.0 * colourOf(scene.running, texel, row, perpendicular);
    for (int side = -1; side <= 1; side += 2) {
        Number away = float(side) * wide;
        sum += 0.25 * colourOf(scene.running, texel + 0.5 * away, row, perpendicular)
            + 1.0 / 12.0 * colourOf(scene.running, texel + 0.8660254 * away, row, perpendicular);
    }
    return sum;
}
#else
Tristimulus runningAt(LampScene scene, Number texel, Number row, Number perpendicular, Angle disc,
                      Number slope) {
    return colourOf(scene.running, texel, row, perpendicular);
}
#endif

// Mean colour between two places along a ray, `turn` apart as seen from the lamp.
Tristimulus meanColour(LampScene scene, LampRay lamp, Length from, Length to, Length middle, Angle turn, Number row,
                       Number perpendicular) {
    vec2 texels = (vec2(foldedChordAt(lamp.side, from), foldedChordAt(lamp.side, to))
                   - scene.table.first) * scene.table.perChord;
    Number slope = chordSlopeAt(lamp.side, middle);
    Angle disc = 0.0;
#if LAMP_DISC && SEVERAL_RADII
    disc = lampDisc(lamp, middle);
#elif LAMP_DISC
    row = (log(lamp.radius / lamp.side) - scene.discs.first) * scene.discs.perFold + 1.0;
#endif
    // A range of less than a few texels is too narrow for a difference in float32, and is widened.
    if (texels.y - texels.x < LEAST_TEXELS) {
        Number last = float(textureSize(scene.running, 0).x - 1);
        Number centre = clamp(0.5 * (texels.x + texels.y), 0.5 * LEAST_TEXELS,
                              last - 0.5 * LEAST_TEXELS);
        texels = centre + vec2(-0.5, 0.5) * LEAST_TEXELS;
        turn = LEAST_TEXELS / (scene.table.perChord * slope);
    }
    return (runningAt(scene, texels.y, row, perpendicular, disc, slope)
            - runningAt(scene, texels.x, row, perpendicular, disc, slope)) / turn;
}

#if EXTINCTION
Number rainToLamp(Volume volume, Direction ray, Length distance, Lamp lamp) {
    Position towards = lamp.centre - distance * ray;
    Length away = max(length(towards), NEAREST_M);
    return rainTowards(volume, ray, distance, towards / away, away);
}
#endif

#if AIR
Column lampColumn(Columns air, Lamp lamp, LampRay passing, Direction ray, Length place) {
    Length distance = max(length(vec2(passing.side, place)), max(passing.radius, NEAREST_M));
    Number slope = ((passing.foot + place) * ray.z - lamp.centre.z) / distance;
    return min(segmentColumn(air.eyeHeight + lamp.centre.z, slope, distance)
               + segmentColumn(air.eyeHeight, ray.z, passing.foot + place), DARK) - air.middle;
}
#endif

#if EVEN
// Even drops need few steps, cut in halves as angles at the lamp: their bisector divides the ray in
// the ratio of the distances.
Tristimulus marchLamp(Direction ray, vec2 span, int steps, LampScene scene, Volume volume,
                      Columns air, RadiusRows rows, Number perpendicular) {
    LampRay passing = lampRay(scene.lamp.centre, ray, scene.lamp.radius);
    LampSpan stretches = lampSpan(passing, span);
    Tristimulus sum = vec3(0.0);
    Stretch stretch = stretches.before;
    bool again = stretches.pierced;
    do {
        Length ends[EVEN_STEPS + 1];
        ends[0] = stretch.from;
        ends[EVEN_STEPS] = stretch.to;
        for (int width = EVEN_STEPS; width > 1; width /= 2) {
            for (int i = 0; i < EVEN_STEPS; i += width) {
                ends[i + width / 2] = bisector(passing, ends[i], ends[i + width]);
            }
        }
        Number part = 1.0 / float(EVEN_STEPS);
        Tristimulus light = vec3(0.0);
        for (int i = 0; i < EVEN_STEPS; ++i) {
            Length middle = bisector(passing, ends[i], ends[i + 1]);
            Tristimulus colour = meanColour(scene, passing, ends[i], ends[i + 1], middle, stretch.turn * part,
                                            0.0, perpendicular);
#if AIR
            Number texel = texelOf(scene.table, foldedChordAt(passing.side, middle));
            Column column = lampColumn(air, scene.lamp, passing, ray, middle);
            colour *= exp(-air.grey * column)
                * fallOff(scene.table.values, texel, clamp(column, -air.reach, air.reach), 0.0);
#endif
            light += colour;
        }
        if (stretch.light > 0.0) sum += volume.density * stretch.light * part * light;
        stretch = stretches.behind;
        again = !again;
    } while (!again);
    return sum;
}
#else
Tristimulus marchLamp(Direction ray, vec2 span, int steps, LampScene scene, Volume volume,
                      Columns air, RadiusRows rows, Number perpendicular) {
#if EXTINCTION && !GRID
    span = seenSpan(span, volume.extinction);
#endif
    LampRay passing = lampRay(scene.lamp.centre, ray, scene.lamp.radius);
    LampSpan stretches = lampSpan(passing, span);
    int halfway = stretches.pierced ? (steps + 1) / 2 : steps;
    int count = stretches.pierced ? 2 * halfway : steps;
    Number part = 1.0 / float(max(halfway, 1));
    Tristimulus sum = vec3(0.0);
#if EXTINCTION
    RainDepth rain = rainDepth(0.0, rainToLamp(volume, ray, span.x, scene.lamp));
#endif
    Length from = stretches.before.from;
    for (int i = 0; i < count; ++i) {
        bool second = i >= halfway;
        Stretch stretch = second ? stretches.behind : stretches.before;
        Number share = float(second ? i - halfway : i) * part;
        if (i == halfway) from = stretch.from;
        Length place = placeAt(stretch, passing, share + 0.5 * part);
        Length to = placeAt(stretch, passing, share + part);
        Position at = (passing.foot + place) * ray;
        Droplets drops = dropletsAt(volume, at);
        Number reach = drops.density * stretch.light * part;
        Number depth = 0.0;
        Column column = 0.0;
        Number row = 0.0;
#if SEVERAL_RADII
        Number logRadius = log(max(drops.radius, 1.0e-7)) - rows.middle;
        reach *= exp(RADIUS_POWER * logRadius);
        row = (logRadius - rows.first) * rows.perFold;
#endif
#if AIR
        column = lampColumn(air, scene.lamp, passing, ray, place);
        reach *= exp(-air.grey * column);
#endif
#if EXTINCTION
        advance(rain, (to - from) * drops.extinction,
                rainToLamp(volume, ray, passing.foot + to, scene.lamp));
        depth = 0.5 * (rain.before + rain.behind);
        reach *= rainLeft(rain);
#endif
        if (stretch.light > 0.0) {
            Number texel = texelOf(scene.table, foldedChordAt(passing.side, place));
#if AIR
            column = clamp(column, -air.reach, air.reach);
#endif
            sum += reach * fallOff(scene.table.values, texel, column, depth)
                * meanColour(scene, passing, from, to, place, stretch.turn * part, row, perpendicular);
        }
        from = to;
    }
    return sum;
}
#endif
