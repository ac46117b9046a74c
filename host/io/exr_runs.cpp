#include "io/exr_runs.h"

#include <algorithm>
#include <cstring>

namespace lamella {

namespace {

constexpr ptrdiff_t kLeastRun = 3;  // shorter ones are no gain
constexpr ptrdiff_t kMostCount = 127;

const uint8_t* end_of_run(const uint8_t* first, const uint8_t* end) {
  const uint8_t* const last = first + std::min(end - first, kMostCount + 1);
  return std::find_if(first, last, [&](uint8_t byte) { return byte != *first; });
}

// Where the next run begins that is worth it, within what one count can name.
const uint8_t* end_of_others(const uint8_t* first, const uint8_t* end) {
  const uint8_t* const last = first + std::min(end - first, kMostCount);
  const uint8_t* at = first;
  while (at < last && !(end - at >= kLeastRun && at[0] == at[1] && at[1] == at[2])) ++at;
  return at;
}

}  // namespace

std::vector<uint8_t> packed_runs(const std::vector<uint8_t>& bytes) {
  std::vector<uint8_t> packed(bytes.size() + bytes.size() / size_t(kMostCount) + 1);
  uint8_t* to = packed.data();
  const uint8_t *at = bytes.data(), *const end = at + bytes.size();
  while (at < end) {
    const uint8_t* next = end_of_run(at, end);
    if (next - at >= kLeastRun) {
      *to++ = uint8_t(next - at - 1);
      *to++ = *at;
    } else {
      next = end_of_others(at, end);
      *to++ = uint8_t(at - next);
      to = std::copy(at, next, to);
    }
    at = next;
  }
  packed.resize(size_t(to - packed.data()));
  return packed;
}

bool unpack_runs(const uint8_t* packed, size_t packed_bytes, std::vector<uint8_t>* out) {
  const uint8_t* const packed_end = packed + packed_bytes;
  uint8_t *to = out->data(), *const end = to + out->size();
  while (packed < packed_end) {
    const int count = int8_t(*packed++);
    const ptrdiff_t bytes = count < 0 ? -count : count + 1;
    if (bytes > end - to || (count < 0 ? bytes : 1) > packed_end - packed) return false;
    if (count < 0) {
      std::memcpy(to, packed, size_t(bytes));
      packed += bytes;
    } else {
      std::memset(to, *packed++, size_t(bytes));
    }
    to += bytes;
  }
  return to == end;
}

}  // namespace lamella
