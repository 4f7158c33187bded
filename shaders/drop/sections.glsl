#include "common/definitions.glsl"
#include "common/math.glsl"

// Cross-sections from a table made for the scene (rtbow/tables/layout.py): one layer per wavelength
// and disc, rows of radius, columns of scattering angle; divided by the radius squared.

// How places along the angles follow the angle: evenly, and denser towards both poles.
struct AngleAxis {
    Number linear;         // texels per rad
    Number pole;           // texels per factor e of the distance from a pole
    Angle width;           // from which that distance counts
    Number start;          // place of the first texel, before scaling
    Number perPlace;       // 0..1 per place
};

Number arsinh(Number x) {
    return log(x + sqrt(x * x + 1.0));
}

Number anglePlace(AngleAxis axis, Angle theta) {
    Number place = axis.linear * theta
        + axis.pole * (arsinh(theta / axis.width) - arsinh((PI - theta) / axis.width));
    return (place - axis.start) * axis.perPlace;
}

struct RadiusAxis {
    Number first;          // logarithm of the first row's radius
    Number perFold;        // rows per factor e
    Number scale;          // of the stored values
};

// What a look-up needs of a radius: its row, 0..1 along the texture, and its square.
vec2 sectionRadius(RadiusAxis axis, float rows, Length radius) {
    Number row = rows > 1.0 ? (log(radius) - axis.first) * axis.perFold / (rows - 1.0) : 0.0;
    return vec2(texelCentred(row, rows), radius * radius * axis.scale);
}

// Both components with a polariser (their share: perpendicular), else their mean.
CrossSection sectionAt(sampler2DArray sections, Number place, vec2 radius, int layer,
                       Number perpendicular) {
    vec2 size = vec2(textureSize(sections, 0).xy);
    vec3 at = vec3(texelCentred(place, size.x), radius.x, float(layer));
#if POLARIZER
    vec2 components = textureLod(sections, at, 0.0).rg;
    return radius.y * 0.5 * mix(components.g, components.r, perpendicular);
#else
    return radius.y * textureLod(sections, at, 0.0).r;
#endif
}

#if LAMP_COUNT
// Mean over a range of angles, from the running integral; a range narrower than a texel from the
// value itself. The last channels hold the integrals.
CrossSection sectionMean(sampler2DArray sections, AngleAxis axis, vec2 theta, vec2 radius, int layer,
                         Number perpendicular) {
    vec2 size = vec2(textureSize(sections, 0).xy);
    Angle span = abs(theta.y - theta.x);
    vec2 place = vec2(anglePlace(axis, theta.x), anglePlace(axis, theta.y));
    if (abs(place.y - place.x) * size.x < 1.0) {
        return sectionAt(sections, 0.5 * (place.x + place.y), radius, layer, perpendicular);
    }
    vec4 from = textureLod(sections, vec3(texelCentred(place.x, size.x), radius.x, layer), 0.0);
    vec4 to = textureLod(sections, vec3(texelCentred(place.y, size.x), radius.x, layer), 0.0);
    vec4 mean = (to - from) / (theta.y - theta.x);
#if POLARIZER
    return radius.y * 0.5 * mix(mean.a, mean.b, perpendicular);
#else
    return radius.y * mean.g;
#endif
}
#endif
