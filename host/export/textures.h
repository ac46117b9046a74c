// The maps of a fit as the textures of a metallic-roughness material.
#pragma once

#include <string>

#include "export/face_mesh.h"
#include "layers.pb.h"

namespace lamella::exporting {

struct EncodedImage {
  std::string name;
  std::string mime_type;
  std::vector<uchar> bytes;
};

struct FaceTextures {
  EncodedImage base_colour;          // sRGB of the total albedo, JPEG
  EncodedImage normal;               // tangent space of the mesh, +Y up, PNG
  EncodedImage roughness;            // G: perceptual roughness, linear; B: metallic, 0; PNG
  EncodedImage specular;             // A: strength, linear; PNG
  float specular_colour_factor = 1;  // what the strength, at most 1, is of c / (1/4)
};

// Textures of the outline's box, no side over `side_px`.
FaceTextures face_textures(const FaceMaps& face, const v1::Layers& layers, const EngineMesh& mesh,
                           int side_px);

// Width alpha of the GGX distribution nearest to a tabulated lobe (least squares over the solid
// angle, both normalised alike). Without a table, from its Gaussian width.
float ggx_alpha(const v1::SpecularLobe& lobe);

// IEC 61966-2-1, 0 to 1.
float srgb_from_linear(float linear);

}  // namespace lamella::exporting
