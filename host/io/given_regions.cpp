#include "io/given_regions.h"

#include "base/error.h"
#include "io/json.h"
#include "io/labels.h"
#include "session.pb.h"

namespace lamella {

namespace {

constexpr size_t kMostGreys = 64;  // more is the edge of a soft brush

// One region for every grey value, numbered from 1 in the greys' order.
void name_greys(const fs::path& png, Session* session) {
  std::array<uchar, 256> number{};
  std::array<bool, 256> there{};
  for (const uchar grey : session->given_labels) there[grey] = true;
  session->region_names = {"background"};
  for (size_t grey = 1; grey < there.size(); ++grey) {
    if (!there[grey]) continue;
    number[grey] = uchar(session->region_names.size());
    session->region_names.push_back("region " + std::to_string(grey));
  }
  const size_t greys = session->region_names.size() - 1;
  if (greys > kMostGreys) {
    throw_bad_input(png.string(), std::to_string(greys) + " grey values, each a region",
                    "paint with a hard brush, or name them in " + png.stem().string() + ".json");
  }
  for (uchar& label : session->given_labels) label = number[label];
}

}  // namespace

void give_regions(const fs::path& png, Session* session) {
  session->given_labels = read_labels(png);
  if (cv::countNonZero(session->given_labels) == 0) {
    throw_bad_input(png.string(), "nothing but background (0)", "paint a region with 1 to 255");
  }
  session->regions_file = png.string();
  const fs::path json = fs::path(png).replace_extension(".json");
  if (!fs::exists(json)) {
    name_greys(png, session);
  } else {
    v1::Regions regions;
    read_json(json, &regions);
    session->region_names.assign(regions.names().begin(), regions.names().end());
    require_region_names(session->region_names, json.string() + ": names");
  }
  read_regions(*session);
}

}  // namespace lamella
