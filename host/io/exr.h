// OpenEXR files in and out. Errors name the file; a file is written whole or not at all.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/vec.h"
#include "io/exr_pack.h"

namespace lamella {

namespace fs = std::filesystem;

// What is read at most, in pixels: a damaged header must not ask for more memory than there is.
inline constexpr int kMaxImageSide = 32768;
inline constexpr int64_t kMaxImagePixels = int64_t(1) << 27;

// Channels R, G, B (half or float) as linear rgb. Throws Error where a channel is missing, the file
// is truncated or not EXR.
Image3 read_exr_rgb(const fs::path& path);

// The same of that part of it alone. Throws where any pixel, be it outside, is NaN or infinity.
Image3 read_finite_rgb(const fs::path& path, const cv::Rect& area);

// Channels X, Y, Z.
Image3 read_exr_xyz(const fs::path& path);

// Any channels by name, in the order asked for.
std::vector<Image1> read_exr(const fs::path& path, const std::vector<std::string>& channels);

// Width and height, from the header alone.
cv::Size exr_size(const fs::path& path);

// "600x750"
std::string size_words(cv::Size size);

// Names of the channels of a file, sorted.
std::vector<std::string> exr_channels(const fs::path& path);

// All images of one size. Compressed as `type` says, through a temporary file and a rename.
// `around`: what the file has beside them.
void write_exr(const fs::path& path, const std::vector<std::pair<std::string, Image1>>& channels,
               PixelType type = PixelType::kFloat,
               const std::optional<ExrSurroundings>& around = std::nullopt);
void write_exr_rgb(const fs::path& path, const Image3& rgb, PixelType type = PixelType::kFloat,
                   const std::optional<ExrSurroundings>& around = std::nullopt);
void write_exr_xyz(const fs::path& path, const Image3& xyz, PixelType type = PixelType::kFloat,
                   const std::optional<ExrSurroundings>& around = std::nullopt);

}  // namespace lamella
