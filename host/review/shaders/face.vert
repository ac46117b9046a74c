layout(location = 0) in vec3 position_mm;
layout(location = 1) in vec2 map_uv;
uniform mat4 clip_from_rig;
out vec2 uv;
void main() {
  uv = map_uv;
  gl_Position = clip_from_rig * vec4(position_mm, 1.0);
}
