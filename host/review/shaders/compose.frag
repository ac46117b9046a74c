// The face before a dark neutral backdrop, exposed and encoded for the screen.
in vec2 uv;
out vec4 colour;
uniform sampler2D radiance;  // premultiplied by coverage
uniform float exposure;
uniform float vignette;      // 0: flat, for small pictures

// Straight, so that colours are true, up to a shoulder that keeps highlights from burning out.
vec3 shoulder(vec3 x) {
  const float a = 0.6;
  vec3 over = max(x - a, 0.0) / (1.0 - a);
  return min(x, a) + (1.0 - a) * (1.0 - exp(-2.0 * over)) / (1.0 + exp(-2.0 * over));
}

vec3 srgb(vec3 x) {
  return mix(1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, 12.92 * x, lessThanEqual(x, vec3(0.0031308)));
}

// Breaks up the bands of a dark gradient in eight bits.
float dither(vec2 p) { return fract(52.9829189 * fract(dot(p, vec2(0.06711056, 0.00583715)))) - 0.5; }

void main() {
  vec2 from_light = (uv - vec2(0.5, 0.56)) * vec2(1.15, 1.0);
  float glow = exp(-3.5 * dot(from_light, from_light));
  float backdrop = mix(0.0055, 0.034, glow * vignette);
  vec4 face = texture(radiance, uv);
  vec3 linear = backdrop * (1.0 - face.a) + shoulder(face.rgb * exposure);
  // The same step for all channels, then whole steps of a cool tint: a picture of it packs well.
  vec3 tint = vec3(0.0, 1.0, 3.0) + dither(gl_FragCoord.xy);
  colour = vec4(srgb(clamp(linear, 0.0, 1.0)) + tint * (1.0 - face.a) / 255.0, 1.0);
}
