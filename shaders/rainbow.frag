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
uniform vec2 uniformDroplets;       // density [m^-3], radius [m]
#endif

// March
uniform vec3 cellsPerMetre;
uniform float airPerMetre;
uniform int fixedSteps;

// Light
uniform vec3 sunDirection[SUN_COUNT];    // towards the sun
uniform vec2 sunShape[SUN_COUNT];        // altitude and angular radius of the disc
uniform sampler2D spectral;
uniform sampler2D airyNearTable;
#if DISC
uniform sampler2D airyFringeTable;
uniform sampler2D airyPoleTable;
#else
#define airyFringeTable airyNearTable
#define airyPoleTable airyNearTable
#endif
#if AIR
uniform sampler2D columnTable;
#endif

out vec4 radiance;

Droplets dropletsAt(vec3 place) {
#if GRID
    return sampleDroplets(dropletMoments, place);
#else
    return Droplets(uniformDroplets.x, uniformDroplets.y);
#endif
}

void main() {
    Direction ray = cameraRay(2.0 * gl_FragCoord.xy / frameSize - 1.0, cameraBasis);
    vec2 span = boxSpan(ray, boxLow, boxHigh);
    Tristimulus sum = vec3(0.0);
    if (span.x < span.y) {
        int count = stepCount(span.y - span.x, ray, cellsPerMetre, airPerMetre, fixedSteps);
        Length stepLength = (span.y - span.x) / float(count);
        for (int i = 0; i < count; ++i) {
            Length distance = span.x + (float(i) + 0.5) * stepLength;
            Position at = distance * ray;
            Droplets drops = dropletsAt((at - boxLow) / (boxHigh - boxLow));
            if (drops.density <= 0.0) continue;
            for (int s = 0; s < SUN_COUNT; ++s) {
                // Light travels along -sunDirection and on to the eye along -ray.
                SunView sun = SunView(angleBetween(sunDirection[s], ray), sunShape[s].x,
                                      sunShape[s].y);
                Column column = 0.0;
#if AIR
                column = sunColumn(columnTable, eyeHeight + at.z, sun.altitude)
                    + segmentColumn(eyeHeight, ray.z, distance);
#endif
                sum += drops.density * stepLength
                    * scatteredLight(spectral, airyNearTable, airyFringeTable, airyPoleTable,
                                     s, sun, drops.radius, column);
            }
        }
    }
    radiance = vec4(xyzToRgb(sum), 1.0);
}
