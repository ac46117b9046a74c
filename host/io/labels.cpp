#include "io/labels.h"

#include "base/error.h"
#include "io/picture_png.h"
#include "io/whole_file.h"

namespace lamella {

Labels read_labels(const fs::path& file) {
  const std::string bytes = read_text(file);
  const PngHeader header = png_header(bytes, file.string());
  if (header.bits != 8 || !header.is_grey) {
    throw_bad_input(file.string(), "not an 8-bit grey label image",
                    "save it as 8-bit greyscale, without alpha or palette");
  }
  return decode_png(bytes, file.string());
}

void write_labels(const fs::path& file, const Labels& labels) {
  write_whole_text(file, encode_png(labels));
}

}  // namespace lamella
