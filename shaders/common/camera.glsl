#include "common/definitions.glsl"

// Direction through a pixel centre. basis: forward, right and up, the latter two scaled by half the
// extent of the picture plane at distance 1; screen: -1..1 from left to right and bottom to top.
Direction cameraRay(vec2 screen, mat3 basis) {
    return normalize(basis[0] + screen.x * basis[1] + screen.y * basis[2]);
}
