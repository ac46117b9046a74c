#include "apps/rig_option.h"

#include "io/wire.h"

namespace lamella::apps {

ArgumentFault rig_address(Simulated simulated) {
  return [simulated](const std::string& text) -> std::string {
    const bool sim = simulated == Simulated::kToo;
    if (sim && text == "sim") return "";
    if (const auto fault = address_fault(text)) return *fault + (sim ? ", or sim" : "");
    return names_a_host(text) ? "" : "\"" + text + "\": no such host; is it mistyped?";
  };
}

}  // namespace lamella::apps
