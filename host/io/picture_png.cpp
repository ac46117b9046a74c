#include "io/picture_png.h"

#include <png.h>

#include <cstring>
#include <new>

#include "base/error.h"
#include "io/exr.h"

namespace lamella {

namespace {

// libpng leaves by longjmp, so that no function with a setjmp, or between it and libpng, has
// anything that would have to be destroyed: whoever owns something calls those.

[[noreturn]] void leave_png(png_structp png, png_const_charp) { png_longjmp(png, 1); }

void ignore_png_warning(png_structp, png_const_charp) {}

// ---- reading ----

struct PngSource {
  const char* at;
  size_t left;
};

void take_png_bytes(png_structp png, png_bytep to, size_t count) {
  auto* source = static_cast<PngSource*>(png_get_io_ptr(png));
  if (count > source->left) png_error(png, "cut");
  std::memcpy(to, source->at, count);
  source->at += count;
  source->left -= count;
}

class PngReader {
 public:
  explicit PngReader(const std::string& bytes)
      : source_{bytes.data(), bytes.size()},
        png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, leave_png, ignore_png_warning)),
        info_(png_ ? png_create_info_struct(png_) : nullptr) {
    if (!info_) {
      png_destroy_read_struct(&png_, nullptr, nullptr);
      throw std::bad_alloc();
    }
    png_set_read_fn(png_, &source_, take_png_bytes);
  }
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  bool read_header() {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_set_user_limits(png_, kMaxImageSide, kMaxImageSide);
    png_read_info(png_, info_);
    ask_for_plain_channels();
    passes_ = png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    return true;
  }

  // After read_header().
  cv::Size size() const {
    return {int(png_get_image_width(png_, info_)), int(png_get_image_height(png_, info_))};
  }
  int type() const {
    return CV_MAKETYPE(png_get_bit_depth(png_, info_) == 16 ? CV_16U : CV_8U,
                       png_get_channels(png_, info_));
  }

  // Into a picture of that size and type.
  bool read_pixels(uchar* pixels, size_t row_bytes) {
    if (setjmp(png_jmpbuf(png_))) return false;
    const size_t rows = png_get_image_height(png_, info_);
    for (int pass = 0; pass < passes_; ++pass) {
      for (size_t y = 0; y < rows; ++y) png_read_row(png_, pixels + y * row_bytes, nullptr);
    }
    png_read_end(png_, nullptr);
    return true;
  }

 private:
  void ask_for_plain_channels() {
    const int type = png_get_color_type(png_, info_);
    if (type == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png_);
    if (type == PNG_COLOR_TYPE_GRAY) png_set_expand_gray_1_2_4_to_8(png_);
    if (type & PNG_COLOR_MASK_COLOR) png_set_bgr(png_);
    png_set_strip_alpha(png_);
    png_set_swap(png_);  // 16 bits are stored with the high byte first
  }

  PngSource source_;
  png_structp png_;
  png_infop info_;
  int passes_ = 1;
};

// ---- writing ----

bool has_appended(std::string* bytes, const png_byte* more, size_t count) noexcept {
  try {
    bytes->append(reinterpret_cast<const char*>(more), count);
    return true;
  } catch (const std::bad_alloc&) {
    return false;
  }
}

void give_png_bytes(png_structp png, png_bytep more, size_t count) {
  auto* bytes = static_cast<std::string*>(png_get_io_ptr(png));
  if (!has_appended(bytes, more, count)) png_error(png, "out of memory");
}

class PngWriter {
 public:
  explicit PngWriter(std::string* bytes)
      : png_(
            png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, leave_png, ignore_png_warning)),
        info_(png_ ? png_create_info_struct(png_) : nullptr) {
    if (!info_) {
      png_destroy_write_struct(&png_, nullptr);
      throw std::bad_alloc();
    }
    png_set_write_fn(png_, bytes, give_png_bytes, nullptr);
  }
  ~PngWriter() { png_destroy_write_struct(&png_, &info_); }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;

  bool write(const cv::Mat& picture, PngEffort effort) {
    if (setjmp(png_jmpbuf(png_))) return false;
    const int channels = picture.channels();
    png_set_IHDR(png_, info_, png_uint_32(picture.cols), png_uint_32(picture.rows), 8,
                 channels == 1   ? PNG_COLOR_TYPE_GRAY
                 : channels == 3 ? PNG_COLOR_TYPE_RGB
                                 : PNG_COLOR_TYPE_RGB_ALPHA,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    set_effort(effort, channels == 1);
    png_write_info(png_, info_);
    png_set_bgr(png_);
    for (int y = 0; y < picture.rows; ++y) png_write_row(png_, picture.ptr(y));
    png_write_end(png_, nullptr);
    return true;
  }

 private:
  // Labels and masks are mostly as the row above; of photographs Paeth guesses best. What is left
  // is runs: to look for more takes longer and, at zlib's level 1, finds less.
  void set_effort(PngEffort effort, bool is_grey) {
    if (effort == PngEffort::kSmall) {
      png_set_compression_level(png_, 9);
      return;
    }
    constexpr int kRunsAlone = 3;  // Z_RLE
    png_set_filter(png_, PNG_FILTER_TYPE_BASE, is_grey ? PNG_FILTER_UP : PNG_FILTER_PAETH);
    png_set_compression_level(png_, 1);
    png_set_compression_strategy(png_, kRunsAlone);
  }

  png_structp png_;
  png_infop info_;
};

// Four bytes, the high one first.
uint32_t png_number(const std::string& bytes, size_t at) {
  uint32_t value = 0;
  for (size_t i = 0; i < 4; ++i) value = value << 8 | uint8_t(bytes[at + i]);
  return value;
}

[[noreturn]] void refuse_damaged_png(const std::string& where) {
  throw_bad_input(where, "damaged PNG image", "copy it again");
}

}  // namespace

// Every whole file ends with the same chunk, and none is shorter than its header and that.
PngHeader png_header(const std::string& bytes, const std::string& where) {
  const std::string start("\x89PNG\r\n\x1a\n", 8), end("IEND\xae\x42\x60\x82", 8);
  if (!bytes.starts_with(start)) throw_bad_input(where, "not a PNG image", "save it as one");
  if (bytes.size() < 45 || !bytes.ends_with(end)) {
    throw_bad_input(where, "not a whole PNG image", "copy it again");
  }
  if (bytes.compare(12, 4, "IHDR") != 0) refuse_damaged_png(where);
  const uint64_t width = png_number(bytes, 16), height = png_number(bytes, 20);
  if (width > kMaxImageSide || height > kMaxImageSide || width * height > kMaxImagePixels) {
    throw_bad_input(where, std::to_string(width) + "x" + std::to_string(height) + " pixels",
                    "at most 32768 a side and 134 million are read");
  }
  return {{int(width), int(height)}, bytes[24], bytes[25] == PNG_COLOR_TYPE_GRAY};
}

cv::Mat decode_png(const std::string& bytes, const std::string& where) {
  png_header(bytes, where);
  PngReader reader(bytes);
  if (!reader.read_header()) refuse_damaged_png(where);
  cv::Mat picture(reader.size(), reader.type());
  if (!reader.read_pixels(picture.data, picture.step)) refuse_damaged_png(where);
  return picture;
}

std::string encode_png(const cv::Mat& picture, PngEffort effort) {
  CV_Assert(picture.depth() == CV_8U && picture.channels() != 2 && picture.channels() <= 4);
  std::string bytes;
  PngWriter writer(&bytes);
  if (!writer.write(picture, effort)) {
    throw_bad_input("picture of " + size_words(picture.size()) + " pixels",
                    "cannot be written as PNG");
  }
  return bytes;
}

}  // namespace lamella
