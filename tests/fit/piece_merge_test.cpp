#include "fit/piece_merge.h"

#include <gtest/gtest.h>

namespace lamella::fit {
namespace {

SkinPiece piece(double figure, double area_mm2, std::set<size_t> neighbours) {
  SkinPiece p;
  p.figure[0] = figure;
  p.area_mm2 = p.peak_mm2 = area_mm2;
  p.neighbours = std::move(neighbours);
  return p;
}

using Regions = std::vector<uint8_t>;

TEST(PieceMerge, JoinsTheTwoMostAlikeAtTheirMeanByArea) {
  const MergedPieces merged =
      merge_pieces({piece(0, 300, {1}), piece(1, 100, {0, 2}), piece(9, 500, {1})},
                   {.most_loss_mm2 = 100, .most = 12});
  EXPECT_EQ(merged.region, (Regions{1, 1, 0}));
  ASSERT_EQ(merged.regions.size(), 2u);
  EXPECT_DOUBLE_EQ(merged.regions[1].figure[0], 0.25);
  EXPECT_DOUBLE_EQ(merged.regions[1].area_mm2, 400);
}

TEST(PieceMerge, TwoCheeksThatDoNotTouchAreOneRegion) {
  const MergedPieces merged =
      merge_pieces({piece(5, 300, {1}), piece(0, 300, {0, 2}), piece(5, 300, {1})},
                   {.most_loss_mm2 = 100, .most = 12});
  EXPECT_EQ(merged.region, (Regions{0, 1, 0}));
}

TEST(PieceMerge, WhatIsTooSmallGoesToTheNeighbourThatIsMostAlikeNotToAStranger) {
  const MergedPieces merged = merge_pieces(
      {piece(0, 900, {1}), piece(4, 50, {0, 2}), piece(9, 900, {1}), piece(4.5, 900, {})},
      {.most_loss_mm2 = 10, .most = 12, .least_area_mm2 = 100});
  EXPECT_EQ(merged.region[1], merged.region[0]);
  EXPECT_EQ(merged.regions.size(), 3u);
}

TEST(PieceMerge, WhatHasNoPeakIsTooSmallHoweverLarge) {
  SkinPiece side = piece(9, 900, {0});
  side.peak_mm2 = 0;
  const MergedPieces merged = merge_pieces({piece(0, 900, {1}), side},
                                           {.most_loss_mm2 = 1, .most = 12, .least_peak_mm2 = 5});
  EXPECT_EQ(merged.regions.size(), 1u);
}

TEST(PieceMerge, LeavesNoMoreThanAskedForAtWhateverLoss) {
  std::vector<SkinPiece> pieces;
  for (size_t i = 0; i < 20; ++i) pieces.push_back(piece(100.0 * double(i), 900, {}));
  EXPECT_EQ(merge_pieces(pieces, {.most_loss_mm2 = 1, .most = 12}).regions.size(), 12u);
}

TEST(PieceMerge, OfNothingIsNothing) {
  EXPECT_TRUE(merge_pieces({}, {.most = 12}).regions.empty());
}

}  // namespace
}  // namespace lamella::fit
