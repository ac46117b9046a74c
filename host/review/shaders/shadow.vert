// Depth of the face as one light sees it.
layout(location = 0) in vec3 position_mm;
uniform mat4 clip_from_rig;
void main() { gl_Position = clip_from_rig * vec4(position_mm, 1.0); }
