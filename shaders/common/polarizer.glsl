#include "common/definitions.glsl"

#if POLARIZER
// Share of the perpendicular component that a filter before the lens lets pass, from the plane that
// the light and the ray span; what is left is the parallel component's. `pass`: the direction, in
// the filter, of the field that it lets pass.
Number perpendicularShare(Direction towardsLight, Direction ray, Direction pass) {
    vec3 normal = cross(towardsLight, ray);
    // The filter passes the field along its own direction, as far as that is across the ray.
    vec3 field = pass - dot(pass, ray) * ray;
    Number along = dot(normal, field);
    // On the line through the light there is no plane, and the mean over all of them is one half:
    // within seconds of arc, so that what is left of a plane is not rounding.
    Number whole = dot(normal, normal) * dot(field, field);
    Number blur = NO_PLANE * dot(towardsLight, towardsLight) * dot(field, field);
    return 0.5 + (along * along - 0.5 * whole) / max(whole + blur, 1.0e-30);
}
#endif
