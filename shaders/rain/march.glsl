#include "common/definitions.glsl"

// Samples along a span: as many as the finest of the grid, the air and the user ask for.
int stepCount(Length span, Direction ray, vec3 cellsPerMetre, Number airPerMetre, int fixedSteps) {
    if (fixedSteps > 0) return fixedSteps;
    vec3 rate = abs(ray) * cellsPerMetre;
    Number most = max(max(rate.x, rate.y), max(rate.z, airPerMetre));
    return int(clamp(ceil(span * most), float(LEAST_STEPS), float(MAX_STEPS)));
}
