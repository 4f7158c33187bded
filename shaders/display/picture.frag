// A frame of radiance as the window shows it: exposure, gamut, sRGB curve and dither, as
// rtbow/frames/display.py writes pictures; or its luminance in false colours.

#include "display/tone.glsl"

uniform sampler2D frame;            // cd/m², first row on top
uniform vec4 viewRect;              // of the view in the window: left, bottom, width, height
uniform float perWhite;             // 1 over the luminance that is shown as white
uniform vec3 luminanceWeights;
uniform bool falseColour;
uniform sampler2D colourMap;        // of the false colours
uniform vec2 logRange;              // log10 of luminance at its ends

out vec4 shown;

void main() {
    vec2 place = (gl_FragCoord.xy - viewRect.xy) / viewRect.zw;
    vec3 rgb = texture(frame, vec2(place.x, 1.0 - place.y)).rgb;
    if (falseColour) {
        float luminance = dot(rgb, luminanceWeights);
        float level = luminance > 0.0
            ? (log(luminance) / log(10.0) - logRange.x) / (logRange.y - logRange.x) : 0.0;
        shown = vec4(texture(colourMap, vec2(clamp(level, 0.0, 1.0), 0.5)).rgb, 1.0);
        return;
    }
    // Rows count from above, as in files.
    vec2 pixel = vec2(gl_FragCoord.x - viewRect.x, viewRect.y + viewRect.w - gl_FragCoord.y) - 0.5;
    shown = vec4(floor(255.0 * srgb(inGamut(perWhite * rgb, luminanceWeights)) + dither(pixel)) / 255.0, 1.0);
}
