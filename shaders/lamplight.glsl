#include "definitions.glsl"
#include "math.glsl"
#include "bows.glsl"

// A lamp near by, marched in the angle at the lamp: with D the distance of the lamp from the ray's
// line, dt / d^2 = dtheta / D, so equal steps in angle bring equal light and the pole 1/d^2 is gone.
// The running integral of the cross-section makes a step exact however many fringes it spans.

#if LAMP_COUNT
struct LampRay {
    Length side;           // distance D of the lamp from the ray's line
    Length foot;           // where along the ray it is nearest
    Length radius;         // of the lamp itself
};

LampRay lampRay(Position lamp, Direction ray, Length radius) {
    Length foot = dot(lamp, ray);
    // From the cross product: no large squares are subtracted.
    return LampRay(max(length(cross(lamp, ray)), NEAREST_M), foot, radius);
}

// A stretch of the ray, from and to counted from the foot.
struct Stretch {
    Length from;
    Length to;
    Angle turn;            // angle it spans at the lamp
    Number light;          // integral of dt / d^2 over it, 1/m
};

Stretch stretchBetween(LampRay lamp, Length from, Length to) {
    Number sine = lamp.side * (to - from);
    Number cosine = lamp.side * lamp.side + from * to;
    Angle turn = to > from ? atan(sine, cosine) : 0.0;
    // turn / side, kept when both vanish.
    Number light = cosine > 0.0 && sine < 1.0e-3 * cosine ? (to - from) / cosine
                                                         : turn / lamp.side;
    return Stretch(from, to, turn, max(light, 0.0));
}

// The place that lies a share of the stretch's angle behind its start: by the sine rule, without
// the tangent of an angle near pi/2.
Length placeAt(Stretch stretch, LampRay lamp, Number share) {
    Number first = 1.0 - share;
    Number second = share;
    if (stretch.turn > 1.0e-3) {
        first = sin(first * stretch.turn);
        second = sin(second * stretch.turn);
    }
    first /= length(vec2(lamp.side, stretch.from));
    second /= length(vec2(lamp.side, stretch.to));
    return (first * stretch.from + second * stretch.to) / max(first + second, 1.0e-37);
}

// Scattering angle there: light runs from the lamp to the drop, then along -ray to the eye.
Angle lampTheta(LampRay lamp, Length place) {
    Angle estimate = atan(lamp.side, -place);
    // One Newton step, as in angleBetween.
    float d = length(vec2(lamp.side, place));
    float error = lamp.side / d * cos(estimate) + place / d * sin(estimate);
    return clamp(estimate + error, 0.0, PI);
}

// Mean cross-section over a step between two scattering angles.
CrossSection meanSection(sampler2D near, sampler2D fringe, Bow bow, Number side, vec2 powers,
                         vec2 theta, Angle disc) {
    Number scale = bow.scale * powers.x;
    Number from = scale * side * (theta.x - bow.angle);
    Number to = scale * side * (theta.y - bow.angle);
    Number span = to - from;
    Number wide = scale * disc;
    Number mean = abs(span) > 0.1
        ? (airyRunning(near, fringe, to, wide) - airyRunning(near, fringe, from, wide)) / span
        : airyMean(near, fringe, near, 0.5 * (from + to), wide, 1.0e9);
    return bow.strength * powers.y * mean;
}

// One step's light over all wavelengths, per drop density and per integral of dt / d^2.
Tristimulus lampLight(sampler2D spectral, sampler2D near, sampler2D fringe, int light,
                      vec2 theta, Angle disc, Length radius, Column column, Angle edge[BOW_COUNT]) {
    int firstBow = BOW_COUNT;
    int lastBow = -1;
    for (int b = 0; b < BOW_COUNT; ++b) {
        Angle bright = BOW_SIDE[b] > 0.0 ? theta.y : theta.x;
        if (BOW_SIDE[b] * (bright - edge[b]) + disc > 0.0) {
            firstBow = min(firstBow, b);
            lastBow = b;
        }
    }
    Tristimulus sum = vec3(0.0);
    if (firstBow > lastBow) return sum;
    vec2 powers = radiusPowers(radius);
    for (int w = 0; w < WAVELENGTH_COUNT; ++w) {
        vec4 weight = texelFetch(spectral, ivec2(w, BOW_COUNT + SUN_COUNT + light), 0);
        CrossSection value = 0.0;
        int b = firstBow;
        do {
            value += meanSection(near, fringe, bowAt(spectral, w, b), BOW_SIDE[b], powers, theta,
                                 disc);
        } while (++b <= lastBow);
#if AIR
        value *= exp(-weight.a * column);
#endif
        sum += value * weight.rgb;
    }
    return sum;
}
#endif
