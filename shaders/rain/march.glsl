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

// A piece of a ray, marched by steps of one length.
struct Piece {
    Length start;
    Length stepLength;
    int count;
};

Piece pieceOf(Length start, Length end, Direction ray, March march) {
    int count = start < end ? stepCount(end - start, ray, march) : 0;
    return Piece(start, (end - start) / float(max(count, 1)), count);
}

// Places at which a march is cut, from its start to its end, ascending. Light jumps there, so that no
// step may lie across.
struct Cuts {
    Length at[PIECES + 1];
};

Cuts uncut(vec2 span) {
    Cuts cuts;
    cuts.at[0] = span.x;
    for (int p = 1; p <= PIECES; ++p) cuts.at[p] = span.y;
    return cuts;
}

// Cuts a march at a distance, which counts as its start or end where it lies beyond.
void cut(inout Cuts cuts, Length distance) {
    Length rest = clamp(distance, cuts.at[0], cuts.at[PIECES]);
    for (int p = 1; p < PIECES; ++p) {
        Length least = min(cuts.at[p], rest);
        rest = max(cuts.at[p], rest);
        cuts.at[p] = least;
    }
}
