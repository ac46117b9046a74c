#include <fmt/format.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "io/json_tree.h"
#include "io/mesh_formats.h"

namespace lamella {

namespace {

using nlohmann::json;

constexpr float kMmPerMetre = 1000;
constexpr uint32_t kJsonChunk = 0x4e4f534a, kBinaryChunk = 0x004e4942;  // "JSON", "BIN"
constexpr uint64_t kTriangles = 4, kUint8 = 5121, kUint16 = 5123, kUint32 = 5125, kFloat = 5126;
constexpr uint64_t kWidestStride = 252;
constexpr size_t kMostVertices = 100000000;  // as primitives may name the same ones again and again

// Null where `tree` has no such thing.
const json& member(const json& tree, const char* name) {
  static const json nothing;
  const auto found = tree.is_object() ? tree.find(name) : tree.end();
  return tree.is_object() && found != tree.end() ? *found : nothing;
}

const json& item(const json& list, uint64_t index) {
  static const json nothing;
  return list.is_array() && index < list.size() ? list[size_t(index)] : nothing;
}

class GlbReader {
 public:
  GlbReader(const std::string& text, TriangleMesh* mesh) : mesh_(*mesh), text_(text) {
    require(text_.size() >= 12 && word_at(4) == 2, "is no glTF 2.0");
    tree_ = json_tree(std::string(chunk(12, kJsonChunk)));
    require(tree_.is_object(), "its JSON cannot be read");
    const size_t second = 20 + word_at(12);
    if (second < text_.size()) bytes_ = chunk(second, kBinaryChunk);
  }

  void run() {
    for (const json& node : member(tree_, "nodes")) require_in_place(node);
    for (const json& mesh : member(tree_, "meshes")) {
      for (const json& primitive : member(mesh, "primitives")) {
        if (number(primitive, "mode", kTriangles) == kTriangles) add(primitive);
      }
    }
  }

 private:
  // Elements of one kind, one every `stride` bytes.
  struct Strip {
    std::string_view bytes;
    uint64_t count = 0, stride = 0, type = 0;
  };

  void require(bool is_so, const char* otherwise, const char* remedy = "") const {
    if (!is_so) throw_bad_input(mesh_.file.string(), otherwise, remedy);
  }

  uint32_t word_at(size_t offset) const {
    uint32_t word = 0;
    std::memcpy(&word, text_.data() + offset, sizeof word);  // a GLB is little endian
    return word;
  }

  std::string_view chunk(size_t at, uint32_t type) const {
    const bool is_there =
        at + 8 <= text_.size() && word_at(at + 4) == type && word_at(at) <= text_.size() - at - 8;
    require(is_there, "ends before all that it names", "is it half copied?");
    return text_.substr(at + 8, word_at(at));
  }

  uint64_t number(const json& tree, const char* name, uint64_t otherwise) const {
    const json& value = member(tree, name);
    if (value.is_null()) return otherwise;
    require(value.is_number_unsigned() && value.get<uint64_t>() <= UINT32_MAX,
            "its JSON has something else where a count should be");
    return value.get<uint64_t>();
  }

  // A mesh that is moved by what holds it would need the whole tree of what holds what.
  void require_in_place(const json& node) const {
    if (member(node, "mesh").is_null() && member(node, "children").is_null()) return;
    const std::pair<const char*, json> in_place[] = {
        {"translation", {0, 0, 0}},
        {"rotation", {0, 0, 0, 1}},
        {"scale", {1, 1, 1}},
        {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}};
    for (const auto& [name, none] : in_place) {
      const json& value = member(node, name);
      require(value.is_null() || value == none, "a node moves, turns or scales its mesh",
              "apply that to the vertices and write the mesh again");
    }
  }

  Strip strip(uint64_t index, uint64_t components) const {
    const json& accessor = item(member(tree_, "accessors"), index);
    const json& view =
        item(member(tree_, "bufferViews"), number(accessor, "bufferView", UINT32_MAX));
    require(view.is_object() && member(accessor, "sparse").is_null() &&
                number(view, "buffer", UINT32_MAX) == 0,
            "keeps its mesh elsewhere, or compressed", "write it whole and uncompressed");
    Strip s;
    s.type = number(accessor, "componentType", 0);
    s.count = number(accessor, "count", 0);
    const uint64_t size = components * (s.type == kUint8 ? 1 : s.type == kUint16 ? 2 : 4);
    s.stride = number(view, "byteStride", size);
    const uint64_t first = number(view, "byteOffset", 0) + number(accessor, "byteOffset", 0);
    require(s.stride >= size && s.stride <= kWidestStride, "its byteStride is none");
    const uint64_t length = s.count ? s.stride * (s.count - 1) + size : 0;
    require(first <= bytes_.size() && length <= bytes_.size() - first,
            "names vertices or triangles beyond its end", "is it half copied?");
    s.bytes = bytes_.substr(first, length);
    return s;
  }

  void add(const json& primitive) {
    const Strip points = strip(number(member(primitive, "attributes"), "POSITION", UINT32_MAX), 3);
    require(points.type == kFloat, "its positions are no floats", "write them as such");
    const size_t first = mesh_.vertices_mm.size();
    require(first + points.count <= kMostVertices, "has more than 100 million vertices");
    for (uint64_t i = 0; i < points.count; ++i) {
      Vec3 metres;
      std::memcpy(metres.val, points.bytes.data() + i * points.stride, sizeof metres.val);
      mesh_.vertices_mm.push_back(metres * kMmPerMetre);
    }
    std::vector<uint64_t> corners = corners_of(primitive, points.count);
    for (size_t k = 2; k < corners.size(); k += 3) {
      std::vector<double> triangle;
      for (size_t j = k - 2; j <= k; ++j) {
        // Beyond this primitive's own vertices may be another's.
        triangle.push_back(corners[j] < points.count ? double(first + corners[j]) : -1);
      }
      add_polygon(triangle, &mesh_);
    }
  }

  std::vector<uint64_t> corners_of(const json& primitive, uint64_t points) const {
    std::vector<uint64_t> corners;
    if (member(primitive, "indices").is_null()) {
      for (uint64_t i = 0; i < points; ++i) corners.push_back(i);
      return corners;
    }
    const Strip indices = strip(number(primitive, "indices", 0), 1);
    const size_t size = indices.type == kUint8 ? 1 : indices.type == kUint16 ? 2 : 4;
    require(size < 4 || indices.type == kUint32, "its indices are no whole numbers");
    for (uint64_t i = 0; i < indices.count; ++i) {
      uint32_t corner = 0;
      std::memcpy(&corner, indices.bytes.data() + i * indices.stride, size);
      corners.push_back(corner);
    }
    return corners;
  }

  TriangleMesh& mesh_;
  std::string_view text_, bytes_;
  json tree_;
};

}  // namespace

void parse_glb(const std::string& text, TriangleMesh* mesh) { GlbReader(text, mesh).run(); }

}  // namespace lamella
