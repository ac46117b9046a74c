// What stands beside the lit head: switches, maps, lobes, profiles, frames and timing.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "link.pb.h"
#include "review/review.h"

namespace lamella::review {

struct LightState {
  Lighting lighting;
  bool is_changed = true;

  // About the vertical, and up.
  void turn_key(float azimuth_rad, float elevation_rad);
};

class Panels {
 public:
  // Needs a current context. A session that cannot be read leaves its panels out and says why.
  Panels(const ReviewRequest& request, const FaceMaps& face);

  void draw(Look* look, LightState* light);

 private:
  void draw_layers(Look* look) const;
  void draw_light(Look* look, LightState* light) const;
  void draw_maps(Look* look);
  void draw_regions() const;
  void draw_frames();
  void draw_timing() const;
  void show_frame(size_t index);

  struct Map {
    std::string name;
    Texture on_face;  // linear values, for the face
    Texture flat;     // encoded for the screen
  };
  void add_map(const std::string& name, const Image3& values, float gain);

  v1::Layers layers_;
  std::vector<Map> maps_;
  int map_on_face_ = -1;
  std::optional<Session> session_;
  std::string session_problem_;
  std::optional<v1::TimingEdges> timing_;
  size_t frame_shown_ = 0;
  std::optional<Texture> frame_;
  std::string frame_problem_;
};

}  // namespace lamella::review
