// A frame of radiance as the window shows it: exposure, gamut, sRGB curve and dither, as
// rtbow/display.py writes pictures; or its luminance in false colours.

uniform sampler2D frame;            // cd/m², first row on top
uniform vec4 viewRect;              // of the view in the window: left, bottom, width, height
uniform float perWhite;             // 1 over the luminance that is shown as white
uniform vec3 luminanceWeights;
uniform bool falseColour;
uniform sampler2D colourMap;        // of the false colours
uniform vec2 logRange;              // log10 of luminance at its ends

out vec4 shown;

// Towards the grey of equal luminance until every component can be shown.
vec3 inGamut(vec3 rgb) {
    float grey = clamp(dot(rgb, luminanceWeights), 0.0, 1.0);
    float least = min(min(rgb.r, rgb.g), rgb.b);
    float greatest = max(max(rgb.r, rgb.g), rgb.b);
    float share = 1.0;
    if (least < 0.0) share = grey / (grey - least);
    if (greatest > 1.0) share = min(share, (1.0 - grey) / (greatest - grey));
    return clamp(grey + share * (rgb - grey), 0.0, 1.0);
}

vec3 srgb(vec3 linear) {
    vec3 curve = 1.055 * pow(max(linear, 0.0031308), vec3(1.0 / 2.4)) - 0.055;
    return mix(12.92 * linear, curve, step(0.0031308, linear));
}

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
    // Interleaved gradient noise: J. Jimenez, SIGGRAPH 2014. Rows count from above, as in files.
    vec2 pixel = vec2(gl_FragCoord.x - viewRect.x, viewRect.y + viewRect.w - gl_FragCoord.y) - 0.5;
    float noise = fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715))));
    vec3 codes = 255.0 * srgb(inGamut(perWhite * rgb)) + 0.001 + 0.998 * noise;
    shown = vec4(floor(codes) / 255.0, 1.0);
}
