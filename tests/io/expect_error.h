// What bad input must give: one line that names the file and the field.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "base/error.h"

namespace lamella::testing {

// The one line of the Error that `act` throws; "" where it throws none.
template <class Act>
std::string complaint(const Act& act) {
  try {
    act();
  } catch (const Error& e) {
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
    return e.what();
  }
  return "";
}

// EXPECT_TRUE(names(line, {"session.json", "frames[3].step"})).
inline ::testing::AssertionResult names(const std::string& line,
                                        std::initializer_list<std::string> parts) {
  for (const std::string& part : parts) {
    if (line.find(part) == std::string::npos) {
      return ::testing::AssertionFailure() << "\"" << line << "\" does not name \"" << part << "\"";
    }
  }
  return ::testing::AssertionSuccess();
}

}  // namespace lamella::testing
