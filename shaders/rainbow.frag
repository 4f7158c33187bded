#include "camera.glsl"
#include "march.glsl"
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
#if ONE_RADIUS
uniform float oneRadius;            // m
#endif

// March
uniform vec3 cellsPerMetre;
uniform float airPerMetre;
uniform int fixedSteps;
uniform ivec2 stepRange;            // this pass draws steps first..last-1; passes add up

// Light
uniform vec3 sunDirection[SUN_COUNT];    // towards the sun
uniform vec2 sunShape[SUN_COUNT];        // altitude and angular radius of the disc
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
#if AIR
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

void main() {
    Direction ray = cameraRay(2.0 * gl_FragCoord.xy / frameSize - 1.0, cameraBasis);
    vec2 span = boxSpan(ray, boxLow, boxHigh);
    Tristimulus sum = vec3(0.0);
    SunView suns[SUN_COUNT];
    bool dark = true;
    for (int s = 0; s < SUN_COUNT; ++s) {
        suns[s] = viewSun(sunDirection[s], ray, sunShape[s].x, sunShape[s].y, bowEdge);
        dark = dark && suns[s].firstBow > suns[s].lastBow;
    }
    if (span.x < span.y && !dark) {
        int count = stepCount(span.y - span.x, ray, cellsPerMetre, airPerMetre, fixedSteps);
        Length stepLength = (span.y - span.x) / float(count);
        int first = stepRange.x;
        int last = min(count, stepRange.y);
#if ONE_RADIUS && AIR
        Sections sections[SUN_COUNT];
        for (int s = 0; s < SUN_COUNT; ++s) {
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
    radiance = vec4(xyzToRgb(sum), 1.0);
}
