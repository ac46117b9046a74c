#include "io/mesh_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>

#include "base/error.h"
#include "io/mesh_formats.h"
#include "io/whole_file.h"

namespace lamella {

namespace {

constexpr size_t kLargestMesh = size_t(2) << 30;  // bytes of its file
constexpr const char* kBlanks = " \t\r\v\f\n";

void require_mesh(const TriangleMesh& mesh) {
  const std::string where = mesh.file.string();
  if (mesh.triangles.empty()) {
    throw_bad_input(where, "no triangle in it", "a mesh is a .ply, .obj or .glb file");
  }
  for (size_t i = 0; i < mesh.vertices_mm.size(); ++i) {
    if (is_finite(mesh.vertices_mm[i])) continue;
    throw_bad_input(where, fmt::format("vertex {} is NaN or infinite", i),
                    "remove it and what it is a corner of");
  }
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const int corner : mesh.triangles[i].val) {
      if (corner >= 0 && size_t(corner) < mesh.vertices_mm.size()) continue;
      throw_bad_input(where,
                      fmt::format("triangle {} has a corner that is none of the {} vertices", i,
                                  mesh.vertices_mm.size()),
                      "write the mesh again");
    }
  }
}

int index_from(double number) {
  return number >= 0 && number <= std::numeric_limits<int>::max() ? int(number) : -1;
}

}  // namespace

void add_polygon(const std::vector<double>& corners, TriangleMesh* mesh) {
  for (size_t k = 2; k < corners.size(); ++k) {
    mesh->triangles.emplace_back(index_from(corners[0]), index_from(corners[k - 1]),
                                 index_from(corners[k]));
  }
}

std::string_view take_line(std::string_view* text) {
  const std::string_view line = text->substr(0, text->find('\n'));
  text->remove_prefix(std::min(text->size(), line.size() + 1));
  return line;
}

std::string_view take_word(std::string_view* text) {
  text->remove_prefix(std::min(text->size(), text->find_first_not_of(kBlanks)));
  const std::string_view word = text->substr(0, text->find_first_of(kBlanks));
  text->remove_prefix(word.size());
  return word;
}

double number_from(std::string_view word, const std::string& where) {
  const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
  double number = 0;
  const auto [end, failed] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (failed == std::errc() && end == digits.data() + digits.size()) return number;
  throw_bad_input(where, fmt::format("\"{}\" is no number", word.substr(0, 40)),
                  "write the mesh again");
}

TriangleMesh read_mesh(const std::filesystem::path& path) {
  std::error_code failed;
  if (!fs::exists(path, failed))
    throw_bad_input(path.string(), "no such file", "is the name right?");
  if (!fs::is_regular_file(path, failed))
    throw_bad_input(path.string(), "is not a file", "name a .ply, .obj or .glb");
  const std::string text = read_text(path, kLargestMesh);
  TriangleMesh mesh{path, {}, {}};
  if (text.starts_with("glTF")) {
    parse_glb(text, &mesh);
  } else if (text.starts_with("ply")) {
    parse_ply(text, &mesh);
  } else {
    parse_obj(text, &mesh);
  }
  require_mesh(mesh);
  return mesh;
}

}  // namespace lamella
