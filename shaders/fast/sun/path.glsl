#include "common/definitions.glsl"
#include "common/footprint.glsl"
#include "air/haze.glsl"
#include "fast/air.glsl"
#include "fast/volume.glsl"
#include "fast/colours.glsl"
#include "fast/sun/way.glsl"

// What a ray through the rain gathers for one sun, before any colour: its drops' weight and the mean
// circumstances of their light. The light itself follows from a table at the pixel's own angle. Needs
// a Gathered before it: fast/sun/row_weights.glsl for nodes, fast/sun/row_light.glsl for pixels.

struct SunPath {
    Number weight;         // per metre: density, times radius^(7/3) where radii differ, attenuated
    Column column;         // mean air column towards sun and eye, above the middle
    Number depth;          // mean depth of the rain
    Number haze;           // mean depth of aerosol at 550 nm, above the middle
};

// Equation 2 without its wavelengths, by the midpoint rule.
SunPath gatherSun(Direction ray, Way way, Direction towardsSun, Volume volume, Columns air,
                  RadiusRows rows, ColourTable table, inout Gathered gathered
#if HAZE
                  , Haze haze, Number hazeMiddle
#endif
#if PIXEL_EDGES
                  , SoftBox box
#endif
                  ) {
    SunPath sums = SunPath(0.0, 0.0, 0.0, 0.0);
#if EXTINCTION
    Length start = way.pieces[0].start;
    RainDepth rain = rainDepth(0.0, rainTowards(volume, ray, start, towardsSun, 3.0e38));
#endif
    for (int p = 0; p < PIECES; ++p) {
        Piece piece = way.pieces[p];
        Length stepLength = piece.stepLength;
        for (int i = 0; i < piece.count; ++i) {
            Length distance = piece.start + (float(i) + 0.5) * stepLength;
            Position at = distance * ray;
            Droplets drops = dropletsAt(volume, at);
            Number reach = drops.density * stepLength;
#if PIXEL_EDGES && GRID
            reach *= inside(box, at, distance, volume.low, volume.high);
#endif
            Number depth = 0.0;
            Column column = 0.0;
#if SEVERAL_RADII
            Number logRadius = log(max(drops.radius, 1.0e-7)) - rows.middle;
            reach *= exp(RADIUS_POWER * logRadius);
#endif
#if AIR
            column = columnAt(air, at, ray, distance);
            reach *= greyLeft(air, column);
#endif
            Number dimmed = 0.0;
#if HAZE
            dimmed = hazeAlong(haze, ray, distance, 0) - hazeMiddle;
            reach *= exp(-dimmed);
#endif
#if EXTINCTION
            advance(rain, stepLength * drops.extinction,
                    rainTowards(volume, ray, distance + 0.5 * stepLength, towardsSun, 3.0e38));
            depth = 0.5 * (rain.before + rain.behind);
            reach *= rainLeft(rain);
#endif
#if PIECES > 1
            if (isInShadow(way.dark, distance)) continue;
#endif
            sums.weight += reach;
            sums.column += reach * column;
            sums.depth += reach * depth;
            sums.haze += reach * dimmed;
#if SEVERAL_RADII
            Number row = (logRadius - rows.first) * rows.perFold;
            gatherRow(gathered, table, reach, clamp(row, 0.0, float(RADIUS_ROWS - 1)));
#endif
        }
    }
    Number whole = 1.0 / max(sums.weight, 1.0e-30);
    return SunPath(sums.weight / way.lit, sums.column * whole, sums.depth * whole,
                   sums.haze * whole);
}
