#include "apps/doubt_lines.h"

#include <gtest/gtest.h>

namespace lamella::apps {
namespace {

using fit::Doubt;

std::vector<std::string> texts(const std::vector<fit::DoubtedLayer>& doubted) {
  std::vector<std::string> all;
  for (const DoubtLine& line : doubt_lines(doubted)) all.push_back(line.text);
  return all;
}

TEST(DoubtLines, SayAReasonThatAllRegionsHaveInCommonOnce) {
  EXPECT_EQ(texts({{"nose", "deep", "no dot", Doubt::kNotJudged},
                   {"nose", "shallow", "no dot", Doubt::kNotJudged},
                   {"lips", "deep", "no dot", Doubt::kNotJudged},
                   {"lips", "shallow", "no dot", Doubt::kNotJudged}}),
            std::vector<std::string>{"nose, lips: deep, shallow: no dot"});
}

TEST(DoubtLines, KeepApartWhatDiffersInReasonRegionsOrDoubt) {
  EXPECT_EQ(texts({{"nose", "deep", "no dot", Doubt::kNotJudged},
                   {"lips", "deep", "no dot", Doubt::kAtBound},
                   {"lips", "single", "too dark", Doubt::kNotJudged},
                   {"chin", "deep", "no dot", Doubt::kNotJudged},
                   {"chin", "shallow", "no dot", Doubt::kNotJudged}}),
            (std::vector<std::string>{"nose, chin: deep: no dot", "lips: deep: no dot",
                                      "lips: single: too dark", "chin: shallow: no dot"}));
}

}  // namespace
}  // namespace lamella::apps
