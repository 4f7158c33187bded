#include "common/definitions.glsl"
#include "common/math.glsl"
#include "fast/scene.glsl"
#include "light/lamp_ray.glsl"
#include "fast/colours.glsl"
#include "common/polarizer.glsl"

// Light of one lamp along a ray, marched in the angle at the lamp with colours already summed over
// wavelengths: their running integral over the angle makes a step exact however many fringes it spans.

#if LAMP_COUNT
uniform vec4 lampSphere;        // centre relative to the eye, radius
uniform vec2 chordAxis;         // folded chord of the tables' first texel; texels per unit
#if AIR
uniform float middleAir;        // middle column
#endif
uniform sampler2D colours;
uniform sampler2D runningColours;
#if LAMP_DISC && !SEVERAL_RADII
uniform vec2 discRows;          // logarithm of the second row's ratio; rows per factor e
#endif

// The colours' running integral at a place along the tables, averaged over the lamp's disc.
#if LAMP_DISC && !SEVERAL_RADII
// The disc's sine is the lamp's radius over its distance, which is D / sin(theta): along one ray the
// disc is a function of the angle and of one ratio, radius / D, for which the table has rows.
Tristimulus runningRow(Number texel, Number row, int component) {
    vec2 size = vec2(textureSize(runningColours, 0));
    vec2 at = vec2(clamp(texel, 0.0, size.x - 1.0), float(component * DISC_ROWS) + row) + 0.5;
    return textureLod(runningColours, at / size, 0.0).rgb;
}

Tristimulus runningAt(Number texel, Number row, Number perpendicular, Angle disc, Number slope) {
    Number at = clamp(row, 0.0, float(DISC_ROWS - 1));
#if POLARIZER
    return 0.5 * mix(runningRow(texel, at, 1), runningRow(texel, at, 0), perpendicular);
#else
    return runningRow(texel, at, 0);
#endif
}
#elif LAMP_DISC
// Gauss's rule for the disc's chords, with five nodes.
Tristimulus runningAt(Number texel, Number row, Number perpendicular, Angle disc, Number slope) {
    Number wide = disc * slope * chordAxis.y;
    Tristimulus sum = 1.0 / 3.0 * colourOf(runningColours, texel, row, perpendicular);
    for (int side = -1; side <= 1; side += 2) {
        Number away = float(side) * wide;
        sum += 0.25 * colourOf(runningColours, texel + 0.5 * away, row, perpendicular)
            + 1.0 / 12.0 * colourOf(runningColours, texel + 0.8660254 * away, row, perpendicular);
    }
    return sum;
}
#else
Tristimulus runningAt(Number texel, Number row, Number perpendicular, Angle disc, Number slope) {
    return colourOf(runningColours, texel, row, perpendicular);
}
#endif

// Mean colour between two places along a ray, `turn` apart as seen from the lamp.
Tristimulus meanColour(LampRay lamp, Length from, Length to, Length middle, Angle turn, Number row,
                       Number perpendicular) {
    vec2 texels = (vec2(foldedChordAt(lamp.side, from), foldedChordAt(lamp.side, to))
                   - chordAxis.x) * chordAxis.y;
    Number slope = chordSlopeAt(lamp.side, middle);
    Angle disc = 0.0;
#if LAMP_DISC && SEVERAL_RADII
    disc = lampDisc(lamp, middle);
#elif LAMP_DISC
    row = (log(lamp.radius / lamp.side) - discRows.x) * discRows.y + 1.0;
#endif
    // A range of less than a few texels is too narrow for a difference in float32, and is widened.
    if (texels.y - texels.x < LEAST_TEXELS) {
        Number last = float(textureSize(runningColours, 0).x - 1);
        Number centre = clamp(0.5 * (texels.x + texels.y), 0.5 * LEAST_TEXELS,
                              last - 0.5 * LEAST_TEXELS);
        texels = centre + vec2(-0.5, 0.5) * LEAST_TEXELS;
        turn = LEAST_TEXELS / (chordAxis.y * slope);
    }
    return (runningAt(texels.y, row, perpendicular, disc, slope)
            - runningAt(texels.x, row, perpendicular, disc, slope)) / turn;
}

Number lampShare(Direction ray) {
#if POLARIZER
    return perpendicularShare(lampSphere.xyz, ray, polarizerPass);
#else
    return 0.5;
#endif
}

#if EXTINCTION
Number rainToLamp(Direction ray, Length distance) {
    Position towards = lampSphere.xyz - distance * ray;
    Length away = max(length(towards), NEAREST_M);
    return rainTowards(ray, distance, towards / away, away);
}
#endif

#if AIR
Column lampColumn(LampRay lamp, Direction ray, Length place) {
    Length distance = max(length(vec2(lamp.side, place)), max(lamp.radius, NEAREST_M));
    Number slope = ((lamp.foot + place) * ray.z - lampSphere.z) / distance;
    return min(segmentColumn(eyeHeight + lampSphere.z, slope, distance)
               + segmentColumn(eyeHeight, ray.z, lamp.foot + place), DARK) - middleAir;
}
#endif

#if EVEN
// Even drops need few steps, cut in halves as angles at the lamp: their bisector divides the ray in
// the ratio of the distances.
Tristimulus marchLamp(Direction ray, vec2 span, int steps) {
    LampRay lamp = lampRay(lampSphere.xyz, ray, lampSphere.w);
    LampSpan stretches = lampSpan(lamp, span);
    Number perpendicular = lampShare(ray);
    Tristimulus sum = vec3(0.0);
    Stretch stretch = stretches.before;
    bool again = stretches.pierced;
    do {
        Length ends[EVEN_STEPS + 1];
        ends[0] = stretch.from;
        ends[EVEN_STEPS] = stretch.to;
        for (int width = EVEN_STEPS; width > 1; width /= 2) {
            for (int i = 0; i < EVEN_STEPS; i += width) {
                ends[i + width / 2] = bisector(lamp, ends[i], ends[i + width]);
            }
        }
        Number part = 1.0 / float(EVEN_STEPS);
        Tristimulus light = vec3(0.0);
        for (int i = 0; i < EVEN_STEPS; ++i) {
            Length middle = bisector(lamp, ends[i], ends[i + 1]);
            Tristimulus colour = meanColour(lamp, ends[i], ends[i + 1], middle, stretch.turn * part,
                                            0.0, perpendicular);
#if AIR
            Number texel = (foldedChordAt(lamp.side, middle) - chordAxis.x) * chordAxis.y;
            Column column = lampColumn(lamp, ray, middle);
            colour *= exp(-greyAir * column)
                * fallOff(colours, texel, clamp(column, -columnReach, columnReach), 0.0);
#endif
            light += colour;
        }
        if (stretch.light > 0.0) sum += uniformDensity * stretch.light * part * light;
        stretch = stretches.behind;
        again = !again;
    } while (!again);
    return sum;
}
#else
Tristimulus marchLamp(Direction ray, vec2 span, int steps) {
    LampRay lamp = lampRay(lampSphere.xyz, ray, lampSphere.w);
    LampSpan stretches = lampSpan(lamp, span);
    int halfway = stretches.pierced ? (steps + 1) / 2 : steps;
    int count = stretches.pierced ? 2 * halfway : steps;
    Number perpendicular = lampShare(ray);
    Number part = 1.0 / float(max(halfway, 1));
    Tristimulus sum = vec3(0.0);
#if EXTINCTION
    Number toEye = 0.0;
    Number toLamp = rainToLamp(ray, span.x);
#endif
    Length from = stretches.before.from;
    for (int i = 0; i < count; ++i) {
        bool second = i >= halfway;
        Stretch stretch = second ? stretches.behind : stretches.before;
        Number share = float(second ? i - halfway : i) * part;
        if (i == halfway) from = stretch.from;
        Length place = placeAt(stretch, lamp, share + 0.5 * part);
        Length to = placeAt(stretch, lamp, share + part);
        Position at = (lamp.foot + place) * ray;
        Droplets drops = dropletsAt(at);
        Number reach = drops.density * stretch.light * part;
        Number depth = 0.0;
        Column column = 0.0;
        Number row = 0.0;
#if SEVERAL_RADII
        Number logRadius = log(max(drops.radius, 1.0e-7)) - middleRadius;
        reach *= exp(RADIUS_POWER * logRadius);
        row = (logRadius - radiusRows.x) * radiusRows.y;
#endif
#if AIR
        column = lampColumn(lamp, ray, place);
        reach *= exp(-greyAir * column);
#endif
#if EXTINCTION
        Number before = toEye + toLamp;
        toEye += (to - from) * drops.extinction;
        toLamp = rainToLamp(ray, lamp.foot + to);
        Number behind = toEye + toLamp;
        depth = 0.5 * (before + behind);
        reach *= exp(-min(before, behind)) * meanDecay(abs(behind - before));
#endif
        if (stretch.light > 0.0) {
            Number texel = (foldedChordAt(lamp.side, place) - chordAxis.x) * chordAxis.y;
#if AIR
            column = clamp(column, -columnReach, columnReach);
#endif
            sum += reach * fallOff(colours, texel, column, depth)
                * meanColour(lamp, from, to, place, stretch.turn * part, row, perpendicular);
        }
        from = to;
    }
    return sum;
}
#endif
#endif
