#include "camera.glsl"
#include "box.glsl"
#include "droplets.glsl"
#include "atmosphere.glsl"
#include "march.glsl"
#include "sunlight.glsl"
#include "lamplight.glsl"
#include "colour.glsl"

// One pixel of a frame: linear Rec. 709 radiance in cd/m^2 along the ray through its centre.

// Camera
uniform vec2 frameSize;
uniform mat3 cameraBasis;
uniform float eyeHeight;

// Droplet volume, relative to the eye
uniform vec3 boxLow;
uniform vec3 boxHigh;
#if GRID
uniform sampler3D dropletMoments;
#else
uniform float uniformDensity;       // m^-3
#endif
#if ONE_RADIUS || !GRID
uniform float oneRadius;            // m
#endif

// March
uniform vec3 cellsPerMetre;
uniform float airPerMetre;
uniform int fixedSteps;
uniform ivec2 stepRange;            // this pass draws steps first..last-1; passes add up

// Lights
#if SUN_COUNT
uniform vec3 sunDirection[SUN_COUNT];    // towards the sun
uniform vec2 sunShape[SUN_COUNT];        // altitude and angular radius of the disc
#endif
#if LAMP_COUNT
uniform vec4 lampSphere[LAMP_COUNT];     // centre relative to the eye, radius
uniform int lampSteps;
#endif
uniform float bowEdge[BOW_COUNT];        // scattering angle beyond which a bow is dark
uniform sampler2D spectral;
uniform sampler2D airyNearTable;
#if DISC
uniform sampler2D airyFringeTable;
#else
#define airyFringeTable airyNearTable     // never read
#endif
#if POLE
uniform sampler2D airyPoleTable;
#else
#define airyPoleTable airyNearTable       // never read
#endif
#if AIR && SUN_COUNT
uniform sampler2D columnTable;
#endif

out vec4 radiance;

Droplets dropletsAt(vec3 place) {
#if GRID
    return sampleDroplets(dropletMoments, place);
#else
    return Droplets(uniformDensity, oneRadius);
#endif
}

#if SUN_COUNT
// Equation 2 by the midpoint rule in distance.
Tristimulus sunlight(Direction ray, vec2 span) {
    SunView suns[SUN_COUNT];
    bool dark = true;
    for (int s = 0; s < SUN_COUNT; ++s) {
        suns[s] = viewSun(sunDirection[s], ray, sunShape[s].x, sunShape[s].y, bowEdge);
        dark = dark && suns[s].firstBow > suns[s].lastBow;
    }
    Tristimulus sum = vec3(0.0);
    if (!dark) {
        int count = stepCount(span.y - span.x, ray, cellsPerMetre, airPerMetre, fixedSteps);
        Length stepLength = (span.y - span.x) / float(count);
        int first = stepRange.x;
        int last = min(count, stepRange.y);
#if ONE_RADIUS && AIR
        Sections sections[SUN_COUNT];
        for (int s = 0; s < SUN_COUNT; ++s) {
            if (suns[s].firstBow > suns[s].lastBow) continue;
            sections[s] = crossSections(spectral, airyNearTable, airyFringeTable, airyPoleTable,
                                        suns[s], oneRadius);
        }
#elif ONE_RADIUS
        ColumnDensity passed = 0.0;
#endif
        for (int i = first; i < last; ++i) {
            Length distance = span.x + (float(i) + 0.5) * stepLength;
            Position at = distance * ray;
            Droplets drops = dropletsAt((at - boxLow) / (boxHigh - boxLow));
            if (drops.density <= 0.0) continue;
#if ONE_RADIUS && !AIR
            passed += drops.density * stepLength;
#else
            for (int s = 0; s < SUN_COUNT; ++s) {
                if (suns[s].firstBow > suns[s].lastBow) continue;
                Column column = 0.0;
#if AIR
                column = sunColumn(columnTable, eyeHeight + at.z, suns[s].altitude)
                    + segmentColumn(eyeHeight, ray.z, distance);
#endif
#if ONE_RADIUS
                Tristimulus light = attenuatedLight(spectral, s, sections[s], column);
#else
                Tristimulus light = scatteredLight(spectral, airyNearTable, airyFringeTable,
                                                   airyPoleTable, s, suns[s], drops.radius, column);
#endif
                sum += drops.density * stepLength * light;
            }
#endif
        }
#if ONE_RADIUS && !AIR
        for (int s = 0; s < SUN_COUNT; ++s) {
            if (suns[s].firstBow > suns[s].lastBow) continue;
            sum += passed * scatteredLight(spectral, airyNearTable, airyFringeTable, airyPoleTable,
                                           s, suns[s], oneRadius, 0.0);
        }
#endif
    }
    return sum;
}
#endif

#if LAMP_COUNT
// Equation 2 by the midpoint rule in the angle at the lamp.
Tristimulus lamplight(Direction ray, vec2 span, int light) {
    LampRay lamp = lampRay(lampSphere[light].xyz, ray, lampSphere[light].w);
    // No drops are inside the lamp: a ray through it has two stretches, before and behind.
    Length chord = sqrt(max(lamp.radius * lamp.radius - lamp.side * lamp.side, 0.0));
    vec2 near = span - lamp.foot;
    Stretch before = stretchBetween(lamp, near.x, min(near.y, -chord));
    Stretch behind = stretchBetween(lamp, max(near.x, chord), near.y);
    bool pierced = chord > 0.0 && before.light > 0.0 && behind.light > 0.0;
    Stretch whole = stretchBetween(lamp, near.x, near.y);
    if (chord > 0.0 && !pierced) {
        if (before.light > 0.0) whole = before;
        else whole = behind;
    }
    int count = pierced ? 2 * ((lampSteps + 1) / 2) : lampSteps;
    int halfway = count / 2;
    Tristimulus sum = vec3(0.0);
    for (int i = stepRange.x; i < min(count, stepRange.y); ++i) {
        Stretch stretch = pierced ? (i < halfway ? before : behind) : whole;
        Number part = 1.0 / float(pierced ? halfway : count);
        Number share = (float(pierced && i >= halfway ? i - halfway : i)) * part;
        Length place = placeAt(stretch, lamp, share + 0.5 * part);
        Position at = (lamp.foot + place) * ray;
        Droplets drops = dropletsAt((at - boxLow) / (boxHigh - boxLow));
        if (drops.density <= 0.0 || stretch.light <= 0.0) continue;
        vec2 theta = vec2(lampTheta(lamp, placeAt(stretch, lamp, share)),
                          lampTheta(lamp, placeAt(stretch, lamp, share + part)));
        Length distance = max(length(vec2(lamp.side, place)), lamp.radius);
        // Arc sine of a ratio up to 1, from an arc tangent: Mesa's asin errs by 4e-4.
        Angle disc = atan(lamp.radius,
                          sqrt(max(distance * distance - lamp.radius * lamp.radius, 1.0e-12)));
        Column column = 0.0;
#if AIR
        Number rise = (at.z - lampSphere[light].z) / distance;
        column = segmentColumn(eyeHeight + lampSphere[light].z, rise, distance)
            + segmentColumn(eyeHeight, ray.z, lamp.foot + place);
#endif
        sum += drops.density * stretch.light * part
            * lampLight(spectral, airyNearTable, airyFringeTable, light, theta, disc,
                        drops.radius, column, bowEdge);
    }
    return sum;
}
#endif

void main() {
    Direction ray = cameraRay(2.0 * gl_FragCoord.xy / frameSize - 1.0, cameraBasis);
    vec2 span = boxSpan(ray, boxLow, boxHigh);
    Tristimulus sum = vec3(0.0);
    if (span.x < span.y) {
#if SUN_COUNT
        sum += sunlight(ray, span);
#endif
#if LAMP_COUNT
        for (int light = 0; light < LAMP_COUNT; ++light) sum += lamplight(ray, span, light);
#endif
    }
    radiance = vec4(xyzToRgb(sum), 1.0);
}
