// Light that arrives at each texel of the face's map, for diffusion over the surface.
in vec2 uv;
out vec4 irradiance;
uniform sampler2D position_mm;
uniform sampler2D normal;
uniform sampler2D inside_px;
void main() {
  if (texture(inside_px, uv).r < -1.0) {
    irradiance = vec4(0.0);
    return;
  }
  vec3 x = texture(position_mm, uv).xyz, n = normalize(texture(normal, uv).xyz);
  vec3 sum = vec3(0.0);
  for (int i = 0; i < light_count; ++i) {
    float n_l = dot(n, light_direction[i]);
    if (n_l > 0.0) sum += light_colour[i] * (n_l * lit(i, x, n));
  }
  irradiance = vec4(sum, 1.0);
}
