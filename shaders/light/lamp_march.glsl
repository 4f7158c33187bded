#include "common/definitions.glsl"
#include "common/camera.glsl"
#include "air/atmosphere.glsl"
#include "rain/volume.glsl"
#include "light/lamplight.glsl"

// Equation 2 under a lamp: the march along a ray with its wavelengths, by the midpoint rule in the
// angle at the lamp.

#if LAMP_COUNT
#if EXTINCTION
Number rainToLamp(Volume volume, Direction ray, Length distance, int light, Lamp lamp) {
    Position towards = lamp.centre - distance * ray;
    Length away = max(length(towards), NEAREST_M);
    return rainTowards(volume, ray, distance, SUN_COUNT + light, towards / away, away);
}
#endif

// `lampSteps` of the ray, of which this pass draws steps.x..steps.y-1; passes add up.
Tristimulus lamplight(Camera camera, Direction ray, vec2 span, Volume volume, int lampSteps,
                      ivec2 steps, Air air, Lamp lamp, int light, sampler2D spectral,
                      Theory theory) {
#if EXTINCTION
    span = seenSpan(volume, ray, span, lampSteps);
#endif
    LampRay passing = lampRay(lamp.centre, ray, lamp.radius);
    LampSpan stretches = lampSpan(passing, span);
    bool pierced = stretches.pierced;
    int count = pierced ? 2 * ((lampSteps + 1) / 2) : lampSteps;
    int halfway = count / 2;
    Number perpendicular = shareAcross(camera, lamp.centre, ray);
    Tristimulus sum = vec3(0.0);
#if EXTINCTION
    Length reached = span.x;
    Number toEye = 0.0;
    for (int i = 0; i < min(count, steps.y); ++i) {
#else
    for (int i = steps.x; i < min(count, steps.y); ++i) {
#endif
        Stretch stretch = pierced && i >= halfway ? stretches.behind : stretches.before;
        Number part = 1.0 / float(pierced ? halfway : count);
        Number share = (float(pierced && i >= halfway ? i - halfway : i)) * part;
        Length place = placeAt(stretch, passing, share + 0.5 * part);
        vec2 ends = vec2(placeAt(stretch, passing, share), placeAt(stretch, passing, share + part));
        Position at = (passing.foot + place) * ray;
        Droplets drops = dropletsAt(volume, at);
        Number reach = drops.density * stretch.light * part;
        Number depth = 0.0;
        Number rise = 0.0;
#if EXTINCTION
        // Steps in angle may be long in distance: several samples on the way.
        Number nearer = toEye;
        Length far = passing.foot + ends.y;
        for (int k = 0; k < LAMP_DEPTH_SAMPLES; ++k) {
            Length along = (float(k) + 0.5) / float(LAMP_DEPTH_SAMPLES);
            Position between = mix(reached, far, along) * ray;
            toEye += (far - reached) / float(LAMP_DEPTH_SAMPLES)
                * dropletsAt(volume, between).extinction;
        }
        // At the face exactly, since a rounding may be many optical depths.
        Length start = i == 0 ? span.x : passing.foot + ends.x;
        reached = far;
        if (i < steps.x) continue;
#endif
        if (drops.density <= 0.0 || stretch.light <= 0.0) continue;
        vec2 theta = vec2(lampTheta(passing, ends.x), lampTheta(passing, ends.y));
        Angle disc = lampDisc(passing, place);
        Column column = 0.0;
#if AIR
        Length distance = max(length(vec2(passing.side, place)), passing.radius);
        Number slope = (at.z - lamp.centre.z) / distance;
        column = segmentColumn(air.eyeHeight + lamp.centre.z, slope, distance)
            + segmentColumn(air.eyeHeight, ray.z, passing.foot + place);
#endif
#if EXTINCTION
        RainDepth rain = rainOver(
            vec2(nearer, rainToLamp(volume, ray, start, light, lamp)),
            vec2(toEye, rainToLamp(volume, ray, far, light, lamp)));
        depth = leastDepth(rain);
        rise = depthRise(rain);
#endif
        ivec2 lit = litBows(theory, theta, disc);
        if (lit.x > lit.y) continue;
        sum += reach * lampLight(spectral, theory, light, theta, disc, drops.radius, column, depth,
                                 rise, lit, perpendicular);
    }
    return sum;
}
#endif
