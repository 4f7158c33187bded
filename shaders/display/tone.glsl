// From linear Rec. 709, 1 being white, to what a display shows: rtbow/frames/display.py in float32.

// Towards the grey of equal luminance until every component can be shown.
vec3 inGamut(vec3 rgb, vec3 luminanceWeights) {
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

// Interleaved gradient noise inside (0, 1): J. Jimenez, SIGGRAPH 2014.
float dither(vec2 pixel) {
    return 0.001 + 0.998 * fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715))));
}
