#include "review/panels.h"

#include <imgui.h>

#include <algorithm>

#include "base/error.h"
#include "io/json.h"
#include "review/plots.h"

namespace lamella::review {

namespace {

constexpr float kFrameGain = 1.5f;
constexpr float kPanelWidthPx = 360.f, kListHeightPx = 200.f;
constexpr float kDegrees = 180.f / kPi;  // in a radian

ImTextureID id_of(const Texture& texture) {
  return reinterpret_cast<ImTextureID>(intptr_t(texture.name.id()));
}

Image3 grey(const Image1& values) {
  Image3 rgb;
  cv::merge(std::vector<cv::Mat>{values, values, values}, rgb);
  return rgb;
}

// Linear light as the screen wants it; anything not known is black.
cv::Mat3b encoded(const Image3& linear, float gain) {
  cv::Mat3b bgr(linear.size());
  for (int y = 0; y < linear.rows; ++y) {
    for (int x = 0; x < linear.cols; ++x) {
      for (int c = 0; c < 3; ++c) {
        const float v = gain * linear(y, x)[c];
        bgr(y, x)[2 - c] = uchar(v > 0 ? 255.f * std::pow(std::min(v, 1.f), 1.f / 2.2f) : 0.f);
      }
    }
  }
  return bgr;
}

void fitted_image(const Texture& texture) {
  const float width = ImGui::GetContentRegionAvail().x;
  ImGui::Image(id_of(texture), {width, width * float(texture.height) / float(texture.width)});
}

void layer_switch(const char* label, float* gain) {
  bool is_on = *gain > 0;
  if (ImGui::Checkbox(label, &is_on)) *gain = is_on ? 1.f : 0.f;
}

}  // namespace

void LightState::turn_key(float azimuth_rad, float elevation_rad) {
  const Vec3 d = unit(lighting.key.direction);
  const float azimuth = std::atan2(d[0], d[2]) + azimuth_rad;
  const float elevation = std::clamp(std::asin(d[1]) + elevation_rad, -1.5f, 1.5f);
  lighting.key.direction = {std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
                            std::cos(elevation) * std::cos(azimuth)};
  is_changed = true;
}

Panels::Panels(const ReviewRequest& request, const FaceMaps& face) : layers_(request.layers) {
  const LayerMaps& m = face.maps;
  add_map("total albedo", m.total_albedo, 1);
  add_map("deep albedo", m.deep_albedo, 1);
  add_map("shallow albedo (white: 0.5)", m.shallow_albedo, 2);
  add_map("single scattering albedo", m.single_albedo, 1);
  if (!m.specular_intensity.empty())
    add_map("specular c (white: 0.5)", grey(m.specular_intensity), 2);
  const Vec3 half(0.5f, 0.5f, 0.5f);
  add_map("specular normal", m.normal_specular * 0.5f + cv::Scalar(half[0], half[1], half[2]), 1);
  for (int c = 0; c < 3; ++c) {
    const Image3& n = m.normal_diffuse[size_t(c)];
    if (n.empty()) continue;
    const char* const names[] = {"diffuse normal, red", "diffuse normal, green",
                                 "diffuse normal, blue"};
    add_map(names[c], n * 0.5f + cv::Scalar(half[0], half[1], half[2]), 1);
  }
  add_map("deep mean free path (white: 4 mm)", m.deep_ld_mm * 0.25f, 1);
  for (const auto& [name, confidence] : m.confidence) {
    std::string words = name;
    std::replace(words.begin(), words.end(), '_', ' ');
    add_map("confidence of " + words, grey(confidence), 1);
  }
  try {
    session_ = read_session(request.session);
    if (fs::exists(request.session / "timing.json")) {
      timing_.emplace();
      read_json(request.session / "timing.json", &*timing_);
    }
  } catch (const Error& e) {
    session_problem_ = e.what();
  }
}

void Panels::add_map(const std::string& name, const Image3& values, float gain) {
  if (values.empty()) return;
  Image3 shown = values * gain;
  maps_.push_back({name, map_texture(shown), picture_texture(encoded(values, gain))});
}

void Panels::draw(Look* look, LightState* light) {
  // Docked: what is opened has the whole height, and the face the rest of the width.
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0, 0});
  ImGui::SetNextWindowSize({kPanelWidthPx, screen.y});
  ImGui::Begin("Review", nullptr,
               ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoTitleBar);
  look->orbit.shift[0] = std::min(0.5f, kPanelWidthPx / std::max(1.f, screen.x));
  draw_layers(look);
  draw_light(look, light);
  if (ImGui::CollapsingHeader("Maps")) draw_maps(look);
  if (ImGui::CollapsingHeader("Lobes and profiles")) draw_regions();
  if (ImGui::CollapsingHeader("Frames")) draw_frames();
  if (ImGui::CollapsingHeader("Timing")) draw_timing();
  ImGui::End();
}

void Panels::draw_layers(Look* look) const {
  ImGui::TextDisabled("LAYERS");
  layer_switch("1  specular reflection", &look->gains.specular);
  layer_switch("2  single scattering", &look->gains.single);
  layer_switch("3  shallow scattering", &look->gains.shallow);
  layer_switch("4  deep scattering", &look->gains.deep);
}

void Panels::draw_light(Look* look, LightState* light) const {
  ImGui::Spacing();
  ImGui::TextDisabled("LIGHT");
  const char* const names[] = {"portrait", "front", "side"};
  for (const char* name : names) {
    if (name != names[0]) ImGui::SameLine();
    if (ImGui::Button(name)) *light = {lighting_named(name), true};
  }
  ImGui::PushItemWidth(0.55f * ImGui::GetWindowWidth());
  const Vec3 key = unit(light->lighting.key.direction);
  const float azimuth_deg = std::atan2(key[0], key[2]) * kDegrees;
  const float elevation_deg = std::asin(key[1]) * kDegrees;
  float azimuth = azimuth_deg, elevation = elevation_deg;
  ImGui::SliderFloat("key, around", &azimuth, -180.f, 180.f, "%.0f\u00b0");
  ImGui::SliderFloat("key, up", &elevation, -85.f, 85.f, "%.0f\u00b0");
  if (azimuth != azimuth_deg || elevation != elevation_deg) {
    light->turn_key((azimuth - azimuth_deg) / kDegrees, (elevation - elevation_deg) / kDegrees);
  }
  float stops = std::log2(look->exposure);
  if (ImGui::SliderFloat("exposure", &stops, -3.f, 3.f, "%+.1f stops")) {
    look->exposure = std::exp2(stops);
  }
  ImGui::PopItemWidth();
  ImGui::TextDisabled("drag: camera   right drag: key light\nwheel: distance   1 to 4: layers");
  ImGui::Spacing();
}

void Panels::draw_maps(Look* look) {
  ImGui::BeginChild("maps", {0, kListHeightPx});
  if (ImGui::Selectable("lit", map_on_face_ < 0)) map_on_face_ = -1;
  for (size_t i = 0; i < maps_.size(); ++i) {
    if (ImGui::Selectable(maps_[i].name.c_str(), map_on_face_ == int(i))) map_on_face_ = int(i);
  }
  ImGui::EndChild();
  look->plain_map = map_on_face_ < 0 ? nullptr : &maps_[size_t(map_on_face_)].on_face;
  if (map_on_face_ >= 0) fitted_image(maps_[size_t(map_on_face_)].flat);
}

void Panels::draw_regions() const {
  for (const v1::Region& region : layers_.regions()) {
    if (!ImGui::TreeNode(region.name().c_str())) continue;
    plot_lobe(region.specular());
    plot_profile(region.deep());
    for (const auto& [layer, why] : region.layers().why()) {
      ImGui::TextWrapped("%s: %s", layer.c_str(), why.c_str());
    }
    ImGui::TreePop();
  }
}

void Panels::show_frame(size_t index) {
  frame_shown_ = index;
  frame_.reset();
  frame_problem_.clear();
  try {
    const Photograph photograph = read_photograph(*session_, session_->frames[index]);
    frame_ = picture_texture(encoded(photograph.radiance, kFrameGain));
  } catch (const Error& e) {
    frame_problem_ = e.what();
  }
}

void Panels::draw_frames() {
  if (!session_) {
    ImGui::TextWrapped("%s", session_problem_.c_str());
    return;
  }
  ImGui::BeginChild("list", {0, kListHeightPx});
  for (size_t i = 0; i < session_->frames.size(); ++i) {
    const std::string& file = session_->frames[i].file;
    if (ImGui::Selectable(file.c_str(), frame_ && frame_shown_ == i)) show_frame(i);
  }
  ImGui::EndChild();
  if (frame_) fitted_image(*frame_);
  if (!frame_problem_.empty()) ImGui::TextWrapped("%s", frame_problem_.c_str());
}

void Panels::draw_timing() const {
  if (!timing_) {
    ImGui::TextWrapped("This session has no timing.json: its rig measured no edges.");
    return;
  }
  plot_timing(*timing_);
}

}  // namespace lamella::review
