#include "common/camera.glsl"
#include "common/box.glsl"
#include "rain/droplets.glsl"
#include "air/atmosphere.glsl"
#include "rain/march.glsl"
#include "common/polarizer.glsl"
#include "rain/extinction.glsl"
#include "light/sunlight.glsl"
#include "light/lamplight.glsl"
#include "common/colour.glsl"

// One pixel of a frame: linear Rec. 709 radiance in cd/m^2 along the ray through its centre.

// Camera
uniform vec2 frameSize;
uniform mat3 cameraBasis;
uniform float eyeHeight;
#if POLARIZER
uniform vec3 polarizerPass;         // direction in the filter whose field it lets pass
#endif

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
#if EXTINCTION
#if GRID
uniform sampler3D rainToLights;
#else
uniform float uniformExtinction;    // 1/m
#endif
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
uniform sampler2D spectral;
#if TABLE
#if SUN_COUNT
uniform sampler2DArray sectionTable;
uniform vec3 sectionAngles;              // texels per rad, per factor e near poles, width
uniform vec2 sectionPlaces;              // place of the first texel, 0..1 per place
uniform vec3 sectionRadii;               // logarithm of the first, rows per factor e, scale
uniform int sunLayer[SUN_COUNT];         // first layer of each sun's disc
#endif
#if LAMP_COUNT
uniform sampler2DArray lampTable;        // without a disc, with running integrals
uniform vec3 lampAngles;
uniform vec2 lampPlaces;
uniform vec3 lampRadii;
#endif
#define SUN_TEXTURES sectionTable, axisOf(sectionAngles, sectionPlaces), radiiOf(sectionRadii)
#define LAMP_TEXTURES lampTable, axisOf(lampAngles, lampPlaces), radiiOf(lampRadii)
AngleAxis axisOf(vec3 angles, vec2 places) {
    return AngleAxis(angles.x, angles.y, angles.z, places.x, places.y);
}
RadiusAxis radiiOf(vec3 radii) {
    return RadiusAxis(radii.x, radii.y, radii.z);
}
#else
uniform float bowEdge[BOW_COUNT];        // scattering angle beyond which a bow is dark
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
#define SUN_TEXTURES airyNearTable, airyFringeTable, airyPoleTable
#define LAMP_TEXTURES SUN_TEXTURES
#endif
#if AIR && SUN_COUNT
uniform sampler2D columnTable;
#endif

out vec4 radiance;

Droplets dropletsAt(vec3 place) {
#if GRID
    Droplets drops = sampleDroplets(dropletMoments, place);
#if ONE_RADIUS
    drops.radius = oneRadius;       // the very radius that its table row was made for
#endif
    return drops;
#elif EXTINCTION
    return Droplets(uniformDensity, oneRadius, uniformExtinction);
#else
    return Droplets(uniformDensity, oneRadius);
#endif
}

#if EXTINCTION
// Optical depth of the rain from a place along the ray towards a light, which is `most` away.
Number rainTowards(Direction ray, Length distance, int light, Direction towards, Length most) {
    Length path = min(pathOut(towards, cornerFrom(boxLow, ray, distance),
                              cornerFrom(boxHigh, ray, distance)), most);
#if GRID
    return depthTowards(rainToLights, (distance * ray - boxLow) / (boxHigh - boxLow), light,
                        float(SUN_COUNT + LAMP_COUNT), path);
#else
    return uniformExtinction * path;
#endif
}
#endif

Number shareAcross(Direction towardsLight, Direction ray) {
#if POLARIZER
    return perpendicularShare(towardsLight, ray, polarizerPass);
#else
    return 0.5;
#endif
}

#if SUN_COUNT
SunView viewSun(int s, Direction ray) {
    SunView view;
    // Light travels along -sunDirection and on to the eye along -ray.
    view.theta = angleBetween(sunDirection[s], ray);
    view.altitude = sunShape[s].x;
    view.perpendicular = shareAcross(sunDirection[s], ray);
#if TABLE
    view.place = anglePlace(axisOf(sectionAngles, sectionPlaces), view.theta);
    view.layer = sunLayer[s];
#else
    view.disc = sunShape[s].y;
    view.perDisc = 1.0 / max(view.disc, 1.0e-9);
    findBows(view, bowEdge);
#endif
    return view;
}

#if EXTINCTION
Number rainToSun(Direction ray, Length distance, int s) {
    return rainTowards(ray, distance, s, sunDirection[s], 3.0e38);
}
#endif

// Equation 2 by the midpoint rule in distance.
Tristimulus sunlight(Direction ray, vec2 span) {
    SunView suns[SUN_COUNT];
    bool dark = true;
    for (int s = 0; s < SUN_COUNT; ++s) {
        suns[s] = viewSun(s, ray);
        dark = dark && isDark(suns[s]);
    }
    Tristimulus sum = vec3(0.0);
    if (!dark) {
        int count = stepCount(span.y - span.x, ray, cellsPerMetre, airPerMetre, fixedSteps);
        Length stepLength = (span.y - span.x) / float(count);
        int first = stepRange.x;
        int last = min(count, stepRange.y);
#if ONE_RADIUS && ATTENUATION
        Sections found[SUN_COUNT];
        for (int s = 0; s < SUN_COUNT; ++s) {
            if (isDark(suns[s])) continue;
            found[s] = crossSections(spectral, SUN_TEXTURES, suns[s], oneRadius);
        }
#elif ONE_RADIUS
        ColumnDensity passed = 0.0;
#endif
#if EXTINCTION
        // Depths at the ends of a step: towards the eye, summed up, and towards each sun.
        Number toEye = 0.0;
        Number toSun[SUN_COUNT];
        for (int i = 0; i < first; ++i) {
            Position at = (span.x + (float(i) + 0.5) * stepLength) * ray;
            toEye += stepLength * dropletsAt((at - boxLow) / (boxHigh - boxLow)).extinction;
        }
        for (int s = 0; s < SUN_COUNT; ++s) {
            toSun[s] = rainToSun(ray, span.x + float(first) * stepLength, s);
        }
#endif
        for (int i = first; i < last; ++i) {
            Length distance = span.x + (float(i) + 0.5) * stepLength;
            Position at = distance * ray;
            Droplets drops = dropletsAt((at - boxLow) / (boxHigh - boxLow));
#if EXTINCTION
            Number nearer = toEye;
            toEye += stepLength * drops.extinction;
#else
            if (drops.density <= 0.0) continue;
#endif
#if ONE_RADIUS && !ATTENUATION
            passed += drops.density * stepLength;
#else
            for (int s = 0; s < SUN_COUNT; ++s) {
                if (isDark(suns[s])) continue;
                Column column = 0.0;
#if AIR
                column = sunColumn(columnTable, eyeHeight + at.z, suns[s].altitude)
                    + segmentColumn(eyeHeight, ray.z, distance);
#endif
                Number depth = 0.0;
                Number rise = 0.0;
                Number reach = drops.density * stepLength;
#if EXTINCTION
                Number before = nearer + toSun[s];
                toSun[s] = rainToSun(ray, distance + 0.5 * stepLength, s);
                Number behind = toEye + toSun[s];
                if (drops.density <= 0.0) continue;
                depth = min(before, behind);
                rise = abs(behind - before);
#endif
#if ONE_RADIUS
                Tristimulus light = attenuatedLight(spectral, s, found[s], column, depth, rise);
#else
                Tristimulus light = scatteredLight(spectral, SUN_TEXTURES, s, suns[s], drops.radius,
                                                   column, depth, rise);
#endif
                sum += reach * light;
            }
#endif
        }
#if ONE_RADIUS && !ATTENUATION
        for (int s = 0; s < SUN_COUNT; ++s) {
            if (isDark(suns[s])) continue;
            sum += passed * scatteredLight(spectral, SUN_TEXTURES, s, suns[s], oneRadius, 0.0, 0.0,
                                           0.0);
        }
#endif
    }
    return sum;
}
#endif

#if LAMP_COUNT
#if EXTINCTION
Number rainToLamp(Direction ray, Length distance, int light) {
    Position towards = lampSphere[light].xyz - distance * ray;
    Length away = max(length(towards), NEAREST_M);
    return rainTowards(ray, distance, SUN_COUNT + light, towards / away, away);
}
#endif

// Equation 2 by the midpoint rule in the angle at the lamp.
Tristimulus lamplight(Direction ray, vec2 span, int light) {
    LampRay lamp = lampRay(lampSphere[light].xyz, ray, lampSphere[light].w);
    LampSpan stretches = lampSpan(lamp, span);
    bool pierced = stretches.pierced;
    int count = pierced ? 2 * ((lampSteps + 1) / 2) : lampSteps;
    int halfway = count / 2;
    Number perpendicular = shareAcross(lampSphere[light].xyz, ray);
    Tristimulus sum = vec3(0.0);
#if EXTINCTION
    Length reached = span.x;
    Number toEye = 0.0;
    for (int i = 0; i < min(count, stepRange.y); ++i) {
#else
    for (int i = stepRange.x; i < min(count, stepRange.y); ++i) {
#endif
        Stretch stretch = pierced && i >= halfway ? stretches.behind : stretches.before;
        Number part = 1.0 / float(pierced ? halfway : count);
        Number share = (float(pierced && i >= halfway ? i - halfway : i)) * part;
        Length place = placeAt(stretch, lamp, share + 0.5 * part);
        vec2 ends = vec2(placeAt(stretch, lamp, share), placeAt(stretch, lamp, share + part));
        Position at = (lamp.foot + place) * ray;
        Droplets drops = dropletsAt((at - boxLow) / (boxHigh - boxLow));
        Number reach = drops.density * stretch.light * part;
        Number depth = 0.0;
        Number rise = 0.0;
#if EXTINCTION
        // Steps in angle may be long in distance: several samples on the way.
        Number nearer = toEye;
        Length far = lamp.foot + ends.y;
        for (int k = 0; k < LAMP_DEPTH_SAMPLES; ++k) {
            Length along = (float(k) + 0.5) / float(LAMP_DEPTH_SAMPLES);
            Position between = mix(reached, far, along) * ray;
            toEye += (far - reached) / float(LAMP_DEPTH_SAMPLES)
                * dropletsAt((between - boxLow) / (boxHigh - boxLow)).extinction;
        }
        reached = far;
        if (i < stepRange.x) continue;
#endif
        if (drops.density <= 0.0 || stretch.light <= 0.0) continue;
        vec2 theta = vec2(lampTheta(lamp, ends.x), lampTheta(lamp, ends.y));
        Angle disc = lampDisc(lamp, place);
        Column column = 0.0;
#if AIR
        Length distance = max(length(vec2(lamp.side, place)), lamp.radius);
        Number slope = (at.z - lampSphere[light].z) / distance;
        column = segmentColumn(eyeHeight + lampSphere[light].z, slope, distance)
            + segmentColumn(eyeHeight, ray.z, lamp.foot + place);
#endif
#if EXTINCTION
        Number start = nearer + rainToLamp(ray, lamp.foot + ends.x, light);
        Number end = toEye + rainToLamp(ray, far, light);
        depth = min(start, end);
        rise = abs(end - start);
#endif
#if TABLE
        ivec2 lit = ivec2(0);
#else
        ivec2 lit = litBows(theta, disc, bowEdge);
        if (lit.x > lit.y) continue;
#endif
        sum += reach * lampLight(spectral, LAMP_TEXTURES, light, theta, disc, drops.radius, column,
                                 depth, rise, lit, perpendicular);
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
