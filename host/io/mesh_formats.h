// The formats of `read_mesh`, each from the whole text of a file. What a format says is looked at
// here; whether its triangles have vertices, and those numbers, by `read_mesh` for all of them.
#pragma once

#include <string>
#include <string_view>

#include "io/mesh_file.h"

namespace lamella {

void parse_obj(const std::string& text, TriangleMesh* mesh);
void parse_ply(const std::string& text, TriangleMesh* mesh);
void parse_glb(const std::string& text, TriangleMesh* mesh);

// Corners may be any numbers: one that cannot be an index stays one that is not.
void add_polygon(const std::vector<double>& corners, TriangleMesh* mesh);

// Takes what stands before the next line's end, or blank, off `text`.
std::string_view take_line(std::string_view* text);
std::string_view take_word(std::string_view* text);

// Throws Error that names `where` and the word, where it is no number.
double number_from(std::string_view word, const std::string& where);

}  // namespace lamella
