// One direction of a Gaussian over the surface (d'Eon et al. 2007): the width is millimetres on the
// skin, so a texel of a slanted cheek counts for more of them.
in vec2 uv;
out vec4 blurred;
uniform sampler2D source;
uniform sampler2D position_mm;
uniform vec2 axis;      // (1, 0) or (0, 1)
uniform float sigma_mm;
const int kTaps = 6;    // on either side, half a sigma apart
void main() {
  vec2 texel = axis / vec2(textureSize(source, 0));
  vec3 here = texture(position_mm, uv).xyz;
  vec3 ahead = texture(position_mm, uv + texel).xyz, behind = texture(position_mm, uv - texel).xyz;
  float spacing_mm = max(0.5 * length(ahead - behind), 1e-3);
  vec2 stride = texel * (0.5 * sigma_mm / spacing_mm);
  vec4 sum = texture(source, uv);
  if (sum.a <= 0.0) {
    blurred = vec4(0.0);
    return;
  }
  for (int k = -kTaps; k <= kTaps; ++k) {
    if (k == 0) continue;
    vec2 at = uv + float(k) * stride;
    // Skin that is far away in space, across a gap in depth, does not share its light.
    float apart = length(texture(position_mm, at).xyz - here) / (0.5 * sigma_mm * abs(float(k)));
    float near = 1.0 - smoothstep(1.5, 4.0, apart);
    sum += texture(source, at) * (exp(-0.125 * float(k * k)) * near);
  }
  blurred = vec4(sum.rgb / sum.a, 1.0);
}
