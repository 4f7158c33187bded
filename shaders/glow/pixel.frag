#include "glow/along.glsl"

// One pixel of the rain's own glow, added to a frame of what drops scatter once.

uniform Camera camera;
uniform Glow glow;
uniform Volume volume;

out vec4 radiance;

void main() {
    radiance = vec4(glowAlong(glow, volume, pixelRay(camera, gl_FragCoord.xy)), 1.0);
}
