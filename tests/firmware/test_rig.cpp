#include "test_rig.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

std::string rig_file_text() {
  std::ifstream file(LAMELLA_RIG_FILE);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

struct rig test_rig() {
  const std::string text = rig_file_text();
  struct rig rig;
  struct rig_error error;
  EXPECT_EQ(rig_parse(text.data(), text.size(), &rig, &error), LAM_OK) << error.text;
  return rig;
}
