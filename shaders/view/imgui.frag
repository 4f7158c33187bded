// The panel's triangles: letters, boxes and small pictures, in the display's own values.

uniform sampler2D image;

in vec2 imagePlace;
in vec4 imageTint;
out vec4 shown;

void main() {
    shown = imageTint * texture(image, imagePlace);
}
