#include "common/definitions.glsl"
#include "common/math.glsl"
#include "drop/bows.glsl"
#include "drop/sections.glsl"

// The differential cross-section, whichever way it comes: Airy's bows evaluated here (!TABLE), or a
// table made for the scene from either theory (TABLE). What follows needs the same names for both.

#if TABLE
#define SECTION_PARAMETERS sampler2DArray sections, AngleAxis angles, RadiusAxis radii
#define SECTION_ARGUMENTS sections, angles, radii
#else
#define SECTION_PARAMETERS sampler2D near, sampler2D fringe, sampler2D pole
#define SECTION_ARGUMENTS near, fringe, pole
#endif

// What a look-up needs of a radius.
#if TABLE
vec2 radiusTerms(sampler2DArray sections, RadiusAxis radii, Length radius) {
    return sectionRadius(radii, float(textureSize(sections, 0).y), radius);
}
#define RADIUS_TERMS(radius) radiusTerms(sections, radii, radius)
#else
#define RADIUS_TERMS(radius) radiusPowers(radius)
#endif
