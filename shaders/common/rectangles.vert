// Rectangles over parts of the target, two triangles each, without buffers.

uniform sampler2D rectangles;       // left, bottom, right and top, -1 to 1 across the target

void main() {
    vec4 sides = texelFetch(rectangles, ivec2(gl_VertexID / 6, 0), 0);
    int corner = gl_VertexID % 6;
    bool right = corner == 1 || corner == 2 || corner == 4;
    bool top = corner == 2 || corner == 4 || corner == 5;
    gl_Position = vec4(right ? sides.z : sides.x, top ? sides.w : sides.y, 0.0, 1.0);
}
