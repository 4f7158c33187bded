#include "common/definitions.glsl"

struct Camera {
    vec2 size;             // of the picture, pixels
#if PANORAMA
    mat3 basis;            // level towards the middle of the picture, level to the right, and up
#if POLARIZER
    vec2 pass;             // of the field that is seen along a ray: level to the right, and upwards
#endif
#else
    mat3 basis;            // middle of the picture, right and up on the picture plane at distance 1,
                           // the latter two half its extent
#if PIXEL_AREA
    Direction axis;        // of the lens, across that plane: the middle, unless the lens is shifted
#endif
#if POLARIZER
    Direction pass;        // in a filter before the lens: of the field that it lets pass
#endif
#endif
};
