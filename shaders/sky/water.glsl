#include "sky/table.glsl"

// What still water below the horizon mirrors (rtbow/tables/sky/seen.py, Mirror): the sky and the sun,
// behind the air on both ways.

#if WATER
// Distance to the water along a falling ray: the water is a sphere.
Length waterDistance(Sky sky, Direction ray) {
    Length start = EARTH_RADIUS_M + sky.height;
    Length over = sky.height * (start + EARTH_RADIUS_M);
    Length fall = -start * ray.z;
    return over / max(fall + sqrt(max(fall * fall - over, 0.0)), 1.0e-6);
}

// The direction in which a falling ray's mirror at the water goes on.
Direction mirrored(Sky sky, Direction ray) {
    Length distance = waterDistance(sky, ray);
    vec2 lean = ray.xy * (distance / EARTH_RADIUS_M);
    Direction up = vec3(lean, sqrt(1.0 - dot(lean, lean)));
    return ray - 2.0 * dot(ray, up) * up;
}

// Texture coordinates in a block of the mirror's rows.
vec2 mirrorTexel(SkyPlace at, vec2 size, Number block) {
    Number row = block * float(SKY_FALLING) + 0.5 + at.row * float(SKY_FALLING - 1);
    return vec2(texelCentred(at.column, size.x), row / size.y);
}

// Shares of light that rain leaves on its way to the water.
struct Left {
    Tristimulus sky;
    Number sun;
};

// `onward`: the mirrored ray; `disc`: share of the pixel that the mirrored disc of the sun fills.
Tristimulus mirroredLight(Camera camera, Sky sky, SkyPlace at, Direction ray, Direction onward,
                          Number disc, Left left) {
    vec2 size = vec2(textureSize(sky.mirror, 0)), rows = vec2(textureSize(sky.beyondMirror, 0));
    Number column = texelCentred(at.row, rows.x);
    Tristimulus light = vec3(0.0);
#if POLARIZER
    vec3 passed = stokesPassed(camera, sky, ray);
    const int STOKES = 3;
#else
    const vec3 passed = vec3(1.0);
    const int STOKES = 1;
#endif
    for (int s = 0; s < STOKES; ++s) {
        Tristimulus part = textureLod(sky.mirror, mirrorTexel(at, size, float(s)), 0.0).rgb;
        vec2 texel = vec2(column, (float(s) + 0.5) / rows.y);
        part *= left.sky;
        part += left.sun * disc * sky.brightness * textureLod(sky.beyondMirror, texel, 0.0).rgb;
        light += passed[s] * part;
    }
#if HAZE
    vec3 phase = phaseParts(sky, onward);
    for (int part = 0; part < 3; ++part) {
        vec2 texel = mirrorTexel(at, size, float(STOKES + part));
        light += left.sky * phase[part] * textureLod(sky.mirror, texel, 0.0).rgb;
    }
#endif
    return light;
}
#endif
