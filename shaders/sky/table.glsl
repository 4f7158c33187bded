#include "common/definitions.glsl"
#include "common/math.glsl"

// A sky as the eye sees it under one sun (rtbow/tables/sky/seen.py): radiance in linear Rec. 709.

struct Sky {
    sampler2D whole;       // light of the air and the ground along a whole ray, I (Q, U above it)
#if EXTINCTION
    sampler3D layers;      // of the air alone, up to distances that grow as squares, and in all
    Length farthest;       // the last of these distances
#endif
#if HAZE
    sampler2D glare;       // what aerosol makes of the sun's own light, over the parts of its phase
                           // function, above each other
    sampler2D phase;       // these, by the root of the angle from the sun
#if EXTINCTION
    sampler3D glareLayers; // of the glare, as of the air
#endif
#endif
    sampler2D beyond;      // share of its light that passes the air, by altitude above the horizon
    Number brightness;     // of the sun's disc above the air, 1/sr
    Angle horizon;         // its altitude
    vec2 azimuth;          // towards the sun's, unit vector east, north
    Direction towards;     // the sun
    Number disc;           // chord of the disc's radius; 0 where none is seen
#if WATER
    sampler2D mirror;      // what water mirrors of the sky, I (Q, U; with haze three parts of glare)
                           // above each other
    sampler2D beyondMirror; // share of the sun's light, by row below the horizon: I (Q, U)
    Length height;         // of the eye above the water
#endif
};

// A ray's place in the tables: column, and row from the horizon, 0..1 each.
struct SkyPlace {
    Number column;
    Number row;
    bool falls;            // below the horizon
#if HAZE
    vec3 phase;            // the parts of the aerosol's phase function, 1/sr
#endif
};

// Mesa's asin errs by 1e-4 rad, its atan by 3e-6.
Angle altitudeOf(Direction ray) {
    return atan(ray.z, length(ray.xy));
}

#if HAZE
vec3 phaseParts(Sky sky, Direction ray) {
    Number root = sqrt(angleBetween(ray, sky.towards) / PI);
    vec2 size = vec2(textureSize(sky.phase, 0));
    return textureLod(sky.phase, vec2(texelCentred(root, size.x), 0.5), 0.0).rgb;
}
#endif

// `above`: the ray's altitude over the horizon, of which the side is taken as `falls` says.
SkyPlace skyPlace(Sky sky, Direction ray, Angle above, bool falls) {
    vec2 level = vec2(dot(ray.xy, sky.azimuth), sky.azimuth.x * ray.y - sky.azimuth.y * ray.x);
    // At the zenith all columns are alike.
    Angle aside = dot(level, level) > 0.0 ? abs(atan(level.y, level.x)) : 0.0;
    Number share = falls ? -above / (0.5 * PI + sky.horizon) : above / (0.5 * PI - sky.horizon);
    share = clamp(share, 0.0, 1.0);
    SkyPlace at;
    at.column = aside / PI;
    at.row = falls ? pow(share, 1.0 / 3.0) : sqrt(share);
    at.falls = falls;
#if HAZE
    at.phase = phaseParts(sky, ray);
#endif
    return at;
}

// Texture coordinates of a place, in the block of one Stokes component.
vec2 skyTexel(SkyPlace at, vec2 size, Number component) {
    Number rows = float(SKY_RISING + SKY_FALLING);
    Number first = component * rows + (at.falls ? float(SKY_RISING) : 0.0);
    Number last = at.falls ? float(SKY_FALLING - 1) : float(SKY_RISING - 1);
    return vec2(texelCentred(at.column, size.x), (first + 0.5 + at.row * last) / size.y);
}

#if POLARIZER
// Factors of I, Q and U in what a camera's filter lets pass of light along a ray.
vec3 stokesPassed(Camera camera, Sky sky, Direction ray) {
    // Level, away from the sun's azimuth, and across both, towards the zenith.
    Number side = sky.azimuth.x * ray.y - sky.azimuth.y * ray.x;
    vec3 level = vec3(-ray.y, ray.x, 0.0);
    Number size = length(level.xy);
    level = size > 1.0e-6 ? level / size : vec3(-sky.azimuth.y, sky.azimuth.x, 0.0);
    level *= side < 0.0 ? -1.0 : 1.0;
    vec3 upright = side < 0.0 ? cross(level, ray) : cross(ray, level);
    Direction pass = passedAlong(camera, ray);
    vec2 field = vec2(dot(pass, level), dot(pass, upright));
    vec2 squares = field * field / max(dot(field, field), 1.0e-30);
    Number product = field.x * field.y / max(dot(field, field), 1.0e-30);
    return 0.5 * vec3(1.0, squares.x - squares.y, 2.0 * product);
}
#endif

#if HAZE
// Unpolarised light that a camera sees of what it would without a filter.
#if POLARIZER
const Number UNPOLARISED = 0.5;
#else
const Number UNPOLARISED = 1.0;
#endif
#endif

// Light of the air and the ground along a whole ray.
Tristimulus skyWhole(Camera camera, Sky sky, SkyPlace at, Direction ray) {
    vec2 size = vec2(textureSize(sky.whole, 0));
    Tristimulus light = vec3(0.0);
#if POLARIZER
    vec3 passed = stokesPassed(camera, sky, ray);
    for (int s = 0; s < 3; ++s) {
        light += passed[s] * textureLod(sky.whole, skyTexel(at, size, float(s)), 0.0).rgb;
    }
#else
    light = textureLod(sky.whole, skyTexel(at, size, 0.0), 0.0).rgb;
#endif
#if HAZE
    size = vec2(textureSize(sky.glare, 0));
    for (int part = 0; part < 3; ++part) {
        vec2 texel = skyTexel(at, size, float(part));
        light += UNPOLARISED * at.phase[part] * textureLod(sky.glare, texel, 0.0).rgb;
    }
#endif
    return light;
}

#if EXTINCTION
// Light of the air up to a distance.
Tristimulus skyUpTo(Camera camera, Sky sky, SkyPlace at, Direction ray, Length distance) {
    vec3 size = vec3(textureSize(sky.layers, 0));
    Number layer = texelCentred(sqrt(distance / sky.farthest), size.z);
    Tristimulus light = vec3(0.0);
#if POLARIZER
    vec3 passed = stokesPassed(camera, sky, ray);
    for (int s = 0; s < 3; ++s) {
        vec2 texel = skyTexel(at, size.xy, float(s));
        light += passed[s] * textureLod(sky.layers, vec3(texel, layer), 0.0).rgb;
    }
#else
    light = textureLod(sky.layers, vec3(skyTexel(at, size.xy, 0.0), layer), 0.0).rgb;
#endif
#if HAZE
    vec2 glareSize = vec2(textureSize(sky.glareLayers, 0).xy);
    for (int part = 0; part < 3; ++part) {
        vec3 texel = vec3(skyTexel(at, glareSize, float(part)), layer);
        light += UNPOLARISED * at.phase[part] * textureLod(sky.glareLayers, texel, 0.0).rgb;
    }
#endif
    return light;
}
#endif

// Radiance of the sun's disc behind the air.
Tristimulus sunBeyond(Sky sky, SkyPlace at) {
    vec2 texel = vec2(texelCentred(at.row, float(SKY_RISING)), 0.5);
    return sky.brightness * textureLod(sky.beyond, texel, 0.0).rgb;
}
