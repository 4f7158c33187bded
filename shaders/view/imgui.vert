// The panel's triangles: places in the window's own units, from its upper left corner.

uniform vec4 toScreen;      // scale and shift to -1..1

in vec2 place;
in vec2 texel;
in vec4 tint;
out vec2 imagePlace;
out vec4 imageTint;

void main() {
    imagePlace = texel;
    imageTint = tint;
    gl_Position = vec4(place * toScreen.xy + toScreen.zw, 0.0, 1.0);
}
