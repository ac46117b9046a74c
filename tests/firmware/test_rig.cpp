#include "test_rig.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

std::string board_text(const std::string& file_name) {
  std::ifstream file(std::string(LAMELLA_BOARD_DIR) + "/" + file_name);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

struct rig test_rig(const std::string& name) {
  struct rig rig;
  EXPECT_EQ(rig_read((std::string(LAMELLA_BOARD_DIR) + "/" + name + ".rig").c_str(), &rig), LAM_OK)
      << name;
  return rig;
}

struct burst_plan planned(const struct rig& rig) {
  return planned(rig, {kBurstSteps, kBurstSteps + BURST_STEPS}, rig.analyser_parks_crossed);
}

struct burst_plan planned(const struct rig& rig, const std::vector<burst_step>& steps,
                          bool starts_crossed) {
  struct burst_plan plan;
  burst_order(&rig, steps.data(), steps.size(), starts_crossed, &plan);
  return plan;
}
