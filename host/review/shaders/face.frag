// The face with a picture of its map on it: the shaded texels, or a measured map as it is.
in vec2 uv;
out vec4 radiance;
uniform sampler2D shaded;
void main() { radiance = vec4(texture(shaded, uv).rgb, 1.0); }
