#include "export/picture_jpeg.h"

// clang-format off
#include <cstdio>  // before jpeglib.h, which uses it unseen
#include <jpeglib.h>
// clang-format on

#include <csetjmp>
#include <memory>

#include "base/error.h"
#include "io/exr.h"

namespace lamella::exporting {

namespace {

struct JpegErrors : jpeg_error_mgr {
  std::jmp_buf begin;
};

[[noreturn]] void leave_jpeg(j_common_ptr jpeg) {
  std::longjmp(static_cast<JpegErrors*>(jpeg->err)->begin, 1);
}

// Room for the worst that noise becomes, as libjpeg-turbo reckons it: three bytes a pixel of whole
// blocks, and the tables. Not touched before it is written to.
size_t most_jpeg_bytes(cv::Size size) {
  const auto padded = [](int side) { return (size_t(side) + 15) / 16 * 16; };
  return padded(size.width) * padded(size.height) * 3 + 2048;
}

class JpegWriter {
 public:
  explicit JpegWriter(cv::Size size) : room_(most_jpeg_bytes(size)), bytes_(new uchar[room_]) {
    jpeg_.err = jpeg_std_error(&errors_);
    errors_.error_exit = leave_jpeg;
    errors_.output_message = [](j_common_ptr) {};
    to_.init_destination = [](j_compress_ptr) {};
    to_.empty_output_buffer = [](j_compress_ptr) -> boolean { return FALSE; };  // an error
    to_.term_destination = [](j_compress_ptr) {};
    to_.next_output_byte = bytes_.get();
    to_.free_in_buffer = room_;
  }
  ~JpegWriter() { jpeg_destroy_compress(&jpeg_); }
  JpegWriter(const JpegWriter&) = delete;
  JpegWriter& operator=(const JpegWriter&) = delete;

  // libjpeg leaves by longjmp: nothing in here would have to be destroyed.
  bool write(const cv::Mat3b& bgr, int quality) {
    if (setjmp(errors_.begin)) return false;
    jpeg_create_compress(&jpeg_);
    jpeg_.dest = &to_;
    jpeg_.image_width = JDIMENSION(bgr.cols);
    jpeg_.image_height = JDIMENSION(bgr.rows);
    jpeg_.input_components = 3;
    jpeg_.in_color_space = JCS_EXT_BGR;
    jpeg_set_defaults(&jpeg_);  // 4:2:0 among them
    jpeg_set_quality(&jpeg_, quality, TRUE);
    jpeg_start_compress(&jpeg_, TRUE);
    for (int y = 0; y < bgr.rows; ++y) {
      JSAMPROW row = const_cast<JSAMPROW>(bgr.ptr(y));
      jpeg_write_scanlines(&jpeg_, &row, 1);
    }
    jpeg_finish_compress(&jpeg_);
    return true;
  }

  std::vector<uchar> bytes() const {
    return {bytes_.get(), bytes_.get() + (room_ - to_.free_in_buffer)};
  }

 private:
  size_t room_;
  std::unique_ptr<uchar[]> bytes_;
  jpeg_compress_struct jpeg_{};
  JpegErrors errors_{};
  jpeg_destination_mgr to_{};
};

}  // namespace

std::vector<uchar> encode_jpeg(const cv::Mat3b& bgr, int quality) {
  JpegWriter writer(bgr.size());
  if (!writer.write(bgr, quality)) {
    throw_bad_input("picture of " + size_words(bgr.size()) + " pixels", "cannot be written as JPEG",
                    "at most 65500 a side");
  }
  return writer.bytes();
}

}  // namespace lamella::exporting
