#include "definitions.glsl"

// Distances at which a ray from the eye enters (0 inside) and leaves a box whose corners are
// relative to the eye; entry >= exit where it misses. A ray along a face is inside.
vec2 boxSpan(Direction ray, Position low, Position high) {
    float entry = 0.0;
    float leave = 3.0e38;
    for (int axis = 0; axis < 3; ++axis) {
        if (ray[axis] == 0.0) {
            if (low[axis] > 0.0 || high[axis] < 0.0) leave = -1.0;
        } else {
            float first = low[axis] / ray[axis];
            float second = high[axis] / ray[axis];
            entry = max(entry, min(first, second));
            leave = min(leave, max(first, second));
        }
    }
    return vec2(entry, leave);
}
