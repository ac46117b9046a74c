#include "apps/compare_npz.h"

#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "base/error.h"
#include "io/whole_file.h"

namespace lamella::apps {

namespace {

constexpr size_t kLargestMember = 256u << 20;

// A view of the archive's bytes that refuses to read beyond them.
class Bytes {
 public:
  Bytes(const std::string& data, const std::string& where) : data_(data), where_(where) {}

  uint32_t little(size_t at, int count) const {
    require(at, size_t(count));
    uint32_t value = 0;
    for (int i = count; i-- > 0;) value = value << 8 | uint8_t(data_[at + size_t(i)]);
    return value;
  }

  std::string part(size_t at, size_t size) const {
    require(at, size);
    return data_.substr(at, size);
  }

  [[noreturn]] void fail(const std::string& problem) const {
    throw_bad_input(where_, problem, "write it with numpy.savez");
  }

 private:
  void require(size_t at, size_t size) const {
    if (at > data_.size() || size > data_.size() - at) fail("is truncated");
  }

  const std::string& data_;
  std::string where_;
};

std::string inflated(const std::string& packed, size_t size, const Bytes& bytes) {
  std::string out(size, '\0');
  z_stream stream{};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = uInt(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = uInt(size);
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) bytes.fail("cannot be inflated");
  const int status = inflate(&stream, Z_FINISH);
  inflateEnd(&stream);
  if (status != Z_STREAM_END || stream.avail_out != 0) bytes.fail("has a damaged member");
  return out;
}

// A member's contents, by way of the directory at the archive's end.
std::string member(const std::string& data, const std::string& name, const Bytes& bytes) {
  const size_t end = data.rfind("PK\5\6");
  if (end == std::string::npos) bytes.fail("is not an .npz archive");
  size_t at = bytes.little(end + 16, 4);
  for (uint32_t i = 0, count = bytes.little(end + 10, 2); i < count; ++i) {
    const uint32_t method = bytes.little(at + 10, 2), packed = bytes.little(at + 20, 4);
    const uint32_t size = bytes.little(at + 24, 4), name_size = bytes.little(at + 28, 2);
    const uint32_t local = bytes.little(at + 42, 4);
    if (bytes.part(at + 46, name_size) == name) {
      if (size > kLargestMember) bytes.fail("has a member that is too large");
      const size_t start =
          size_t(local) + 30 + bytes.little(local + 26, 2) + bytes.little(local + 28, 2);
      const std::string contents = bytes.part(start, packed);
      return method == 0 ? contents : inflated(contents, size, bytes);
    }
    at += 46 + name_size + bytes.little(at + 30, 2) + bytes.little(at + 32, 2);
  }
  bytes.fail("has no array " + name);
}

template <class Real>
std::vector<double> numbers(const std::string& raw, size_t count) {
  std::vector<Real> typed(count);
  std::memcpy(typed.data(), raw.data(), count * sizeof(Real));
  return {typed.begin(), typed.end()};
}

std::vector<size_t> shape_of(const std::string& header, const Bytes& bytes) {
  const size_t open = header.find('(', header.find("'shape'"));
  const size_t close = header.find(')', open);
  if (open == std::string::npos || close == std::string::npos) bytes.fail("has no shape");
  std::vector<size_t> shape;
  const char* at = header.c_str() + open + 1;
  while (at < header.c_str() + close) {
    char* next = nullptr;
    const size_t extent = std::strtoull(at, &next, 10);
    if (next == at) break;
    shape.push_back(extent);
    at = next + std::strspn(next, ", ");
  }
  return shape;
}

}  // namespace

NpzArray read_npz(const fs::path& file, const std::string& name) {
  const std::string data = read_text(file);
  const Bytes bytes(data, file.string());
  const std::string npy = member(data, name + ".npy", bytes);
  const Bytes array_bytes(npy, file.string() + ": " + name);
  if (npy.compare(0, 6, "\x93NUMPY") != 0) array_bytes.fail("is not a NumPy array");
  const bool first_version = npy[6] == 1;
  const size_t start = first_version ? 10 : 12;
  const size_t header_size = array_bytes.little(8, first_version ? 2 : 4);
  const std::string header = array_bytes.part(start, header_size);
  NpzArray array{shape_of(header, array_bytes), {}};
  size_t count = 1;
  for (size_t extent : array.shape) {
    if (extent < 1 || extent > kLargestMember / count) array_bytes.fail("has a shape of no array");
    count *= extent;
  }
  const bool wide = header.find("<f8") != std::string::npos;
  if (!wide && header.find("<f4") == std::string::npos) array_bytes.fail("is not of floats");
  if (header.find("'fortran_order': True") != std::string::npos) {
    array_bytes.fail("has its first index fastest");
  }
  const std::string raw = array_bytes.part(start + header_size, count * (wide ? 8 : 4));
  array.values = wide ? numbers<double>(raw, count) : numbers<float>(raw, count);
  return array;
}

}  // namespace lamella::apps
