// Distant lights, each with its own shadow map. A white surface that faces light i squarely shows
// the radiance light_colour[i].
const int kMostLights = 24;
uniform int light_count;
uniform vec3 light_direction[kMostLights];
uniform vec3 light_colour[kMostLights];
uniform mat4 shadow_from_rig[kMostLights];
uniform sampler2DArrayShadow shadows;
uniform float shadow_texel_mm;
uniform int shadow_taps;  // 1 where many lights make the shadow soft, 4 where one must do it alone

float lit(int i, vec3 x_mm, vec3 n) {
  float n_l = dot(n, light_direction[i]);
  // The more oblique the light, the further a texel of the shadow map reaches along the surface.
  float lift_mm = shadow_texel_mm * (1.5 + 2.5 * sqrt(max(0.0, 1.0 - n_l * n_l)));
  vec3 s = (shadow_from_rig[i] * vec4(x_mm + n * lift_mm, 1.0)).xyz;
  if (shadow_taps == 1) return texture(shadows, vec4(s.xy, float(i), s.z));
  vec2 texel = 1.0 / vec2(textureSize(shadows, 0).xy);
  float sum = 0.0;
  for (int k = 0; k < 4; ++k) {
    vec2 shift = (vec2(k & 1, k >> 1) - 0.5) * 1.5 * texel;
    sum += texture(shadows, vec4(s.xy + shift, float(i), s.z));
  }
  return 0.25 * sum;
}
