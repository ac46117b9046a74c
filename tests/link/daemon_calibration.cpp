#include "daemon_calibration.h"

#include "test_rig.h"

extern "C" {
#include "calibration.h"
}

namespace lamella::testing {

std::string complaint_of_daemon(const std::string& calibration, size_t leds) {
  struct rig rig = test_rig("sim");
  rig.led_count = leds;
  char why[CALIBRATION_WHY_CHARS] = "";
  calibration_check(calibration.data(), calibration.size(), &rig, nullptr, why);
  return why;
}

}  // namespace lamella::testing
