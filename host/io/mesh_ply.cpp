#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <optional>

#include "base/error.h"
#include "io/mesh_formats.h"

namespace lamella {

namespace {

enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

// Each type has two names, old and new.
constexpr std::array<std::pair<const char*, PlyType>, 16> kPlyTypes{
    {{"char", PlyType::kInt8},
     {"int8", PlyType::kInt8},
     {"uchar", PlyType::kUint8},
     {"uint8", PlyType::kUint8},
     {"short", PlyType::kInt16},
     {"int16", PlyType::kInt16},
     {"ushort", PlyType::kUint16},
     {"uint16", PlyType::kUint16},
     {"int", PlyType::kInt32},
     {"int32", PlyType::kInt32},
     {"uint", PlyType::kUint32},
     {"uint32", PlyType::kUint32},
     {"float", PlyType::kFloat},
     {"float32", PlyType::kFloat},
     {"double", PlyType::kDouble},
     {"float64", PlyType::kDouble}}};

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat;
  std::optional<PlyType> count_type;  // of a list
};

struct PlyElement {
  std::string name;
  double count = 0;
  std::vector<PlyProperty> properties;

  bool has(const char* property, bool is_list) const {
    return std::any_of(properties.begin(), properties.end(), [&](const PlyProperty& p) {
      return p.name == property && p.count_type.has_value() == is_list;
    });
  }
};

enum class PlyEncoding { kAscii, kLittleEndian, kBigEndian };

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<PlyElement> elements;
};

PlyType ply_type_from(std::string_view name, const std::string& where) {
  for (const auto& [known, type] : kPlyTypes) {
    if (name == known) return type;
  }
  throw_bad_input(where, fmt::format("header: no type \"{}\"", name.substr(0, 40)),
                  "one of char to double, or int8 to float64");
}

PlyEncoding ply_encoding_from(std::string_view name, const std::string& where) {
  if (name == "ascii") return PlyEncoding::kAscii;
  if (name == "binary_little_endian") return PlyEncoding::kLittleEndian;
  if (name == "binary_big_endian") return PlyEncoding::kBigEndian;
  throw_bad_input(where, fmt::format("header: no format \"{}\"", name.substr(0, 40)),
                  "ascii, binary_little_endian or binary_big_endian");
}

PlyProperty ply_property(std::string_view line, const std::string& where) {
  PlyProperty property;
  std::string_view type = take_word(&line);
  if (type == "list") {
    property.count_type = ply_type_from(take_word(&line), where);
    type = take_word(&line);
  }
  property.type = ply_type_from(type, where);
  property.name = take_word(&line);
  return property;
}

// Takes the header off `rest`.
PlyHeader ply_header(std::string_view* rest, const std::string& where) {
  PlyHeader header;
  while (!rest->empty()) {
    std::string_view line = take_line(rest);
    const std::string_view keyword = take_word(&line);
    if (keyword == "end_header") return header;
    if (keyword == "format") header.encoding = ply_encoding_from(take_word(&line), where);
    if (keyword == "element") {
      const std::string name(take_word(&line));
      header.elements.push_back({name, number_from(take_word(&line), where), {}});
    }
    if (keyword == "property") {
      if (header.elements.empty())
        throw_bad_input(where, "header: a property of no element", "write the mesh again");
      header.elements.back().properties.push_back(ply_property(line, where));
    }
  }
  throw_bad_input(where, "header: no end_header", "is it a PLY file, and whole?");
}

template <class Number>
double number_in(std::string bytes, bool is_swapped) {
  if (is_swapped) std::reverse(bytes.begin(), bytes.end());
  Number number;
  std::memcpy(&number, bytes.data(), sizeof number);
  return double(number);
}

// What follows the header: numbers, one after the other.
class PlyNumbers {
 public:
  PlyNumbers(std::string_view rest, PlyEncoding encoding, const std::string& where)
      : rest_(rest), encoding_(encoding), where_(where) {}

  double next(PlyType type) {
    if (encoding_ == PlyEncoding::kAscii) {
      const std::string_view word = take_word(&rest_);
      if (word.empty()) end();
      return number_from(word, where_);
    }
    switch (type) {
      case PlyType::kInt8:
        return binary<int8_t>();
      case PlyType::kUint8:
        return binary<uint8_t>();
      case PlyType::kInt16:
        return binary<int16_t>();
      case PlyType::kUint16:
        return binary<uint16_t>();
      case PlyType::kInt32:
        return binary<int32_t>();
      case PlyType::kUint32:
        return binary<uint32_t>();
      case PlyType::kFloat:
        return binary<float>();
      case PlyType::kDouble:
        return binary<double>();
    }
    return 0;
  }

 private:
  template <class Number>
  double binary() {
    if (rest_.size() < sizeof(Number)) end();
    const std::string bytes(rest_.substr(0, sizeof(Number)));
    rest_.remove_prefix(sizeof(Number));
    const bool is_little = std::endian::native == std::endian::little;
    return number_in<Number>(bytes, is_little != (encoding_ == PlyEncoding::kLittleEndian));
  }

  [[noreturn]] void end() const {
    throw_bad_input(where_, "ends before all that its header names", "is it half copied?");
  }

  std::string_view rest_;
  PlyEncoding encoding_;
  const std::string& where_;
};

Vec3 ply_vertex(const PlyElement& element, PlyNumbers* numbers) {
  Vec3 vertex(kNaN, kNaN, kNaN);
  for (const PlyProperty& p : element.properties) {
    const double value = numbers->next(p.count_type.value_or(p.type));
    if (p.count_type) {
      for (double k = 0; k < value; ++k) numbers->next(p.type);
    } else if (p.name.size() == 1 && p.name[0] >= 'x' && p.name[0] <= 'z') {
      vertex[p.name[0] - 'x'] = float(value);
    }
  }
  return vertex;
}

bool names_corners(const PlyProperty& p) {
  return p.count_type && (p.name == "vertex_indices" || p.name == "vertex_index");
}

void ply_face(const PlyElement& element, PlyNumbers* numbers, std::vector<double>* corners) {
  corners->clear();
  for (const PlyProperty& p : element.properties) {
    const double count = p.count_type ? numbers->next(*p.count_type) : 1;
    for (double k = 0; k < count; ++k) {
      const double value = numbers->next(p.type);
      if (names_corners(p)) corners->push_back(value);
    }
  }
}

}  // namespace

void parse_ply(const std::string& text, TriangleMesh* mesh) {
  const std::string where = mesh->file.string();
  std::string_view rest = text;
  const PlyHeader header = ply_header(&rest, where);
  PlyNumbers numbers(rest, header.encoding, where);
  std::vector<double> corners;
  for (const PlyElement& element : header.elements) {
    if (element.properties.empty()) continue;  // takes no room, and may say any count
    const bool is_vertex = element.name == "vertex";
    if (is_vertex &&
        !(element.has("x", false) && element.has("y", false) && element.has("z", false))) {
      throw_bad_input(where, "header: a vertex without x, y and z", "write the mesh again");
    }
    for (double i = 0; i < element.count; ++i) {
      if (is_vertex) {
        mesh->vertices_mm.push_back(ply_vertex(element, &numbers));
        continue;
      }
      ply_face(element, &numbers, &corners);
      if (element.name == "face") add_polygon(corners, mesh);
    }
  }
}

}  // namespace lamella
