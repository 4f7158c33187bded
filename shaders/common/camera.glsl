#include "common/definitions.glsl"
#include "common/polarizer.glsl"

struct Camera {
    vec2 size;             // of the picture, pixels
    mat3 basis;            // middle of the picture, right and up on the picture plane at distance 1,
                           // the latter two half its extent
#if PIXEL_AREA
    Direction axis;        // of the lens, across that plane: the middle, unless the lens is shifted
#endif
#if POLARIZER
    Direction pass;        // in a filter before the lens: of the field that it lets pass
#endif
};

// Direction through a place of the picture; screen: -1..1 from left to right and bottom to top.
Direction cameraRay(vec2 screen, mat3 basis) {
    return normalize(basis[0] + screen.x * basis[1] + screen.y * basis[2]);
}

// Direction through a place in pixels, whose centres lie at halves.
Direction rayThrough(Camera camera, vec2 pixel) {
    return cameraRay(2.0 * pixel / camera.size - 1.0, camera.basis);
}

// Share of the component perpendicular to the scattering plane in what the camera sees of a light.
Number shareAcross(Camera camera, vec3 towardsLight, Direction ray) {
#if POLARIZER
    return perpendicularShare(towardsLight, ray, camera.pass);
#else
    return 0.5;
#endif
}
