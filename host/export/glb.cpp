#include "export/glb.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cstring>
#include <sstream>

#include "base/error.h"
#include "export/scattering_words.h"

namespace lamella::exporting {

namespace {

constexpr double kIorOfSkin = 1.38;

// Appends bytes at a multiple of four, as accessors and the container want; the index of the view.
int add_view(tinygltf::Model* model, const void* bytes, size_t count, int target) {
  std::vector<unsigned char>& data = model->buffers[0].data;
  data.resize((data.size() + 3) / 4 * 4);
  tinygltf::BufferView view;
  view.buffer = 0;
  view.byteOffset = data.size();
  view.byteLength = count;
  view.target = target;
  data.resize(data.size() + count);
  std::memcpy(data.data() + view.byteOffset, bytes, count);
  model->bufferViews.push_back(view);
  return int(model->bufferViews.size()) - 1;
}

// `value(vertex)` is a cv::Vec of `Floats` floats.
template <int Floats, class Value>
int add_attribute(tinygltf::Model* model, const EngineMesh& mesh, const Value& value) {
  std::vector<cv::Vec<float, Floats>> packed(mesh.vertices.size());
  std::transform(mesh.vertices.begin(), mesh.vertices.end(), packed.begin(), value);
  tinygltf::Accessor accessor;
  accessor.bufferView = add_view(model, packed.data(), packed.size() * sizeof(packed[0]),
                                 TINYGLTF_TARGET_ARRAY_BUFFER);
  accessor.componentType = TINYGLTF_COMPONENT_TYPE_FLOAT;
  accessor.count = packed.size();
  accessor.type = Floats;  // TINYGLTF_TYPE_VEC2 is 2, _VEC3 is 3, _VEC4 is 4
  for (int k = 0; k < Floats; ++k) {
    const auto less = [k](const auto& a, const auto& b) { return a[k] < b[k]; };
    const auto [low, high] = std::minmax_element(packed.begin(), packed.end(), less);
    accessor.minValues.push_back((*low)[k]);
    accessor.maxValues.push_back((*high)[k]);
  }
  model->accessors.push_back(accessor);
  return int(model->accessors.size()) - 1;
}

template <class Index>
int add_indices(tinygltf::Model* model, const EngineMesh& mesh, int component_type) {
  const std::vector<Index> packed(mesh.indices.begin(), mesh.indices.end());
  tinygltf::Accessor accessor;
  accessor.bufferView = add_view(model, packed.data(), packed.size() * sizeof(Index),
                                 TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
  accessor.componentType = component_type;
  accessor.count = packed.size();
  accessor.type = TINYGLTF_TYPE_SCALAR;
  model->accessors.push_back(accessor);
  return int(model->accessors.size()) - 1;
}

int add_texture(tinygltf::Model* model, const EncodedImage& image) {
  tinygltf::Image entry;
  entry.name = image.name;
  entry.mimeType = image.mime_type;
  entry.bufferView = add_view(model, image.bytes.data(), image.bytes.size(), 0);
  model->images.push_back(entry);
  tinygltf::Texture texture;
  texture.source = int(model->images.size()) - 1;
  texture.sampler = 0;
  model->textures.push_back(texture);
  return int(model->textures.size()) - 1;
}

void add_sampler(tinygltf::Model* model) {
  tinygltf::Sampler sampler;
  sampler.magFilter = TINYGLTF_TEXTURE_FILTER_LINEAR;
  sampler.minFilter = TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_LINEAR;
  sampler.wrapS = sampler.wrapT = TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
  model->samplers.push_back(sampler);
}

tinygltf::Value texture_reference(int index) {
  return tinygltf::Value(tinygltf::Value::Object{{"index", tinygltf::Value(index)}});
}

tinygltf::Material skin(tinygltf::Model* model, const GlbContent& content) {
  using tinygltf::Value;
  const FaceTextures& t = content.textures;
  tinygltf::Material material;
  material.name = "skin";
  material.doubleSided = true;  // a face is an open shell
  material.pbrMetallicRoughness.baseColorTexture.index = add_texture(model, t.base_colour);
  material.pbrMetallicRoughness.metallicRoughnessTexture.index = add_texture(model, t.roughness);
  material.pbrMetallicRoughness.metallicFactor = 0.0;
  material.normalTexture.index = add_texture(model, t.normal);
  const double ior = content.layers.has_ior() ? content.layers.ior() : kIorOfSkin;
  material.extensions["KHR_materials_ior"] = Value(Value::Object{{"ior", Value(ior)}});
  const Value factor(double(t.specular_colour_factor));
  material.extensions["KHR_materials_specular"] =
      Value(Value::Object{{"specularTexture", texture_reference(add_texture(model, t.specular))},
                          {"specularColorFactor", Value(Value::Array{factor, factor, factor})}});
  material.extras = scattering_words(content.layers);
  return material;
}

tinygltf::Primitive triangles(tinygltf::Model* model, const EngineMesh& mesh) {
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.material = 0;
  auto& attributes = primitive.attributes;
  attributes["POSITION"] =
      add_attribute<3>(model, mesh, [](const EngineVertex& v) { return v.position_m; });
  attributes["NORMAL"] =
      add_attribute<3>(model, mesh, [](const EngineVertex& v) { return v.normal; });
  attributes["TANGENT"] =
      add_attribute<4>(model, mesh, [](const EngineVertex& v) { return v.tangent; });
  attributes["TEXCOORD_0"] =
      add_attribute<2>(model, mesh, [](const EngineVertex& v) { return v.uv; });
  // 65535 itself is the restart index of many graphics interfaces.
  primitive.indices =
      mesh.vertices.size() < 65535
          ? add_indices<uint16_t>(model, mesh, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT)
          : add_indices<uint32_t>(model, mesh, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT);
  return primitive;
}

tinygltf::Model model_of(const GlbContent& content) {
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "Lamella 0.1";
  model.buffers.emplace_back();
  add_sampler(&model);
  tinygltf::Mesh mesh;
  mesh.name = "face";
  mesh.primitives.push_back(triangles(&model, content.mesh));
  model.meshes.push_back(mesh);
  model.materials.push_back(skin(&model, content));
  model.extensionsUsed = {"KHR_materials_ior", "KHR_materials_specular"};
  tinygltf::Node node;
  node.name = content.subject.empty() ? "face" : content.subject;
  node.mesh = 0;
  model.nodes.push_back(node);
  tinygltf::Scene scene;
  scene.nodes = {0};
  model.scenes.push_back(scene);
  model.defaultScene = 0;
  std::vector<unsigned char>& data = model.buffers[0].data;
  data.resize((data.size() + 3) / 4 * 4);
  return model;
}

}  // namespace

void write_glb(const fs::path& path, const GlbContent& content) {
  const tinygltf::Model model = model_of(content);
  // Not tinygltf's own writing of files: it does not look whether the disk took the last of it.
  constexpr bool kPretty = false, kBinary = true;
  std::ostringstream out;
  tinygltf::TinyGLTF().WriteGltfSceneToStream(&model, out, kPretty, kBinary);
  write_whole_text(path, out.str());
}

}  // namespace lamella::exporting
