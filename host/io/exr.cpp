#include "io/exr.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfTestFile.h>

#include <array>
#include <fstream>
#include <stdexcept>

#include "base/error.h"
#include "io/exr_pack.h"
#include "io/exr_unpack.h"
#include "io/whole_file.h"

namespace lamella {

namespace {

constexpr uint32_t kExrMagic = 20000630;
constexpr uint32_t kExrDeepOrMultiPart = 0x800 | 0x1000;

cv::Size checked_size(const Imf::InputFile& file, const fs::path& path) {
  const Imath::Box2i box = file.header().dataWindow();
  const long width = long(box.max.x) - box.min.x + 1, height = long(box.max.y) - box.min.y + 1;
  if (width < 1 || height < 1 || width > kMaxImageSide || height > kMaxImageSide ||
      width * height > kMaxImagePixels) {
    throw_bad_input(
        path.string(),
        "data window of " + std::to_string(width) + "x" + std::to_string(height) + " pixels",
        "at most 32768 a side and 134 million are read");
  }
  return {int(width), int(height)};
}

void read_any_planes(Imf::InputFile& file, const std::vector<ExrPlane>& planes) {
  const Imath::Box2i box = file.header().dataWindow();
  Imf::FrameBuffer buffer;
  for (const ExrPlane& p : planes) {
    char* origin = p.base - box.min.x * ptrdiff_t(p.x_stride) - box.min.y * ptrdiff_t(p.y_stride);
    buffer.insert(p.name, Imf::Slice(Imf::FLOAT, origin, p.x_stride, p.y_stride, 1, 1, 0.0));
  }
  file.setFrameBuffer(buffer);
  file.readPixels(box.min.y, box.max.y);
}

void read_planes(Imf::InputFile& file, const std::vector<ExrPlane>& planes, cv::Size size) {
  if (read_packed_planes(&file, planes, {cv::Rect({0, 0}, size)})) return;
  read_any_planes(file, planes);
}

void require_channels(const Imf::InputFile& file, const std::vector<std::string>& names,
                      const fs::path& path) {
  for (const std::string& name : names) {
    const Imf::Channel* channel = file.header().channels().findChannel(name);
    if (!channel)
      throw_bad_input(path.string(), "no channel " + name, "write it again with that channel");
    if (channel->xSampling != 1 || channel->ySampling != 1) {
      throw_bad_input(path.string(), "channel " + name + " is subsampled",
                      "write it again with every channel at full size");
    }
  }
}

// OpenEXR would allocate for whatever a header asks before anybody can look at it.
void bound_headers() {
  static const bool once = [] {
    Imf::Header::setMaxImageSize(kMaxImageSide, kMaxImageSide);
    return true;
  }();
  (void)once;
}

// OpenEXR allocates what an attribute says is its size before it looks whether the file has that
// much, and so does not survive every damaged header: look first. What is wrong, or nothing.
std::string problem_of_header(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  const auto integer = [&] {
    std::array<unsigned char, 4> b{};
    in.read(reinterpret_cast<char*>(b.data()), 4);
    return b[0] | uint32_t(b[1]) << 8 | uint32_t(b[2]) << 16 | uint32_t(b[3]) << 24;
  };
  const uintmax_t file_bytes = fs::file_size(path);
  if (integer() != kExrMagic || !in) return "it does not begin like one";
  if (integer() & kExrDeepOrMultiPart) return "deep or of several parts";
  std::string name, type;
  while (std::getline(in, name, '\0') && !name.empty()) {
    std::getline(in, type, '\0');
    const uint32_t size = integer();
    if (!in || size > file_bytes) return "its attribute \"" + name.substr(0, 32) + "\" is cut";
    in.seekg(size, std::ios::cur);
  }
  return in ? "" : "its header is cut";
}

// OpenEXR puts its file before each of its reasons: what is left behind the last of them.
std::string reason_without(const fs::path& path, std::string reason) {
  const std::string name = '"' + path.string() + '"';
  const size_t last = reason.rfind(name);
  if (last != std::string::npos) reason.erase(0, last + name.size());
  reason.erase(0, reason.find_first_not_of(". "));
  while (reason.ends_with('.')) reason.pop_back();
  return reason.empty() ? "its pixels cannot be decoded" : reason;
}

template <class Read>
auto reading(const fs::path& path, const Read& read) {
  std::error_code failed;
  if (!fs::exists(path, failed))
    throw_bad_input(path.string(), "no such file", "is the name right?");
  if (!fs::is_regular_file(path, failed))
    throw_bad_input(path.string(), "not a file", "name an EXR image");
  try {
    bound_headers();
    const std::string problem = problem_of_header(path);
    if (!problem.empty()) throw std::runtime_error(problem);
    Imf::InputFile file(path.c_str(), 0);
    return read(file);
  } catch (const Error&) {
    throw;
  } catch (const NonFinitePixel& e) {
    throw_bad_input(path.string(), e.what(), "write it again with numbers alone");
  } catch (const std::exception& e) {
    throw_bad_input(path.string(),
                    "not a whole OpenEXR file (" + reason_without(path, e.what()) + ")",
                    "copy it again");
  }
}

std::vector<ExrPlane> planes_of(const Image3& image, const std::vector<std::string>& names) {
  std::vector<ExrPlane> planes;
  for (size_t c = 0; c < 3; ++c) {
    planes.push_back({names[c], reinterpret_cast<char*>(image.data) + c * sizeof(float),
                      sizeof(Vec3), image.step[0]});
  }
  return planes;
}

Image3 read_interleaved(const fs::path& path, const std::vector<std::string>& names) {
  return reading(path, [&](Imf::InputFile& file) {
    require_channels(file, names, path);
    Image3 image(checked_size(file, path));
    read_planes(file, planes_of(image, names), image.size());
    return image;
  });
}

void require_finite(const Image3& image) {
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      if (!is_finite(image(y, x))) throw NonFinitePixel({x, y});
    }
  }
}

ExrSurroundings nothing_around(cv::Size size) { return {whole_window(size), 0}; }

void write_interleaved(const fs::path& path, const Image3& image, const std::string& names,
                       PixelType type, const std::optional<ExrSurroundings>& around) {
  std::vector<ExrSource> sources;
  for (int c = 0; c < 3; ++c) {
    sources.push_back({std::string(1, names[c]),
                       reinterpret_cast<const char*>(image.data) + c * sizeof(float), sizeof(Vec3),
                       image.step[0]});
  }
  write_whole_text(path, packed_exr(around.value_or(nothing_around(image.size())), sources, type));
}

}  // namespace

Image3 read_exr_rgb(const fs::path& path) { return read_interleaved(path, {"R", "G", "B"}); }

Image3 read_finite_rgb(const fs::path& path, const cv::Rect& area) {
  const std::vector<std::string> names{"R", "G", "B"};
  return reading(path, [&](Imf::InputFile& file) {
    require_channels(file, names, path);
    const cv::Rect whole({0, 0}, checked_size(file, path));
    if ((area & whole) != area) throw std::runtime_error("it is smaller than what is read of it");
    Image3 image(area.size());
    if (read_packed_planes(&file, planes_of(image, names), {area, true})) return image;
    image.create(whole.size());
    read_any_planes(file, planes_of(image, names));
    require_finite(image);
    return area == whole ? image : image(area).clone();
  });
}

Image3 read_exr_xyz(const fs::path& path) { return read_interleaved(path, {"X", "Y", "Z"}); }

std::vector<Image1> read_exr(const fs::path& path, const std::vector<std::string>& channels) {
  return reading(path, [&](Imf::InputFile& file) {
    require_channels(file, channels, path);
    const cv::Size size = checked_size(file, path);
    std::vector<Image1> images;
    std::vector<ExrPlane> planes;
    for (const std::string& name : channels) {
      images.emplace_back(size);
      planes.push_back({name, reinterpret_cast<char*>(images.back().data), sizeof(float),
                        images.back().step[0]});
    }
    read_planes(file, planes, size);
    return images;
  });
}

cv::Size exr_size(const fs::path& path) {
  return reading(path, [&](Imf::InputFile& file) { return checked_size(file, path); });
}

std::string size_words(cv::Size size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

std::vector<std::string> exr_channels(const fs::path& path) {
  return reading(path, [&](Imf::InputFile& file) {
    std::vector<std::string> names;
    const Imf::ChannelList& list = file.header().channels();
    for (auto it = list.begin(); it != list.end(); ++it) names.emplace_back(it.name());
    return names;
  });
}

void write_exr(const fs::path& path, const std::vector<std::pair<std::string, Image1>>& channels,
               PixelType type, const std::optional<ExrSurroundings>& around) {
  if (channels.empty()) throw_bad_input(path.string(), "no channels to write");
  for (const auto& [name, image] : channels) {
    if (image.size() != channels.front().second.size()) {
      throw_bad_input(path.string(), "channel " + name + " has another size than the first");
    }
  }
  std::vector<ExrSource> sources;
  for (const auto& [name, image] : channels) {
    sources.push_back(
        {name, reinterpret_cast<const char*>(image.data), sizeof(float), image.step[0]});
  }
  write_whole_text(path, packed_exr(around.value_or(nothing_around(channels.front().second.size())),
                                    sources, type));
}

void write_exr_rgb(const fs::path& path, const Image3& rgb, PixelType type,
                   const std::optional<ExrSurroundings>& around) {
  write_interleaved(path, rgb, "RGB", type, around);
}

void write_exr_xyz(const fs::path& path, const Image3& xyz, PixelType type,
                   const std::optional<ExrSurroundings>& around) {
  write_interleaved(path, xyz, "XYZ", type, around);
}

}  // namespace lamella
