// The four layers, lit: specular (eq. 1), single scattering (eq. 3), shallow, and deep. Shaded texel
// by texel of the map, not pixel by pixel: each texel once, and filtered like any texture after.
in vec2 uv;
uniform sampler2D position_mm;
uniform sampler2D inside_px;
out vec4 radiance;
uniform vec3 eye_mm;
uniform sampler2D normal;
uniform sampler2D single_specular;  // rgb: alpha of eq. 3; a: c of eq. 1
uniform sampler2D shallow_albedo;
uniform sampler2D deep_albedo;
uniform sampler2D deep_ld_mm;
uniform sampler2D diffused0, diffused1, diffused2, diffused3;
uniform sampler2D kernel_weights;  // against l_d, six rows a region: deep r g b, shallow r g b
uniform float largest_ld_mm;
uniform sampler2DArray region_weights;  // four regions a layer
uniform int region_count;
uniform sampler1DArray transmittance;   // rho_dt against the cosine; one layer a region
uniform vec3 g;
uniform vec4 gains;  // specular, single, shallow, deep
const float kPi = 3.14159265;

float rho_dt(int region, float c) {
  float cells = float(textureSize(transmittance, 0).x);
  return texture(transmittance, vec2((c * (cells - 1.0) + 0.5) / cells, float(region))).r;
}

// The two regions that a pixel belongs to most, and the share of the first between them.
ivec2 regions;
float first_share;

void find_regions() {
  vec2 best = vec2(0.0);
  regions = ivec2(0);
  for (int i = 0; i < region_count; ++i) {
    float w = texture(region_weights, vec3(uv, float(i / 4)))[i % 4];
    if (w > best.x) {
      best = vec2(w, best.x);
      regions = ivec2(i, regions.x);
    } else if (w > best.y) {
      best.y = w;
      regions.y = i;
    }
  }
  first_share = best.x / max(best.x + best.y, 1e-4);
}

float rho_dt_here(float c) {
  return mix(rho_dt(regions.y, c), rho_dt(regions.x, c), first_share);
}

float density_here(float n_h) {
  return mix(facet_density(regions.y, n_h), facet_density(regions.x, n_h), first_share);
}

vec3 henyey_greenstein(float c) {
  vec3 x = 1.0 + g * g - 2.0 * g * c;
  return (1.0 - g * g) / (4.0 * kPi * x * sqrt(x));
}

// Shares of the four Gaussians; `ld`: in units of the largest.
vec4 shares_here(int row, float ld) {
  float rows = float(textureSize(kernel_weights, 0).y);
  vec4 first = texture(kernel_weights, vec2(ld, (float(6 * regions.x + row) + 0.5) / rows));
  vec4 second = texture(kernel_weights, vec2(ld, (float(6 * regions.y + row) + 0.5) / rows));
  return mix(second, first, first_share);
}

// Light that has spread beneath the surface before it leaves.
void gather(out vec3 shallow, out vec3 deep, vec3 direct) {
  vec3 ld = texture(deep_ld_mm, uv).rgb / largest_ld_mm;
  vec3 a = texture(diffused0, uv).rgb, b = texture(diffused1, uv).rgb;
  vec3 c = texture(diffused2, uv).rgb, d = texture(diffused3, uv).rgb;
  for (int k = 0; k < 3; ++k) {
    vec4 spread = vec4(a[k], b[k], c[k], d[k]);
    deep[k] = dot(shares_here(k, ld[k]), spread);
    vec4 w = shares_here(3 + k, 0.5);
    shallow[k] = dot(w, spread) + (1.0 - dot(w, vec4(1.0))) * direct[k];
  }
}

void main() {
  if (texture(inside_px, uv).r < -8.0) {  // a rim beyond the outline, for filtering
    radiance = vec4(0.0);
    return;
  }
  vec3 x_mm = texture(position_mm, uv).xyz;
  vec3 v = normalize(eye_mm - x_mm), n = normalize(texture(normal, uv).xyz);
  float n_v = dot(n, v);
  if (n_v < 0.05) {  // a normal that faces away from the eye is turned to the rim
    n = normalize(n + (0.05 - n_v) * v);
    n_v = max(dot(n, v), 0.05);
  }
  vec3 direct = vec3(0.0), single = vec3(0.0), specular = vec3(0.0);
  bool is_lit = gains.x + gains.y + gains.z > 0.0;  // deep light has been gathered before
  find_regions();
  float v_in = sqrt(1.0 - (1.0 - n_v * n_v) / (kIor * kIor));
  for (int i = 0; is_lit && i < light_count; ++i) {
    vec3 l = light_direction[i];
    float n_l = dot(n, l);
    if (n_l <= 0.0) continue;
    vec3 light = light_colour[i] * lit(i, x_mm, n);
    direct += light * n_l;
    if (gains.x > 0.0) {
      vec3 h = normalize(l + v);
      float n_h = dot(n, h), v_h = max(dot(v, h), 1e-3);
      specular += light * (kPi * density_here(n_h) * lobe_rest(n_h, n_v, n_l, v_h));
    }
    if (gains.y > 0.0) {
      float l_in = sqrt(1.0 - (1.0 - n_l * n_l) / (kIor * kIor));
      float turn = -((dot(l, v) - n_l * n_v) / (kIor * kIor) + l_in * v_in);
      single += light * henyey_greenstein(turn) * (kPi * rho_dt_here(n_l) * n_l / (l_in + v_in));
    }
  }
  if (gains.y > 0.0) single *= rho_dt_here(n_v);
  vec4 amplitude = texture(single_specular, uv);
  vec3 sum = gains.x * specular * amplitude.a;
  sum += gains.y * single * amplitude.rgb;
  vec3 shallow, deep;
  gather(shallow, deep, direct);
  sum += gains.z * shallow * texture(shallow_albedo, uv).rgb;
  sum += gains.w * deep * texture(deep_albedo, uv).rgb;
  radiance = vec4(sum, 1.0);
}
