// A planned burst as a chart (SVG): who waits for whom, to scale.
#pragma once

#include <string>

#include "plan.pb.h"

namespace lamella::apps {

// `title`: the rig's name.
std::string plan_chart(const v1::Plan& plan, const std::string& title);

// A frame in a few characters: "FULL ∥", "STRIPES 2 ×".
std::string short_name(const v1::PlannedStep& step);

bool is_lit_by_leds(const v1::PlannedStep& step);

}  // namespace lamella::apps
