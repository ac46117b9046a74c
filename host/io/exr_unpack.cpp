#include "io/exr_unpack.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <libdeflate.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/core/hal/hal.hpp>
#include <opencv2/core/hal/intrin.hpp>
#include <span>
#include <stdexcept>

#include "io/crc32c.h"
#include "io/exr_pack.h"
#include "io/exr_runs.h"

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

// Sums up bytes that are stored as differences from the one before, plus 128.
class RunningSum {
 public:
  explicit RunningSum(uint8_t before) : last_(before) {}

  cv::v_uint8x16 next(const uint8_t* differences) {
    cv::v_uint8x16 sum = cv::v_add_wrap(cv::v_load(differences), cv::v_setall_u8(128));
    sum = cv::v_add_wrap(sum, cv::v_rotate_left<1>(sum));
    sum = cv::v_add_wrap(sum, cv::v_rotate_left<2>(sum));
    sum = cv::v_add_wrap(sum, cv::v_rotate_left<4>(sum));
    sum = cv::v_add_wrap(sum, cv::v_rotate_left<8>(sum));
    sum = cv::v_add_wrap(sum, cv::v_setall_u8(last_));
    last_ = cv::v_extract_n<15>(sum);
    return sum;
  }

  uint8_t next(uint8_t difference) { return last_ = uint8_t(last_ + difference - 128); }

 private:
  uint8_t last_;
};

// Whether the planes are the channels of one image of Vec3.
bool are_interleaved(const std::vector<ExrPlane>& planes) {
  if (planes.size() != 3) return false;
  for (size_t c = 0; c < 3; ++c) {
    const bool follows = planes[c].base == planes[0].base + c * sizeof(float);
    if (!follows || planes[c].x_stride != 3 * sizeof(float)) return false;
  }
  return true;
}

class Chunks {
 public:
  Chunks(Imf::InputFile* file, std::vector<Stored> stored, const std::vector<ExrPlane>& planes,
         const ExrPart& part)
      : file_(*file),
        stored_(std::move(stored)),
        planes_(planes),
        area_(part.area),
        must_be_finite_(part.is_finite),
        are_interleaved_(are_interleaved(planes)),
        box_(file->header().dataWindow()),
        width_(box_.max.x - box_.min.x + 1),
        decompressor_(libdeflate_alloc_decompressor(), libdeflate_free_decompressor),
        halves_(size_t(area_.width)),
        rows_(planes.size(), std::vector<float>(size_t(area_.width))) {
    if (!decompressor_) throw std::runtime_error("no memory to decompress it");
    for (const Stored& s : stored_) line_bytes_ += bytes_of(s);
  }

  // Chunks outside of the area too: what is damaged is damaged.
  void read() {
    const int step = lines_per_chunk(file_.header().compression());
    const int height = box_.max.y - box_.min.y + 1;
    for (int top = 0; top < height; top += step) {
      const int lines = std::min(step, height - top);
      decompress(box_.min.y + top, line_bytes_ * size_t(lines));
      for (int y = top; y < top + lines; ++y)
        take_line(y, pixels_.data() + line_bytes_ * size_t(y - top));
    }
    require_crc();
  }

 private:
  // Other programs' files have none.
  void require_crc() const {
    const auto* stated = file_.header().findTypedAttribute<Imf::IntAttribute>(kExrCrc);
    if (stated && uint32_t(stated->value()) != crc_) {
      throw std::runtime_error(
          "its packed pixels are not those that lamella_crc32c is of: a bit flipped, or another "
          "program wrote it and kept that attribute");
    }
  }

  void take_line(int y, const uint8_t* line) {
    if (must_be_finite_) require_finite(line, y);
    if (y >= area_.y && y < area_.br().y) unpack_line(line, y - area_.y);
  }

  void require_finite(const uint8_t* line, int y) const {
    int first = width_;
    for (const Stored& s : stored_) {
      if (s.to) {
        first = std::min(first, s.is_half ? first_non_finite<uint16_t>(line, 0x7c00)
                                          : first_non_finite<uint32_t>(line, 0x7f800000));
      }
      line += bytes_of(s);
    }
    if (first < width_) throw NonFinitePixel({first, y});
  }

  // The number of pixels where there is none. `exponent`: its bits, all of which such a number has.
  template <class Bits>
  int first_non_finite(const uint8_t* samples, Bits exponent) const {
    const auto is_non_finite = [&](int x) {
      Bits bits;
      std::memcpy(&bits, samples + size_t(x) * sizeof(Bits), sizeof(Bits));
      return (bits & exponent) == exponent;
    };
    unsigned any = 0;
    for (int x = 0; x < width_; ++x) any |= unsigned(is_non_finite(x));
    int x = any ? 0 : width_;
    while (x < width_ && !is_non_finite(x)) ++x;
    return x;
  }

  size_t bytes_of(const Stored& channel) const {
    return size_t(width_) * (channel.is_half ? sizeof(cv::float16_t) : sizeof(float));
  }

  void decompress(int y, size_t bytes) {
    const char* packed = nullptr;
    int packed_bytes = 0;
    file_.rawPixelData(y, packed, packed_bytes);
    crc_ = crc32c(packed, size_t(packed_bytes), crc_);
    pixels_.resize(bytes);
    // What does not get smaller is stored as it is.
    if (size_t(packed_bytes) == bytes) {
      std::memcpy(pixels_.data(), packed, bytes);
      return;
    }
    differences_.resize(bytes);
    if (!unpack({reinterpret_cast<const uint8_t*>(packed), size_t(packed_bytes)})) {
      throw std::runtime_error("line " + std::to_string(y) + " cannot be decompressed");
    }
    undo_differences(bytes);
  }

  // To the size that `differences_` has.
  bool unpack(std::span<const uint8_t> packed) {
    if (file_.header().compression() == Imf::RLE_COMPRESSION) {
      return unpack_runs(packed.data(), packed.size(), &differences_);
    }
    size_t got = 0;
    return libdeflate_zlib_decompress(decompressor_.get(), packed.data(), packed.size(),
                                      differences_.data(), differences_.size(),
                                      &got) == LIBDEFLATE_SUCCESS &&
           got == differences_.size();
  }

  // Even bytes come first, then odd ones, in one row of differences whose first is from 0. Both
  // halves are summed up side by side: the second begins where the first ends.
  void undo_differences(size_t bytes) {
    const size_t odds = bytes / 2, evens = bytes - odds;
    const uint8_t* even = differences_.data();
    const uint8_t* odd = even + evens;
    const unsigned all_evens = std::accumulate(even, odd, 0u);
    RunningSum even_sum(128), odd_sum(uint8_t(all_evens - 128 * unsigned(evens - 1)));
    uint8_t* out = pixels_.data();
    size_t i = 0;
    for (; i + cv::v_uint8x16::nlanes <= odds; i += cv::v_uint8x16::nlanes) {
      cv::v_store_interleave(out + 2 * i, even_sum.next(even + i), odd_sum.next(odd + i));
    }
    for (; i < evens; ++i) {
      out[2 * i] = even_sum.next(even[i]);
      if (i < odds) out[2 * i + 1] = odd_sum.next(odd[i]);
    }
  }

  void unpack_line(const uint8_t* line, int y) {
    for (const Stored& s : stored_) {
      if (s.to) unpack_channel(s, line, y);
      line += bytes_of(s);
    }
    if (!are_interleaved_) return;
    const int* from[3];
    for (size_t c = 0; c < 3; ++c) from[c] = reinterpret_cast<const int*>(rows_[c].data());
    char* to = planes_[0].base + planes_[0].y_stride * size_t(y);
    cv::hal::merge32s(from, reinterpret_cast<int*>(to), area_.width, 3);
  }

  void unpack_channel(const Stored& channel, const uint8_t* line, int y) {
    std::vector<float>& row = rows_[size_t(channel.to - planes_.data())];
    if (channel.is_half) {
      const uint8_t* from = line + size_t(area_.x) * sizeof(cv::float16_t);
      std::memcpy(halves_.data(), from, halves_.size() * sizeof(cv::float16_t));
      cv::hal::cvt16f32f(halves_.data(), row.data(), area_.width);
    } else {
      std::memcpy(row.data(), line + size_t(area_.x) * sizeof(float), row.size() * sizeof(float));
    }
    if (are_interleaved_) return;
    char* to = channel.to->base + channel.to->y_stride * size_t(y);
    for (int x = 0; x < area_.width; ++x) {
      std::memcpy(to + channel.to->x_stride * size_t(x), &row[size_t(x)], sizeof(float));
    }
  }

  Imf::InputFile& file_;
  std::vector<Stored> stored_;
  const std::vector<ExrPlane>& planes_;
  cv::Rect area_;
  bool must_be_finite_;
  bool are_interleaved_;
  Imath::Box2i box_;
  int width_;
  size_t line_bytes_ = 0;
  uint32_t crc_ = 0;  // of the chunks so far
  std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor*)> decompressor_;
  std::vector<uint8_t> differences_, pixels_;
  std::vector<cv::float16_t> halves_;
  std::vector<std::vector<float>> rows_;  // of each plane
};

}  // namespace

NonFinitePixel::NonFinitePixel(const cv::Point& at)
    : std::runtime_error("NaN or infinity at pixel (" + std::to_string(at.x) + ", " +
                         std::to_string(at.y) + ")") {}

bool read_packed_planes(Imf::InputFile* file, const std::vector<ExrPlane>& planes,
                        const ExrPart& part) {
  const Imf::Header& header = file->header();
  const Imf::Compression compression = header.compression();
  if (compression != Imf::ZIP_COMPRESSION && compression != Imf::ZIPS_COMPRESSION &&
      compression != Imf::RLE_COMPRESSION) {
    return false;
  }
  if (header.hasTileDescription()) return false;
  std::vector<Stored> stored = stored_channels(header, planes);
  if (stored.empty()) return false;
  Chunks(file, std::move(stored), planes, part).read();
  return true;
}

}  // namespace lamella
