// The least calibration that a rig is started with: one LED, cameras of a size.
#pragma once

#include <string>

inline std::string calibration_text(int width = 160, int height = 120,
                                    const std::string& subject = "") {
  const std::string size =
      R"("width": )" + std::to_string(width) + R"(, "height": )" + std::to_string(height);
  return R"({"format": "lamella.session.v1", "subject": ")" + subject + R"(",
 "rig": {"leds": [{"direction": [0, 1, 0]}],
  "cameras": [
   {"id": "left", )" +
         size + R"(},
   {"id": "right", )" +
         size + R"(}],
  "projector": {"width": 1280, "height": 800}}}
)";
}
