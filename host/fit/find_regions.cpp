#include "fit/find_regions.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "base/parallel.h"
#include "fit/piece_merge.h"
#include "fit/skin_cells.h"

namespace lamella::fit {

namespace {

// What a difference of skin is, in each figure: lips are 4 steps of red from the cheek beside them,
// a nose is 1 to 2 steps of gloss from it. Light and sheen tell shade as much as skin.
constexpr double kRedStep = 0.1, kYellowStep = 0.06, kLightStep = 2;
constexpr double kGlossStep = 0.04, kSheenStep = 2;
// By twins of six heads: with fewer and larger regions lips and nose are lost, with more and
// smaller ones the layers' fits are worse than those of the whole face.
constexpr MergeRules kRules{.most_loss_mm2 = 1000,
                            .most = 12,
                            .least_area_mm2 = 700,  // three dots with the light around them
                            .least_peak_mm2 = 15};
constexpr int kSmoothing = 2;   // blocks to each side whose labels a block's own is voted by
constexpr double kAhead = 0.5;  // steps: a region is named after what it has more of than any other

SkinPiece piece_of(const SkinCell& cell) {
  SkinPiece piece;
  piece.figure = {cell.red / kRedStep, cell.yellow / kYellowStep, cell.light / kLightStep,
                  cell.gloss / kGlossStep, cell.sheen / kSheenStep};
  piece.area_mm2 = cell.area_mm2;
  piece.peak_mm2 = cell.peak_mm2;
  return piece;
}

// Cells that say something, each a piece beside those that touch it.
struct Pieces {
  cv::Mat1i at;  // index into `pieces`, -1 where the cell says nothing
  std::vector<SkinPiece> pieces;
};

Pieces pieces_of(const SkinCells& cells) {
  Pieces out{cv::Mat1i(cells.size, -1), {}};
  const auto touch = [&](int a, int b) {
    if (a < 0 || b < 0) return;
    out.pieces[size_t(a)].neighbours.insert(size_t(b));
    out.pieces[size_t(b)].neighbours.insert(size_t(a));
  };
  for (int y = 0; y < cells.size.height; ++y) {
    for (int x = 0; x < cells.size.width; ++x) {
      const SkinCell& cell = cells.cells[size_t(y * cells.size.width + x)];
      if (cell.area_mm2 <= 0) continue;
      out.at(y, x) = int(out.pieces.size());
      out.pieces.push_back(piece_of(cell));
      if (x > 0) touch(out.at(y, x), out.at(y, x - 1));
      if (y > 0) touch(out.at(y, x), out.at(y - 1, x));
    }
  }
  return out;
}

// Which region is ahead of all others in `figure` times `sign`, by enough to be named after it.
int outstanding(const std::vector<SkinPiece>& regions, size_t figure, double sign) {
  int first = -1;
  double best = -1e30, second = -1e30;
  for (size_t i = 0; i < regions.size(); ++i) {
    const double value = sign * regions[i].figure[figure];
    if (value > best) {
      second = best;
      best = value;
      first = int(i);
    } else {
      second = std::max(second, value);
    }
  }
  return best - second > kAhead ? first : -1;
}

// "region 2 (reddest, glossiest)"; the largest has number 1.
std::vector<std::string> names_of(const std::vector<SkinPiece>& regions) {
  if (regions.size() == 1) return {"background", "face"};
  struct Trait {
    const char* name;
    size_t figure;
    double sign;
  };
  constexpr size_t kRed = 0, kGloss = 3;
  constexpr Trait kTraits[] = {{"reddest", kRed, 1},
                               {"least red", kRed, -1},
                               {"glossiest", kGloss, 1},
                               {"dullest", kGloss, -1}};
  std::vector<std::string> names{"background"}, traits(regions.size());
  for (const Trait& trait : kTraits) {
    const int first = outstanding(regions, trait.figure, trait.sign);
    if (first < 0) continue;
    std::string& text = traits[size_t(first)];
    text += (text.empty() ? "" : ", ") + std::string(trait.name);
  }
  for (size_t i = 0; i < regions.size(); ++i) {
    names.push_back(fmt::format("region {}", i + 1) +
                    (traits[i].empty() ? "" : " (" + traits[i] + ")"));
  }
  return names;
}

// Every block with a label takes that of most around it; of equally many its own.
Labels smoothed(const Labels& blocks) {
  Labels out(blocks.size(), 0);
  const cv::Rect picture({0, 0}, blocks.size());
  parallel_for(blocks.rows, [&](int y) {
    for (int x = 0; x < blocks.cols; ++x) {
      if (!blocks(y, x)) continue;
      constexpr int kSide = 2 * kSmoothing + 1;
      std::array<int, 256> votes{};
      ++votes[blocks(y, x)];
      const cv::Rect around = cv::Rect(x - kSmoothing, y - kSmoothing, kSide, kSide) & picture;
      for (const uchar label : Labels(blocks(around))) votes[label] += 2;
      votes[0] = 0;
      out(y, x) = uchar(std::max_element(votes.begin(), votes.end()) - votes.begin());
    }
  });
  return out;
}

// Every block the label of the nearest that has one.
Labels nearest_labels(const Labels& blocks) {
  Image1 away;
  cv::Mat1i nearest;
  cv::distanceTransform(blocks == 0, away, nearest, cv::DIST_L2, 5, cv::DIST_LABEL_PIXEL);
  std::vector<uchar> label_of(size_t(blocks.size().area()) + 1, 0);
  for (int y = 0; y < blocks.rows; ++y) {
    for (int x = 0; x < blocks.cols; ++x) {
      if (blocks(y, x)) label_of[size_t(nearest(y, x))] = blocks(y, x);
    }
  }
  Labels all(blocks.size());
  for (int y = 0; y < blocks.rows; ++y) {
    for (int x = 0; x < blocks.cols; ++x) all(y, x) = label_of[size_t(nearest(y, x))];
  }
  return all;
}

uchar label_at(const Labels& blocks, float u, float v) {
  const int x0 = int(std::floor(u)), y0 = int(std::floor(v));
  const float right = u - float(x0), below = v - float(y0);
  std::array<uchar, 4> label{};
  std::array<float, 4> weight{};
  for (int k = 0; k < 4; ++k) {
    label[size_t(k)] = blocks(std::clamp(y0 + k / 2, 0, blocks.rows - 1),
                              std::clamp(x0 + k % 2, 0, blocks.cols - 1));
    weight[size_t(k)] = (k % 2 ? right : 1 - right) * (k / 2 ? below : 1 - below);
  }
  size_t best = 0;
  float most = -1;
  for (size_t i = 0; i < 4; ++i) {
    float sum = 0;
    for (size_t k = 0; k < 4; ++k) sum += label[k] == label[i] ? weight[k] : 0;
    if (sum > most) most = sum, best = i;
  }
  return label[best];
}

// A thin region may have lost all of its blocks to its neighbours: numbers anew what is left.
void drop_lost(Labels* labels, std::vector<SkinPiece>* regions) {
  std::array<int, 256> count{};
  for (const uchar label : *labels) ++count[label];
  std::array<uchar, 256> number{};
  std::vector<SkinPiece> left;
  for (size_t i = 0; i < regions->size(); ++i) {
    if (count[i + 1] == 0) continue;
    left.push_back((*regions)[i]);
    number[i + 1] = uchar(left.size());
  }
  for (uchar& label : *labels) label = number[label];
  *regions = left;
}

}  // namespace

Labels labels_of_pixels(const Labels& blocks, int step_px, const Mask& subject) {
  const Labels all = nearest_labels(blocks);
  Labels labels(subject.size(), 0);
  parallel_for(labels.rows, [&](int y) {
    const float v = (float(y) + 0.5f) / float(step_px) - 0.5f;
    for (int x = 0; x < labels.cols; ++x) {
      if (!subject(y, x)) continue;
      labels(y, x) = label_at(all, (float(x) + 0.5f) / float(step_px) - 0.5f, v);
    }
  });
  return labels;
}

FoundRegions find_regions(const Burst& burst, const Geometry& geometry, const Normals& normals) {
  const SkinCells cells = skin_cells(burst, geometry, normals);
  const Pieces pieces = pieces_of(cells);
  const Mask subject = burst.regions > 0;
  FoundRegions found{Labels(subject.size(), 0), {"background", "face"}};
  found.labels.setTo(1, subject);
  if (pieces.pieces.empty()) return found;
  MergedPieces merged = merge_pieces(pieces.pieces, kRules);
  Labels blocks(cells.size, 0);
  for (int y = 0; y < blocks.rows; ++y) {
    for (int x = 0; x < blocks.cols; ++x) {
      if (pieces.at(y, x) >= 0) blocks(y, x) = uchar(merged.region[size_t(pieces.at(y, x))] + 1);
    }
  }
  found.labels = labels_of_pixels(smoothed(blocks), cells.step_px, subject);
  drop_lost(&found.labels, &merged.regions);
  found.names = names_of(merged.regions);
  return found;
}

}  // namespace lamella::fit
