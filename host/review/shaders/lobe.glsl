// Equation 1 with c = 1: the same p, Fresnel term and V-groove as on the processor.
const float kIor = 1.38;
uniform sampler1DArray lobes;  // p against 1 - cos(theta); one layer a region

float fresnel(float c) {
  float g = sqrt(kIor * kIor - 1.0 + c * c);
  float a = (g - c) / (g + c);
  float b = (c * (g + c) - 1.0) / (c * (g - c) + 1.0);
  return 0.5 * a * a * (1.0 + b * b);
}

float facet_density(int region, float n_h) {
  float cells = float(textureSize(lobes, 0).x);
  float x = clamp(1.0 - n_h, 0.0, 1.0) * (cells - 1.0);
  return texture(lobes, vec2((x + 0.5) / cells, float(region))).r;
}

// f (n.l), per steradian, without p.
float lobe_rest(float n_h, float n_v, float n_l, float v_h) {
  float groove = min(1.0, 2.0 * n_h * min(n_v, n_l) / v_h);
  return fresnel(v_h) * groove / n_v;
}
