// One picture that tells the story: the lit head, and beside it what each layer adds.
#pragma once

#include "layers.pb.h"
#include "review/renderer.h"
#include "review/window.h"

namespace lamella::review {

struct SheetRequest {
  std::string subject;
  cv::Size size{1600, 900};
  Look look;  // its gains say which layers are on; the orbit is the head's
};

// The picture, b g r. The lighting must have been set.
cv::Mat3b draw_sheet(Renderer* renderer, const Fonts& fonts, const v1::Layers& layers,
                     const SheetRequest& request);

// The lit head alone.
cv::Mat3b draw_head(Renderer* renderer, const Look& look, cv::Size size);

}  // namespace lamella::review
