// Pieces of a face joined to regions of skin that is alike, the two most alike first (Ward 1963).
#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <vector>

namespace lamella::fit {

inline constexpr size_t kPieceFigures = 5;

struct SkinPiece {
  std::array<double, kPieceFigures> figure{};  // means, each in steps that tell skin from skin
  double area_mm2 = 0;
  double peak_mm2 = 0;  // of it, where FRONT shows the peak of the lobe
  std::set<size_t> neighbours;
};

// Two pieces are joined at a loss: by how much the squares of figures against their piece's mean
// grow, over the area. First pieces that touch, then any two; what is left too small then goes to
// the piece beside it, or where none is to any, that is most alike.
struct MergeRules {
  double most_loss_mm2 = 0;
  size_t most = 0;  // regions: beyond it, at any loss
  double least_area_mm2 = 0, least_peak_mm2 = 0;
};

struct MergedPieces {
  std::vector<uint8_t> region;     // of each piece, into `regions`
  std::vector<SkinPiece> regions;  // the largest first
};

// In one order, whatever the processors. `rules.most` at most 255.
MergedPieces merge_pieces(std::vector<SkinPiece> pieces, const MergeRules& rules);

}  // namespace lamella::fit
