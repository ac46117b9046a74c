// NumPy's archive of arrays: a zip of stored .npy members.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace lamella::twin {

struct NpyArray {
  std::string name;
  std::vector<size_t> shape;
  std::vector<float> values;  // row-major
};

void write_npz(const std::filesystem::path& path, const std::vector<NpyArray>& arrays);

}  // namespace lamella::twin
