#include "base/error.h"

#include <gtest/gtest.h>

namespace lamella {
namespace {

TEST(Error, IsOneLineOfWhereWhatAndWhatToDo) {
  const Error e(Fault::kBadInput, "a.exr", "truncated", "copy it again");
  EXPECT_STREQ(e.what(), "a.exr: truncated; copy it again");
}

TEST(Error, LeavesOutWhatIsNotKnown) {
  EXPECT_STREQ(Error(Fault::kRig, "", "gone").what(), "gone");
}

TEST(Error, CarriesNoLineEndsAndNoTerminalEscapesFromAFile) {
  const std::string line = Error(Fault::kBadInput, "x", "\"\x1b[2J\nsecond\r\x07line\"").what();
  for (const char c : line) EXPECT_GE(static_cast<unsigned char>(c), 0x20);
}

}  // namespace
}  // namespace lamella
