#include <fmt/format.h>

#include "base/error.h"
#include "io/mesh_formats.h"

namespace lamella {

namespace {

// "7", "7/1", "7/1/3" or "7//3": the first counts from 1, or, negative, back from the last vertex.
double obj_corner(std::string_view word, size_t vertices, const std::string& where) {
  const double number = number_from(word.substr(0, word.find('/')), where);
  return number < 0 ? double(vertices) + number : number - 1;
}

Vec3 obj_vertex(std::string_view line, const std::string& where) {
  Vec3 vertex;
  for (float& x : vertex.val) x = float(number_from(take_word(&line), where));
  return vertex;
}

}  // namespace

void parse_obj(const std::string& text, TriangleMesh* mesh) {
  std::string_view rest = text;
  std::vector<double> corners;
  for (size_t number = 1; !rest.empty(); ++number) {
    std::string_view line = take_line(&rest);
    const std::string_view keyword = take_word(&line);
    if (keyword != "v" && keyword != "f") continue;
    const std::string where = fmt::format("{}: line {}", mesh->file.string(), number);
    if (keyword == "v") {
      mesh->vertices_mm.push_back(obj_vertex(line, where));
      continue;
    }
    corners.clear();
    for (auto word = take_word(&line); !word.empty(); word = take_word(&line)) {
      corners.push_back(obj_corner(word, mesh->vertices_mm.size(), where));
    }
    add_polygon(corners, mesh);
  }
}

}  // namespace lamella
