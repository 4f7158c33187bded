#include "common/box.glsl"
#include "common/camera.glsl"
#include "common/colour.glsl"
#include "common/footprint.glsl"
#include "light/sun_march.glsl"
#include "light/lamp_march.glsl"

// One pixel of a frame: linear Rec. 709 radiance in cd/m^2 along the ray through its centre. The
// main of spectral/airy.frag and spectral/table.frag, which differ in the theory before it.

uniform Camera camera;
uniform Air air;
uniform Volume volume;
uniform March march;
#if HAZE
uniform Haze haze;
#endif
uniform ivec2 stepRange;            // this pass draws steps first..last-1; passes add up
uniform sampler2D spectral;         // per-wavelength numbers of bows, lights and rain
#if SUN_COUNT
uniform Sun suns[SUN_COUNT];
uniform Theory sunTheory;
#endif
#if LAMP_COUNT
uniform Lamp lamps[LAMP_COUNT];
uniform int lampSteps;
uniform Theory lampTheory;          // without a disc, with running integrals
#endif

out vec4 radiance;

void main() {
    Direction ray = pixelRay(camera, gl_FragCoord.xy);
    vec2 span = boxSpan(ray, volume.low, volume.high);
    Tristimulus sum = vec3(0.0);
#if PIXEL_AREA
#if EXTINCTION && !GRID
    Number extinction = volume.extinction;
#else
    const Number extinction = 0.0;
#endif
    PixelSpan seen =
        pixelSpan(camera, gl_FragCoord.xy, ray, span, volume.low, volume.high, extinction);
    SoftBox box = SoftBox(span, vec3(0.0));
#if GRID
    // Drops differ along the ray: it is marched with the share of the pixel that is inside.
    box = softBox(camera, ray, volume.low, volume.high);
    seen.share = 1.0;
    seen.span = box.span;
#else
    ray = seen.ray;
#endif
    if (seen.span.x < seen.span.y) {
#if SUN_COUNT
        sum += seen.share * sunlight(camera, ray, seen.span, volume, march, stepRange, air, suns,
                                     spectral, sunTheory,
#if HAZE
                                     haze,
#endif
                                     seen, box);
#endif
    }
#if LAMP_COUNT
    for (int light = 0; light < LAMP_COUNT; ++light) {
        int points = lampPoints(camera, ray, volume.low, volume.high, lamps[light].centre);
        for (int k = 0; k < points; ++k) {
            Direction one = lampPointRay(camera, gl_FragCoord.xy, k, points);
            vec2 within = boxSpan(one, volume.low, volume.high);
            if (within.x >= within.y) continue;
            sum += lamplight(camera, one, within, volume, lampSteps, stepRange, air, lamps[light],
                             light, spectral, lampTheory) / float(points);
        }
    }
#endif
#else
    if (span.x < span.y) {
#if SUN_COUNT
        sum += sunlight(camera, ray, span, volume, march, stepRange, air, suns, spectral, sunTheory
#if HAZE
                        , haze
#endif
                        );
#endif
#if LAMP_COUNT
        for (int light = 0; light < LAMP_COUNT; ++light) {
            sum += lamplight(camera, ray, span, volume, lampSteps, stepRange, air, lamps[light],
                             light, spectral, lampTheory);
        }
#endif
    }
#endif
    radiance = vec4(xyzToRgb(sum), 1.0);
}
