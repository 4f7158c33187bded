#include "common/definitions.glsl"

struct March {
    vec3 cellsPerMetre;    // samples that the grid asks for along each axis
    Number airPerMetre;    // that the attenuation by air and rain asks for
    int fixedSteps;        // that the user asks for; 0: as many as the others
};

// Samples along a span: as many as the finest of the grid, the air and the user ask for.
int stepCount(Length span, Direction ray, March march) {
    if (march.fixedSteps > 0) return march.fixedSteps;
    vec3 rate = abs(ray) * march.cellsPerMetre;
    Number most = max(max(rate.x, rate.y), max(rate.z, march.airPerMetre));
    return int(clamp(ceil(span * most), float(LEAST_STEPS), float(MAX_STEPS)));
}
