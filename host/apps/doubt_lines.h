// What a fit doubts, in as few lines as there are reasons.
#pragma once

#include <string>
#include <vector>

#include "fit/layers.h"

namespace lamella::apps {

struct DoubtLine {
  std::string text;  // "forehead, nose: deep, shallow: no dot of the pattern lies on it"
  fit::Doubt doubt;
};

// In the order in which each reason first comes. Layers share a line where they have the reason and
// all of its regions in common.
std::vector<DoubtLine> doubt_lines(const std::vector<fit::DoubtedLayer>& doubted);

}  // namespace lamella::apps
