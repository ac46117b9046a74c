#include "twin/npz.h"

#include <zlib.h>

#include <bit>

#include "io/whole_file.h"

namespace lamella::twin {

namespace {

static_assert(std::endian::native == std::endian::little, "the file is little endian");

void append(std::string* to, uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) to->push_back(char(value >> (8 * i)));
}

std::string npy(const NpyArray& array) {
  std::string shape;
  for (size_t n : array.shape) shape += std::to_string(n) + ",";
  std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + shape + "), }";
  header.resize((header.size() + 11 + 63) / 64 * 64 - 11, ' ');  // 10 bytes before, newline after
  std::string bytes("\x93NUMPY\x01\x00", 8);
  append(&bytes, header.size() + 1, 2);
  bytes += header + "\n";
  bytes.append(reinterpret_cast<const char*>(array.values.data()), array.values.size() * 4);
  return bytes;
}

// What the local header of a member and its entry in the directory share.
std::string member_fields(const std::string& name, const std::string& data) {
  std::string fields;
  append(&fields, 20, 2);          // version needed
  append(&fields, 0, 2);           // flags
  append(&fields, 0, 2);           // stored
  append(&fields, 0x00210000, 4);  // 1980-01-01, so that equal content gives an equal file
  append(&fields, crc32(0, reinterpret_cast<const Bytef*>(data.data()), uInt(data.size())), 4);
  append(&fields, data.size(), 4);
  append(&fields, data.size(), 4);
  append(&fields, name.size(), 2);
  append(&fields, 0, 2);  // no extra field
  return fields;
}

}  // namespace

void write_npz(const std::filesystem::path& path, const std::vector<NpyArray>& arrays) {
  std::string file, directory;
  for (const NpyArray& array : arrays) {
    const std::string name = array.name + ".npy", data = npy(array);
    const std::string fields = member_fields(name, data);
    directory += "PK\x01\x02";
    append(&directory, 20, 2);  // version made by
    directory += fields;
    append(&directory, 0, 8);  // comment, disk, internal attributes
    append(&directory, 0, 2);
    append(&directory, file.size(), 4);
    directory += name;
    file += "PK\x03\x04" + fields + name + data;
  }
  const size_t start = file.size();
  file += directory + "PK\x05\x06";
  append(&file, 0, 4);
  append(&file, arrays.size(), 2);
  append(&file, arrays.size(), 2);
  append(&file, directory.size(), 4);
  append(&file, start, 4);
  append(&file, 0, 2);
  write_whole_text(path, file);
}

}  // namespace lamella::twin
