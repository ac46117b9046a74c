#include "export/scattering_words.h"

namespace lamella::exporting {

namespace {

using tinygltf::Value;

Value numbers(const google::protobuf::RepeatedField<double>& values) {
  Value::Array list;
  for (double v : values) list.emplace_back(v);
  return Value(list);
}

// Lists that were not fitted are left out: absent is "not known", not zero.
void add(Value::Object* words, const char* name,
         const google::protobuf::RepeatedField<double>& values) {
  if (!values.empty()) (*words)[name] = numbers(values);
}

Value region_words(const v1::Region& region) {
  Value::Object words;
  words["name"] = Value(region.name());
  add(&words, "deep_mean_free_path_mm", region.deep().ld_mm());
  add(&words, "deep_reduced_albedo", region.deep().alpha_dot());
  add(&words, "shallow_mean_free_path_mm", region.shallow().ld_mm());
  add(&words, "shallow_reduced_albedo", region.shallow().alpha());
  if (region.shallow().has_thickness_mm()) {
    words["shallow_thickness_mm"] = Value(region.shallow().thickness_mm());
  }
  add(&words, "single_scattering_amplitude", region.single().amplitude());
  if (region.specular().has_gaussian_m()) {
    words["specular_gaussian_width_rad"] = Value(region.specular().gaussian_m());
  }
  return Value(words);
}

}  // namespace

Value scattering_words(const v1::Layers& layers) {
  Value::Object words;
  words["about"] = Value(std::string(
      "Measured skin reflectance by region; lists are in the order red, green, blue. Deep: diffuse "
      "mean free path of a dipole. Shallow: a multipole slab over it. Single scattering: amplitude "
      "a (1-g)/(1+g)^2 of the Henyey-Greenstein term. Specular: a exp(-(theta/width)^2), theta the "
      "angle between the half vector and the normal."));
  Value::Array regions;
  for (const v1::Region& r : layers.regions()) regions.push_back(region_words(r));
  words["regions"] = Value(regions);
  if (layers.has_single()) {
    add(&words, "phase_function_mean_cosine_g", layers.single().g());
    if (!layers.single().g_assumes().empty()) {
      words["g_assumes"] = Value(layers.single().g_assumes());
    }
  }
  return Value(Value::Object{{"lamella_skin", Value(words)}});
}

}  // namespace lamella::exporting
