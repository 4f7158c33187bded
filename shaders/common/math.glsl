#include "common/definitions.glsl"

// Angle between unit vectors, 0..pi. From chord lengths, then one Newton step on sine and cosine:
// Mesa's acos errs by 1.6e-4 rad and its atan by 3.3e-6, this by 4e-7.
Angle angleBetween(Direction u, Direction v) {
    float chord = length(u - v);
    float antichord = length(u + v);
    Angle estimate = 2.0 * atan(chord, antichord);
    float sine = 0.5 * chord * antichord;
    float cosine = dot(u, v);
    return clamp(estimate + sine * cos(estimate) - cosine * sin(estimate), 0.0, PI);
}

// (1 - exp(-u)) / u, right at u = 0; relative error below 1e-6 (Mesa's exp).
Number meanDecay(Number u) {
    // The series' first left-out term is u^6/5040; above 0.25 the subtraction keeps its digits.
    return abs(u) < 0.25
        ? 1.0 - u * (0.5 - u * (1.0 / 6.0 - u * (1.0 / 24.0 - u * (1.0 / 120.0 - u / 720.0))))
        : (1.0 - exp(-u)) / u;
}

// Texture coordinate of a value 0..1 whose ends lie on the centres of the outermost texels.
Number texelCentred(Number value, float size) {
    return (0.5 + clamp(value, 0.0, 1.0) * (size - 1.0)) / size;
}

// (1 - exp(-u)) / u by the first five terms of its series: within 1.1e-4 for u up to 0.6, without an
// exponential.
Number meanDecayNearby(Number u) {
    return 1.0 - u * (0.5 - u * (1.0 / 6.0 - u * (1.0 / 24.0 - u / 120.0)));
}
