#include "io/exr_zip.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfHeader.h>
#include <libdeflate.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/core/hal/hal.hpp>
#include <stdexcept>

namespace lamella {

namespace {

// One channel of the file, in the order in which a line stores them.
struct Stored {
  bool is_half;
  const ExrPlane* to;  // null: not wanted
};

int lines_per_chunk(Imf::Compression compression) {
  return compression == Imf::ZIP_COMPRESSION ? 16 : 1;
}

// Empty where some channel cannot be read here.
std::vector<Stored> stored_channels(const Imf::Header& header,
                                    const std::vector<ExrPlane>& planes) {
  std::vector<Stored> stored;
  const Imf::ChannelList& list = header.channels();
  for (auto it = list.begin(); it != list.end(); ++it) {
    const Imf::Channel& channel = it.channel();
    if (channel.xSampling != 1 || channel.ySampling != 1 || channel.type == Imf::UINT) return {};
    const auto wanted = std::find_if(planes.begin(), planes.end(),
                                     [&](const ExrPlane& p) { return p.name == it.name(); });
    stored.push_back({channel.type == Imf::HALF, wanted == planes.end() ? nullptr : &*wanted});
  }
  return stored;
}

class Chunks {
 public:
  Chunks(Imf::InputFile* file, std::vector<Stored> stored)
      : file_(*file),
        stored_(std::move(stored)),
        box_(file->header().dataWindow()),
        width_(box_.max.x - box_.min.x + 1),
        decompressor_(libdeflate_alloc_decompressor(), libdeflate_free_decompressor) {
    if (!decompressor_) throw std::runtime_error("no memory to decompress it");
    for (const Stored& s : stored_) line_bytes_ += size_t(width_) * (s.is_half ? 2 : 4);
    row_.resize(size_t(width_));
  }

  void read_all() {
    const int step = lines_per_chunk(file_.header().compression());
    for (int y = box_.min.y; y <= box_.max.y; y += step) {
      const int lines = std::min(step, box_.max.y - y + 1);
      decompress(y, line_bytes_ * size_t(lines));
      for (int i = 0; i < lines; ++i) {
        unpack_line(pixels_.data() + line_bytes_ * size_t(i), y - box_.min.y + i);
      }
    }
  }

 private:
  void decompress(int y, size_t bytes) {
    const char* packed = nullptr;
    int packed_bytes = 0;
    file_.rawPixelData(y, packed, packed_bytes);
    pixels_.resize(bytes);
    // What does not get smaller is stored as it is.
    if (size_t(packed_bytes) == bytes) {
      std::memcpy(pixels_.data(), packed, bytes);
      return;
    }
    differences_.resize(bytes);
    size_t got = 0;
    const libdeflate_result result = libdeflate_zlib_decompress(
        decompressor_.get(), packed, size_t(packed_bytes), differences_.data(), bytes, &got);
    if (result != LIBDEFLATE_SUCCESS || got != bytes) {
      throw std::runtime_error("line " + std::to_string(y) + " cannot be decompressed");
    }
    undo_differences(bytes);
  }

  // Even bytes come first, then odd ones, and each is stored as its difference from the one before,
  // plus 128. Both halves are summed up side by side: the second begins where the first ends.
  void undo_differences(size_t bytes) {
    const size_t odd_at = (bytes + 1) / 2;
    const uint8_t* in = differences_.data();
    uint8_t even = in[0], odd = 0;
    for (size_t i = 0; i < odd_at; ++i) odd = uint8_t(odd + in[i]);
    odd = uint8_t(odd - 128 * (odd_at - 1));
    uint8_t* out = pixels_.data();
    out[0] = even;
    for (size_t i = 0; i < bytes / 2; ++i) {
      odd = uint8_t(odd + in[odd_at + i] - 128);
      out[2 * i + 1] = odd;
      if (i + 1 == odd_at) break;
      even = uint8_t(even + in[i + 1] - 128);
      out[2 * i + 2] = even;
    }
  }

  void unpack_line(const uint8_t* line, int y) {
    for (const Stored& s : stored_) {
      const size_t bytes = size_t(width_) * (s.is_half ? 2 : 4);
      if (s.to) {
        if (s.is_half) {
          halves_.resize(size_t(width_));
          std::memcpy(halves_.data(), line, bytes);
          cv::hal::cvt16f32f(halves_.data(), row_.data(), width_);
        } else {
          std::memcpy(row_.data(), line, bytes);
        }
        char* to = s.to->base + s.to->y_stride * size_t(y);
        for (int x = 0; x < width_; ++x) {
          std::memcpy(to + s.to->x_stride * size_t(x), &row_[size_t(x)], sizeof(float));
        }
      }
      line += bytes;
    }
  }

  Imf::InputFile& file_;
  std::vector<Stored> stored_;
  Imath::Box2i box_;
  int width_;
  size_t line_bytes_ = 0;
  std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor*)> decompressor_;
  std::vector<uint8_t> differences_, pixels_;
  std::vector<cv::float16_t> halves_;
  std::vector<float> row_;
};

}  // namespace

bool read_zip_planes(Imf::InputFile* file, const std::vector<ExrPlane>& planes) {
  const Imf::Header& header = file->header();
  const Imf::Compression compression = header.compression();
  if (compression != Imf::ZIP_COMPRESSION && compression != Imf::ZIPS_COMPRESSION) return false;
  if (header.hasTileDescription()) return false;
  std::vector<Stored> stored = stored_channels(header, planes);
  if (stored.empty()) return false;
  Chunks(file, std::move(stored)).read_all();
  return true;
}

}  // namespace lamella
