// The least that a picture from a table can cost: one bilinear fetch per pixel. `rtbow bench` sets
// every method's time against it.

uniform vec2 frameSize;
uniform sampler2D floorTable;

out vec4 radiance;

void main() {
    radiance = texture(floorTable, gl_FragCoord.xy / frameSize);
}
