// Raw photographs: row-major, 12 bits a sample, two samples in three bytes, low bits first; an odd
// last sample is padded with zero. Rows are not padded. "RGB12P" has R G B interleaved; the others
// have one sample a pixel: "GREY12P", and a Bayer mosaic by the colours of its first two rows.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/vec.h"

namespace lamella {

inline constexpr const char* kRgb12p = "RGB12P";
inline constexpr int kRaw12Levels = 4096;

enum class RawPixels { kRgb, kGrey, kRggb, kGrbg, kGbrg, kBggr };

// Of a Frame's `pixel_format`; none where it is unknown.
std::optional<RawPixels> raw_pixels_named(const std::string& pixel_format);

constexpr bool is_mosaic(RawPixels pixels) {
  return pixels != RawPixels::kRgb && pixels != RawPixels::kGrey;
}

// Bytes of a photograph; 0 where there is none of that size: a mosaic has all its colours from 2 x
// 2 pixels on.
size_t raw12_bytes(RawPixels pixels, size_t width, size_t height);

using RawImage = cv::Mat_<cv::Vec3w>;  // rows x columns, rgb, raw_dn in 0 .. 4095

constexpr size_t rgb12p_bytes(size_t width, size_t height) {
  return (width * height * 3 + 1) / 2 * 3;
}

// Values over 4095 are cut to 12 bits by the caller, not here: only the low 12 bits are kept.
std::vector<uint8_t> pack_rgb12p(const RawImage& raw_dn);

// `size_bytes` must be rgb12p_bytes(size.width, size.height), or the image comes back empty.
RawImage unpack_rgb12p(const uint8_t* bytes, size_t size_bytes, cv::Size size);

// The same, each value through a table. Parallel.
using Raw12Table = std::array<float, kRaw12Levels>;
Image3 map_rgb12p(const uint8_t* bytes, size_t size_bytes, cv::Size size, const Raw12Table& table);

// One sample a pixel, each value through a table. Parallel. Empty where `size_bytes` is not that of
// (width * height) samples.
Image1 map_plane12p(const uint8_t* bytes, size_t size_bytes, cv::Size size,
                    const Raw12Table& table);

}  // namespace lamella
