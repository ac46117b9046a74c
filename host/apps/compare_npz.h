// Arrays out of a NumPy .npz file: a zip of .npy members, stored or deflated.
#pragma once

#include <string>
#include <vector>

#include "io/exr.h"

namespace lamella::apps {

struct NpzArray {
  std::vector<size_t> shape;
  std::vector<double> values;  // last index fastest
};

// Member `name` (without ".npy") of little-endian float32 or float64. Throws Error that names the
// file where it is not such an archive or has no such member.
NpzArray read_npz(const fs::path& file, const std::string& name);

}  // namespace lamella::apps
