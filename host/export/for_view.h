// What of a face one view can show: how many texels and triangles, and which layers.
#pragma once

#include <string>
#include <vector>

#include "export/export.h"
#include "io/layer_maps.h"
#include "io/view.h"

namespace lamella::exporting {

struct LayerChoice {
  std::string layer;
  bool is_kept = true;
  double radius_mm = 0;  // how far light travels in it, in any region and channel at most
  double radius_px = 0;  // the same in the view, where the face is largest
  std::string why;
};

struct ViewChoice {
  cv::Size2f face_px;    // the face in the view, in its frame or not
  double px_per_mm = 0;  // where the face is largest
  int triangles = 0;
  int texture_side_px = 0;
  std::vector<LayerChoice> layers;
};

// A texel a pixel, triangles whose edges are a few pixels, neither finer than what was measured; a
// layer whose light travels less than a pixel is albedo and is left out. Throws Error (`where`
// names the view) where its camera does not see the face.
ViewChoice choose_for_view(const LayerMaps& maps, const v1::Layers& layers, const View& view,
                           const std::string& where);

// The layers without those that the choice leaves out.
v1::Layers kept_layers(const v1::Layers& layers, const ViewChoice& choice);

// A view leaves out, it adds to nothing: of both what is less.
ExportOptions options_for_view(const ViewChoice& choice, const ExportOptions& most);

}  // namespace lamella::exporting
