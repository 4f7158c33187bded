#include "common/definitions.glsl"

// Distances at which a ray from the eye enters (0 inside) and leaves a box whose corners are
// relative to the eye; entry >= exit where it misses. A ray along a face is inside.
vec2 boxSpan(Direction ray, Position low, Position high) {
    vec3 first = low / ray;
    vec3 second = high / ray;
    vec3 near = min(first, second);
    vec3 far = max(first, second);
    // Along a face or between two, a ray meets neither: all of it is within, or nothing.
    for (int axis = 0; axis < 3; ++axis) {
        bool within = low[axis] <= 0.0 && high[axis] >= 0.0;
        if (abs(ray[axis]) < 1.0e-30) {
            near[axis] = -3.0e38;
            far[axis] = within ? 3.0e38 : -1.0;
        }
    }
    return vec2(max(max(near.x, near.y), max(near.z, 0.0)), min(min(far.x, far.y), far.z));
}
