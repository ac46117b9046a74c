// Any bytes as what a rig tells the twin of an exposure: understood whole, or refused with one
// line.
#include <google/protobuf/stubs/logging.h>

#include <cmath>

#include "fuzz_input.h"
#include "twin/exposure.h"

namespace {

constexpr int kLeds = 150, kFringes = 4, kLargestCode = 4095;

void require(bool holds) {
  if (!holds) std::abort();
}

void require_usable(const lamella::twin::Exposure& exposure) {
  require(exposure.camera == 0 || exposure.camera == 1);
  for (const lamella::twin::Contribution& c : exposure.contributions) {
    require(!std::isnan(c.polarized) && !std::isnan(c.depolarized));
    require(c.light.codes.empty() || c.light.codes.size() == size_t(kLeds));
    for (const uint16_t code : c.light.codes) require(code <= kLargestCode);
  }
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  google::protobuf::SetLogHandler(nullptr);  // as the program does
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  using namespace lamella;
  v1::ExposureReport report;
  if (!report.ParseFromArray(bytes, int(size))) return 0;
  fuzz::expect_error_or_nothing(
      [&] { require_usable(twin::read_exposure(report, kLeds, kFringes)); });
  return 0;
}
