#include "definitions.glsl"

// Distances at which a ray from the eye enters (0 inside) and leaves a box whose corners are
// relative to the eye; entry >= exit where it misses. A ray along a face is inside.
vec2 boxSpan(Direction ray, Position low, Position high) {
    // Along a face or between two, a ray meets neither: far away, or at 0 on the face itself.
    vec3 along = vec3(abs(ray.x) < 1.0e-30 ? 1.0e-30 : ray.x, abs(ray.y) < 1.0e-30 ? 1.0e-30 : ray.y,
                      abs(ray.z) < 1.0e-30 ? 1.0e-30 : ray.z);
    vec3 first = low / along;
    vec3 second = high / along;
    vec3 near = min(first, second);
    vec3 far = max(first, second);
    return vec2(max(max(near.x, near.y), max(near.z, 0.0)), min(min(far.x, far.y), far.z));
}
