#include "projection/picture.glsl"

// A perspective camera: places of its picture are places of a plane at distance 1.

#if !PANORAMA
// Direction through a place of the picture; screen: -1..1 from left to right and bottom to top.
Direction cameraRay(vec2 screen, mat3 basis) {
    return normalize(basis[0] + screen.x * basis[1] + screen.y * basis[2]);
}

// Direction through a place in pixels, whose centres lie at halves.
Direction rayThrough(Camera camera, vec2 pixel) {
    return cameraRay(2.0 * pixel / camera.size - 1.0, camera.basis);
}

// The ray that stands for a pixel, whose centre is given.
Direction pixelRay(Camera camera, vec2 pixel) {
    return rayThrough(camera, pixel);
}

#if POLARIZER
// Direction of the field that the filter lets pass, as far as that is across the ray.
Direction passedAlong(Camera camera, Direction ray) {
    return camera.pass;
}
#endif

#if PIXEL_AREA
// By how much the cosine of a scattering angle changes from one side of a pixel to the other, along
// both sides. Turned by half a pixel along a, the ray r moves by a / 2 less what of that is along r, over
// its length on the picture plane at distance 1, which is the inverse of the cosine from the axis.
vec2 cosineRise(Camera camera, Direction towardsLight, Direction ray, Number cosine) {
    vec2 along = vec2(dot(ray, camera.basis[1]), dot(ray, camera.basis[2]));
    vec2 towards = vec2(dot(towardsLight, camera.basis[1]), dot(towardsLight, camera.basis[2]));
    return 2.0 / camera.size * dot(ray, camera.axis) * (towards - cosine * along);
}

// By how much each component of a pixel's rays changes from one side to the other: the root of the
// sum of squares over both sides, as a box of the same variance has it.
vec3 rayExtent(Camera camera, Direction ray) {
    vec3 right = camera.basis[1] - dot(camera.basis[1], ray) * ray;
    vec3 up = camera.basis[2] - dot(camera.basis[2], ray) * ray;
    vec3 squared = right * right / (camera.size.x * camera.size.x)
        + up * up / (camera.size.y * camera.size.y);
    return 2.0 * dot(ray, camera.axis) * sqrt(squared);
}

// Width of the widest pixel.
Angle pixelWidth(Camera camera) {
    return 2.0 * length(camera.basis[1]) / camera.size.x;
}

// The rays of one pixel, from its centre over its sides.
struct PixelRays {
    vec3 middle;
    vec3 right;
    vec3 up;
    Length toPlane;        // along the middle one: all as good as alike over a pixel
};

PixelRays pixelRays(Camera camera, vec2 pixel) {
    vec2 screen = 2.0 * pixel / camera.size - 1.0;
    vec3 middle = camera.basis[0] + screen.x * camera.basis[1] + screen.y * camera.basis[2];
    return PixelRays(middle, 2.0 / camera.size.x * camera.basis[1],
                     2.0 / camera.size.y * camera.basis[2], length(middle));
}

// A ray of it, which reaches to the picture plane. at: -0.5..0.5 from left to right and bottom to top.
vec3 rayAt(PixelRays rays, vec2 at) {
    return rays.middle + at.x * rays.right + at.y * rays.up;
}

// Where in the pixel as much of its solid angle lies to the left and below as of the square at `at`.
vec2 evenPlace(PixelRays rays, vec2 at) {
    return at;
}
#endif
#endif
