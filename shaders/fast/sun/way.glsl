#include "common/definitions.glsl"
#include "rain/march.glsl"
#include "fast/air.glsl"

// The part of a ray's way through the rain that a sun lights, and the pieces that it is marched in.

struct Way {
    Piece pieces[PIECES];
    Length lit;
#if PIECES > 1
    vec2 dark;             // where the ray is in the Earth's shadow
#endif
};

// `span`: where the ray is inside the rain.
Way wayAlong(Direction ray, vec2 span, March march, Columns air) {
    Way way;
    way.lit = max(span.y - span.x, 0.0);
#if PIECES > 1
    way.dark = shadowSpan(air.shadow, ray);
    vec2 dark = clamp(way.dark, span.x, max(span.x, span.y));
    way.lit -= dark.y - dark.x;
    way.pieces[0] = pieceOf(span.x, dark.x, ray, march);
    way.pieces[2] = pieceOf(dark.y, span.y, ray, march);
#if EXTINCTION
    // Light from behind passes the rain in the shadow.
    way.pieces[1] = pieceOf(dark.x, dark.y, ray, march);
#else
    way.pieces[1] = Piece(dark.x, 0.0, 0);
#endif
#elif DIRECT
    way.pieces[0] = Piece(span.x, way.lit / float(DIRECT), DIRECT);
#else
    way.pieces[0] = pieceOf(span.x, span.y, ray, march);
#endif
    return way;
}

// The same, of which nothing is to be marched.
Way unmarched(Way way) {
    for (int p = 0; p < PIECES; ++p) way.pieces[p].count = 0;
    return way;
}
