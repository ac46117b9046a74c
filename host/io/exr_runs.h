// Run lengths, as OpenEXR's RLE_COMPRESSION stores them: a count below 0 and so many bytes, or a
// count and the byte that stands count + 1 times. A third of libdeflate's time where noise leaves
// nothing but runs to be found.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace lamella {

std::vector<uint8_t> packed_runs(const std::vector<uint8_t>& bytes);

// Fills `out`; false where the runs are cut, or are of fewer or more bytes.
bool unpack_runs(const uint8_t* packed, size_t packed_bytes, std::vector<uint8_t>* out);

}  // namespace lamella
