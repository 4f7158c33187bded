#include "projection/picture.glsl"

// A panorama: columns even in azimuth, rows in altitude, over all directions. Beyond its edges the same
// formulas go on, over the poles and around, as nodes of method `fast` there need them.

#if PANORAMA
// Azimuth to the right of the middle, and altitude, of a place in pixels, whose centres lie at halves.
vec2 panoramaAngles(vec2 size, vec2 pixel) {
    return vec2(2.0 * PI, PI) * (pixel / size - 0.5);
}

Direction panoramaRay(vec2 angles, mat3 basis) {
    vec2 cosine = cos(angles);
    vec2 sine = sin(angles);
    return cosine.y * (cosine.x * basis[0] + sine.x * basis[1]) + sine.y * basis[2];
}

Direction rayThrough(Camera camera, vec2 pixel) {
    return panoramaRay(panoramaAngles(camera.size, pixel), camera.basis);
}

#if PIXEL_AREA || POLARIZER
// Unit vectors across a ray: level to the right, and upwards across both. To the zenith and the nadir
// there is no pixel's centre.
Direction levelAcross(Direction ray) {
    return vec3(ray.y, -ray.x, 0.0) / max(length(ray.xy), 1.0e-12);
}

Direction uprightAcross(Direction ray) {
    return cross(levelAcross(ray), ray);
}
#endif

#if POLARIZER
// Direction of the field that is seen along the ray.
Direction passedAlong(Camera camera, Direction ray) {
    return camera.pass.x * levelAcross(ray) + camera.pass.y * uprightAcross(ray);
}
#endif

#if PIXEL_AREA
// Height of a pixel, and width of one at the horizon.
Angle pixelWidth(Camera camera) {
    return PI / camera.size.y;
}

// A pixel narrows towards the pole. Over its height h, at t above its centre, it is as wide as
// cos(altitude + t), about cos(altitude) (1 - t tan(altitude)), so that the middle of its solid angle
// lies h^2 / 12 tan(altitude) nearer to the horizon. This holds up to the triangle at the pole, where
// the tangent is 2 / h.
Direction pixelRay(Camera camera, vec2 pixel) {
    vec2 angles = panoramaAngles(camera.size, pixel);
    Angle high = pixelWidth(camera);
    angles.y -= high * high / 12.0 * tan(angles.y);
    return panoramaRay(angles, camera.basis);
}

// Extents of the pixel that has a ray, across and upwards: of boxes with the variances of its solid
// angle. Across, that is the mean of cos(altitude + t)^2; upwards, h^2 / 12 about the pixel's centre, but
// about the middle less by the square of the distance of the two.
vec2 pixelExtents(Camera camera, Direction ray) {
    Angle high = pixelWidth(camera);
    Angle fromPole = (floor(atan(length(ray.xy), abs(ray.z)) / high) + 0.5) * high;
    vec2 level = vec2(sin(fromPole), cos(fromPole));
    Number bent = high * level.y;
    return high * vec2(sqrt(level.x * level.x + 0.25 * bent * bent),
                       sqrt(1.0 - bent * bent / (12.0 * level.x * level.x)));
}

// By how much the cosine of a scattering angle changes from one side of a pixel to the other, along
// both sides.
vec2 cosineRise(Camera camera, Direction towardsLight, Direction ray, Number cosine) {
    return pixelExtents(camera, ray) * vec2(dot(towardsLight, levelAcross(ray)),
                                            dot(towardsLight, uprightAcross(ray)));
}

// By how much each component of a pixel's rays changes from one side to the other: the root of the
// sum of squares over both sides, as a box of the same variance has it.
vec3 rayExtent(Camera camera, Direction ray) {
    vec2 extents = pixelExtents(camera, ray);
    vec3 right = extents.x * levelAcross(ray);
    vec3 up = extents.y * uprightAcross(ray);
    return sqrt(right * right + up * up);
}

// The rays of one pixel.
struct PixelRays {
    mat3 basis;
    vec2 middle;           // angles of its centre
    Angle high;
    Number narrowing;      // towards the pole: tangent of the altitude
    Length toPlane;        // rays are of length 1
};

PixelRays pixelRays(Camera camera, vec2 pixel) {
    vec2 middle = panoramaAngles(camera.size, pixel);
    return PixelRays(camera.basis, middle, pixelWidth(camera), tan(middle.y), 1.0);
}

// A ray of it. at: -0.5..0.5 from left to right and bottom to top.
Direction rayAt(PixelRays rays, vec2 at) {
    return panoramaRay(rays.middle + rays.high * at, rays.basis);
}

// Where in the pixel as much of its solid angle lies to the left and below as of the square at `at`: t
// above the centre with t - tan(altitude) t^2 / 2 as large as that of the square's share.
vec2 evenPlace(PixelRays rays, vec2 at) {
    Number narrowing = rays.narrowing * rays.high;
    Number share = at.y - 0.125 * narrowing;
    return vec2(at.x, 2.0 * share / (1.0 + sqrt(max(1.0 - 2.0 * narrowing * share, 0.0))));
}
#else
// The ray that stands for a pixel, whose centre is given.
Direction pixelRay(Camera camera, vec2 pixel) {
    return rayThrough(camera, pixel);
}
#endif
#endif
