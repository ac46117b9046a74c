#include "test_rig.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

std::string rig_file_text(const std::string& name) {
  std::ifstream file(std::string(LAMELLA_BOARD_DIR) + "/" + name + ".rig");
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
