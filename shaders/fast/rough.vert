// The blocks of a picture that are flagged, two triangles each, without buffers.

uniform sampler2D flags;            // one texel for each block
uniform vec2 pictureSize;           // pixels
uniform float blockSize;            // pixels between nodes

void main() {
    int block = gl_VertexID / 6;
    int columns = textureSize(flags, 0).x;
    ivec2 at = ivec2(block % columns, block / columns);
    int corner = gl_VertexID % 6;
    bool right = corner == 1 || corner == 2 || corner == 4;
    bool top = corner == 2 || corner == 4 || corner == 5;
    vec2 place = vec2(at + ivec2(right, top)) * blockSize;
    // Others are nowhere: all their corners lie outside, in one place.
    bool rough = texelFetch(flags, at, 0).r > 0.5;
    gl_Position = vec4(rough ? 2.0 * place / pictureSize - 1.0 : vec2(2.0), 0.0, 1.0);
}
