#include "apps/doubt_lines.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace lamella::apps {

namespace {

using Names = std::vector<std::string>;

struct Group {
  Names regions, layers;
  std::string why;
  fit::Doubt doubt;
};

bool has_reason(const Group& group, const fit::DoubtedLayer& layer) {
  return group.why == layer.why && group.doubt == layer.doubt;
}

// A layer of one reason, with all regions of which it is doubted for it.
std::vector<Group> by_layer(const std::vector<fit::DoubtedLayer>& doubted) {
  std::vector<Group> groups;
  for (const fit::DoubtedLayer& one : doubted) {
    const auto known = std::find_if(groups.begin(), groups.end(), [&](const Group& g) {
      return has_reason(g, one) && g.layers.front() == one.layer;
    });
    if (known == groups.end()) {
      groups.push_back({{one.region}, {one.layer}, one.why, one.doubt});
    } else {
      known->regions.push_back(one.region);
    }
  }
  return groups;
}

std::vector<Group> with_layers_joined(const std::vector<Group>& groups) {
  std::vector<Group> joined;
  for (const Group& group : groups) {
    const auto alike = std::find_if(joined.begin(), joined.end(), [&](const Group& g) {
      return g.why == group.why && g.doubt == group.doubt && g.regions == group.regions;
    });
    if (alike == joined.end()) {
      joined.push_back(group);
    } else {
      alike->layers.push_back(group.layers.front());
    }
  }
  return joined;
}

}  // namespace

std::vector<DoubtLine> doubt_lines(const std::vector<fit::DoubtedLayer>& doubted) {
  std::vector<DoubtLine> lines;
  for (const Group& group : with_layers_joined(by_layer(doubted))) {
    lines.push_back({fmt::format("{}: {}: {}", fmt::join(group.regions, ", "),
                                 fmt::join(group.layers, ", "), group.why),
                     group.doubt});
  }
  return lines;
}

}  // namespace lamella::apps
