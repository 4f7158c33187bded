#include "common/definitions.glsl"

// A lamp near by, marched in the angle at the lamp: with D the distance of the lamp from the ray's
// line, dt / d^2 = dtheta / D, so equal steps in angle bring equal light and the pole 1/d^2 is gone.
// The running integral of the cross-section makes a step exact however many fringes it spans.

#if LAMP_COUNT
struct Lamp {
    Position centre;
    Length radius;
};

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

// The place that lies a share of the stretch's angle behind its start. Turned from the nearer end:
// no tangent of an angle near pi/2, and a place beside a lamp that the ray all but meets keeps its
// digits, since no long distances are subtracted.
Length placeAt(Stretch stretch, LampRay lamp, Number share) {
    bool fromStart = share <= 0.5;
    Length end = fromStart ? stretch.from : -stretch.to;
    Angle turn = (fromStart ? share : 1.0 - share) * stretch.turn;
    Number sine = turn < 1.0e-3 ? turn : sin(turn);
    Length place = lamp.side * (end * cos(turn) + lamp.side * sine)
        / max(lamp.side * cos(turn) - end * sine, 1.0e-37);
    return fromStart ? place : -place;
}

// The place half-way between two others in the angle at the lamp.
Length bisector(LampRay lamp, Length from, Length to) {
    Length near = length(vec2(lamp.side, from));
    Length far = length(vec2(lamp.side, to));
    return (from * far + to * near) / (near + far);
}

// Angular radius of the lamp seen from a place. Arc sine of a ratio up to 1, from an arc tangent:
// Mesa's asin errs by 4e-4.
Angle lampDisc(LampRay lamp, Length place) {
    Length distance = max(length(vec2(lamp.side, place)), lamp.radius);
    return atan(lamp.radius, sqrt(max(distance * distance - lamp.radius * lamp.radius, 1.0e-12)));
}

// The stretches of a ray between two distances that a lamp lights: no drops are inside the lamp, so
// that a ray through it has two, before and behind.
struct LampSpan {
    Stretch before;        // the only one where `pierced` is false
    Stretch behind;
    bool pierced;
};

LampSpan lampSpan(LampRay lamp, vec2 span) {
    Length chord = sqrt(max(lamp.radius * lamp.radius - lamp.side * lamp.side, 0.0));
    vec2 near = span - lamp.foot;
    Stretch before = stretchBetween(lamp, near.x, min(near.y, -chord));
    Stretch behind = stretchBetween(lamp, max(near.x, chord), near.y);
    bool pierced = chord > 0.0 && before.light > 0.0 && behind.light > 0.0;
    Stretch only = stretchBetween(lamp, near.x, near.y);
    if (chord > 0.0 && !pierced) {
        if (before.light > 0.0) only = before;
        else only = behind;
    }
    if (!pierced) before = only;
    return LampSpan(before, behind, pierced);
}

// Scattering angle there: light runs from the lamp to the drop, then along -ray to the eye.
Angle lampTheta(LampRay lamp, Length place) {
    Angle estimate = atan(lamp.side, -place);
    // One Newton step, as in angleBetween.
    float d = length(vec2(lamp.side, place));
    float error = lamp.side / d * cos(estimate) + place / d * sin(estimate);
    return clamp(estimate + error, 0.0, PI);
}
#endif
