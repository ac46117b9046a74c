// The measured reflectance that a metallic-roughness material cannot say, in plain words and units,
// for the engines that have a skin shader.
#pragma once

#include <tiny_gltf.h>

#include "layers.pb.h"

namespace lamella::exporting {

tinygltf::Value scattering_words(const v1::Layers& layers);

}  // namespace lamella::exporting
