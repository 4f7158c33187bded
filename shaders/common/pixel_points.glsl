#include "common/definitions.glsl"

// Places within a pixel from its centre, -0.5 to 0.5: a lattice of `count` points, which has as many
// places along each side. `generator`: odd, without a factor in common with the count.
vec2 latticePoint(int k, int count, int generator) {
    Number index = float(k) + 0.5;
    return vec2(index / float(count), fract(index * (float(generator) / float(count)))) - 0.5;
}

#if PIXEL_POINTS
// The k-th of the angles over a pixel of some extents u and v that stand for equal parts of it, from
// its middle: the angles' distribution is a trapezoid, of slopes v wide about a middle of u - v, which
// holds 1 - v / u of the pixel.
Angle pixelPoint(vec2 extent, int k) {
    vec2 sizes = abs(extent);
    Angle u = max(sizes.x, sizes.y);
    Angle v = min(sizes.x, sizes.y);
    Number part = (float(k) + 0.5) / float(PIXEL_POINTS) - 0.5;
    Number tail = 0.5 - abs(part);
    if (2.0 * tail * u >= v) return part * u;
    return sign(part) * (0.5 * (u + v) - sqrt(2.0 * tail * u * v));
}

// Squared radius of a disc that blurs as much as what these angles leave of the pixel. A disc's
// variance along an axis is a fourth of its squared radius, a box's a twelfth of its squared width.
Number pixelRest(vec2 extent) {
    Number squares = 0.0;
    for (int k = 0; k < PIXEL_POINTS; ++k) {
        Angle away = pixelPoint(extent, k);
        squares += away * away;
    }
    return max(dot(extent, extent) / 3.0 - 4.0 * squares / float(PIXEL_POINTS), 0.0);
}
#endif
