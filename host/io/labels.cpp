#include "io/labels.h"

#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "base/error.h"
#include "io/whole_file.h"

namespace lamella {

namespace {

constexpr size_t kMaxPngBytes = 64u << 20;

// OpenCV decodes a truncated PNG into what there is of it and says so on standard error only: look
// for the chunk that ends every whole one, and at the size before anything is allocated.
void require_whole_png(const std::string& bytes, const fs::path& file) {
  const std::string start("\x89PNG\r\n\x1a\n", 8), end("IEND\xae\x42\x60\x82", 8);
  if (!bytes.starts_with(start))
    throw_bad_input(file.string(), "not a PNG image", "save it as one");
  if (bytes.size() < 45 || !bytes.ends_with(end)) {
    throw_bad_input(file.string(), "not a whole PNG image", "copy it again");
  }
  const auto side = [&](size_t at) {
    uint32_t value = 0;
    for (size_t i = 0; i < 4; ++i) value = value << 8 | uint8_t(bytes[at + i]);
    return value;
  };
  const uint64_t width = side(16), height = side(20);
  if (width * height > uint64_t(kMaxImagePixels)) {
    throw_bad_input(file.string(), "more than 134 million pixels");
  }
  constexpr char kDepth = 8, kGrey = 0;
  if (bytes[24] != kDepth || bytes[25] != kGrey) {
    throw_bad_input(file.string(), "not an 8-bit grey label image",
                    "save it as 8-bit greyscale, without alpha or palette");
  }
}

}  // namespace

Labels read_labels(const fs::path& file) {
  const std::string bytes = read_text(file, kMaxPngBytes);
  require_whole_png(bytes, file);
  cv::Mat image;
  try {
    const cv::Mat1b packed(1, int(bytes.size()),
                           reinterpret_cast<uchar*>(const_cast<char*>(bytes.data())));
    image = cv::imdecode(packed, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    image.release();
  }
  if (image.empty()) throw_bad_input(file.string(), "damaged PNG image", "copy it again");
  if (image.type() != CV_8UC1)
    throw_bad_input(file.string(), "not an 8-bit grey label image",
                    "save it as 8-bit greyscale, without alpha or palette");
  return image;
}

void write_labels(const fs::path& file, const Labels& labels) {
  std::vector<uchar> png;
  cv::imencode(".png", labels, png);
  write_whole_text(file, std::string(png.begin(), png.end()));
}

}  // namespace lamella
