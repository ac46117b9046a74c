#include "io/mesh_file.h"

#include <algorithm>

#include "io/expect_error.h"
#include "io/fake_session.h"
#include "io/mesh_writer.h"

namespace lamella {
namespace {

using testing::complaint;
using testing::glb_of;
using testing::names;

const std::vector<Vec3> kCorners{{0, 0, 0}, {10, 0, 0}, {10, 20, 0}, {0, 20, 0.5f}};
const std::vector<cv::Vec3i> kHalves{{0, 1, 2}, {0, 2, 3}};

class MeshFile : public ::testing::Test {
 protected:
  fs::path file() const { return scratch_.path() / "face"; }

  TriangleMesh read(const std::string& text) const {
    write_whole_text(file(), text);
    return read_mesh(file());
  }

  std::string refusal(const std::string& text) const {
    return complaint([&] { read(text); });
  }

  void expect_square(const TriangleMesh& mesh) const {
    EXPECT_EQ(mesh.file, file());
    EXPECT_EQ(mesh.vertices_mm, kCorners);
    EXPECT_EQ(mesh.triangles, kHalves);
  }

  testing::ScratchFolder scratch_;
};

// The square as a GLB of the house's own layout: metres, 16 bit indices.
std::string glb_square(const std::string& node) {
  std::ostringstream binary;
  for (const Vec3& v : kCorners) {
    for (const float x : v.val) testing::put_binary(binary, x / 1000);
  }
  for (const cv::Vec3i& triangle : kHalves) {
    for (const int corner : triangle.val) testing::put_binary(binary, uint16_t(corner));
  }
  return glb_of(R"({"asset":{"version":"2.0"},"nodes":[)" + node + R"(],"meshes":[{"primitives":[
      {"attributes":{"POSITION":0},"indices":1}]}],"buffers":[{"byteLength":60}],"accessors":[
      {"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},
      {"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}],"bufferViews":[
      {"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":12}]})",
                binary.str());
}

std::string with(std::string text, const std::string& old, const std::string& now) {
  return text.replace(text.find(old), old.size(), now);
}

TEST_F(MeshFile, ReadsAnObjWithAQuadTexturesAndLinesOfAnotherSystem) {
  expect_square(
      read("# face\r\nmtllib a.mtl\r\nv 0 0 0\r\nv 10 0 0\r\nvt 0 0\r\nvn 0 0 1\r\n"
           "v +10 2e1 0 0.5 0.5 0.5\r\nv 0 20 .5\r\nusemtl skin\r\nf 1/1/1 2//1 3 4/1\r\n"));
}

TEST_F(MeshFile, ReadsAnObjThatCountsBackFromItsLastVertex) {
  expect_square(read("v 0 0 0\nv 10 0 0\nv 10 20 0\nv 0 20 0.5\nf -4 -3 -2 -1"));
}

TEST_F(MeshFile, ReadsAPlyOfWords) {
  expect_square(
      read("ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty double x\n"
           "property double y\nproperty double z\nproperty uchar red\nelement face 1\n"
           "property float quality\nproperty list uchar uint vertex_index\nelement edge 1\n"
           "property int vertex1\nproperty int vertex2\nend_header\n"
           "0 0 0 7\n10 0 0 7\n10 20 0 7\n0 20 .5 7\n0.25 4 0 1 2 3\n0 1\n"));
}

TEST_F(MeshFile, ReadsABinaryPlyOfEitherByteOrder) {
  testing::write_ply(file(), kCorners, kHalves);
  expect_square(read_mesh(file()));
  const std::string text = read_text(file());
  const size_t body = text.find("end_header\n") + 11;
  std::string turned = text;
  for (size_t at = body; at < body + 48; at += 4) {
    std::reverse(turned.begin() + long(at), turned.begin() + long(at) + 4);
  }
  for (size_t at = body + 49; at < turned.size(); at += at % 13 == (body + 57) % 13 ? 5 : 4) {
    std::reverse(turned.begin() + long(at), turned.begin() + long(at) + 4);
  }
  expect_square(read(with(turned, "little", "big")));
}

TEST_F(MeshFile, ReadsAGlbInMetres) {
  expect_square(read(glb_square(R"({"mesh":0,"scale":[1.0,1.0,1.0]})")));
}

TEST_F(MeshFile, SaysThatThereIsNone) {
  EXPECT_TRUE(names(complaint([&] { read_mesh(file()); }), {file().string(), "no such file"}));
  EXPECT_TRUE(names(complaint([&] { read_mesh(scratch_.path()); }), {"is not a file"}));
}

TEST_F(MeshFile, RefusesWhatHasNoTriangle) {
  for (const char* text : {"", "not a mesh\n", "v 0 0 0\nv 1 1 1\nf 1 2\n", "solid stl\n"}) {
    EXPECT_TRUE(names(refusal(text), {file().string(), "no triangle in it", ".ply, .obj or .glb"}));
  }
}

TEST_F(MeshFile, RefusesAVertexThatIsNoPlaceAndNamesIt) {
  EXPECT_TRUE(names(refusal("v 0 0 0\nv 1 nan 0\nv 1 1 0\nf 1 2 3\n"), {"vertex 1 is NaN"}));
  EXPECT_TRUE(names(refusal("v 0 0 0\nv 1 0 0\nv 1e39 1 0\nf 1 2 3\n"), {"vertex 2", "infinite"}));
  EXPECT_TRUE(names(refusal("v 0 0 0\nv 1 x 0\n"), {"line 2", "\"x\" is no number"}));
  EXPECT_TRUE(names(refusal("v 0 0\n"), {"line 1", "\"\" is no number"}));
}

TEST_F(MeshFile, RefusesACornerThatIsNoVertexAndNamesTheTriangle) {
  for (const char* corner : {"4", "0", "-4", "2.5e10", "nan"}) {
    const std::string face = std::string("f 1 2 3\nf 1 2 ") + corner + "\n";
    EXPECT_TRUE(names(refusal("v 0 0 0\nv 1 0 0\nv 1 1 0\n" + face), {"triangle 1", "3 vertices"}))
        << corner;
  }
}

TEST_F(MeshFile, RefusesAPlyThatEndsEarly) {
  testing::write_ply(file(), kCorners, kHalves);
  const std::string text = read_text(file());
  for (const size_t missing : {size_t(1), size_t(30), text.size() - text.find("end_header") - 11}) {
    EXPECT_TRUE(names(refusal(text.substr(0, text.size() - missing)), {"ends before all"}));
  }
  EXPECT_TRUE(names(refusal("ply\nformat ascii 1.0\n"), {"no end_header"}));
}

TEST_F(MeshFile, RefusesAPlyWhoseHeaderItDoesNotUnderstand) {
  const std::string good = testing::ply_header("ascii", 0, 0);
  EXPECT_TRUE(names(refusal(with(good, "ascii", "packed")), {"no format \"packed\""}));
  EXPECT_TRUE(names(refusal(with(good, "float", "half")), {"no type \"half\""}));
  EXPECT_TRUE(names(refusal(with(good, "float z", "float w")), {"without x, y and z"}));
  EXPECT_TRUE(names(refusal(with(good, "element vertex 0\n", "")), {"a property of no element"}));
}

TEST_F(MeshFile, RefusesAGlbThatItWouldMisread) {
  const std::string good = glb_square(R"({"mesh":0})");
  EXPECT_TRUE(names(refusal(glb_square(R"({"mesh":0,"scale":[1,2,1]})")), {"scales its mesh"}));
  EXPECT_TRUE(names(refusal(good.substr(0, good.size() - 1)), {"ends before all"}));
  EXPECT_TRUE(names(refusal(good.substr(0, 15)), {"ends before all"}));
  EXPECT_TRUE(names(refusal(with(good, "\"count\":4", "\"count\":9")), {"beyond its end"}));
  EXPECT_TRUE(names(refusal(with(good, "\"count\":6", "\"count\":-")), {"JSON cannot be read"}));
  EXPECT_TRUE(names(refusal(with(good, "\"count\":6", "\"count\":\"")), {"cannot be read"}));
  EXPECT_TRUE(names(refusal(with(good, "5126", "5122")), {"no floats"}));
  EXPECT_TRUE(names(refusal(with(good, "5123", "5126")), {"beyond its end"}));
  EXPECT_TRUE(names(refusal(with(good, "\"buffer\":0", "\"buffer\":1")), {"elsewhere"}));
}

}  // namespace
}  // namespace lamella
