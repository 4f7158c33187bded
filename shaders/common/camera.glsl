#include "common/definitions.glsl"
#include "common/polarizer.glsl"
#include "projection/panorama.glsl"
#include "projection/perspective.glsl"

// Share of the component perpendicular to the scattering plane in what the camera sees of a light.
Number shareAcross(Camera camera, vec3 towardsLight, Direction ray) {
#if POLARIZER
    return perpendicularShare(towardsLight, ray, passedAlong(camera, ray));
#else
    return 0.5;
#endif
}
