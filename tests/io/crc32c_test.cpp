#include "io/crc32c.h"

#include <gtest/gtest.h>

#include <numeric>
#include <string>
#include <vector>

namespace lamella {
namespace {

TEST(Crc32c, GivesTheCheckValueOfTheCatalogue) { EXPECT_EQ(crc32c("123456789", 9), 0xe3069283u); }

// RFC 3720, appendix B.4.
TEST(Crc32c, GivesTheVectorsOfIscsi) {
  std::vector<unsigned char> bytes(32, 0);
  EXPECT_EQ(crc32c(bytes.data(), bytes.size()), 0x8a9136aau);
  std::iota(bytes.begin(), bytes.end(), 0);
  EXPECT_EQ(crc32c(bytes.data(), bytes.size()), 0x46dd794eu);
}

TEST(Crc32c, OfTwoPartsIsThatOfTheWhole) {
  const std::string text = "one photograph, sent in chunks of any length";
  const uint32_t whole = crc32c(text.data(), text.size());
  for (size_t cut = 0; cut <= text.size(); ++cut) {
    const uint32_t first = crc32c(text.data(), cut);
    EXPECT_EQ(crc32c(text.data() + cut, text.size() - cut, first), whole) << "cut at " << cut;
    const uint32_t second = crc32c(text.data() + cut, text.size() - cut);
    EXPECT_EQ(crc32c_of_parts(first, second, text.size() - cut), whole) << "cut at " << cut;
  }
}

}  // namespace
}  // namespace lamella
