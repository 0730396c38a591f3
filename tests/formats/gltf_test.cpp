// glTF beyond assimp's support: extensions, integers, skins.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "formats/surface/surface_reader.h"
#include "tests/support/meshes/surface_files.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using namespace tremolo::testing;

class Gltf : public ::testing::Test {
 protected:
  SurfaceFile read(const std::string& text, const std::string& name = "scene.gltf") {
    Result<SurfaceFile> file = read_surface(folder.write(name, text));
    EXPECT_TRUE(file) << file.error().message;
    return file ? std::move(*file) : SurfaceFile{};
  }
  std::string refusal(const std::string& text) {
    const Result<SurfaceFile> file = read_surface(folder.write("scene.gltf", text));
    EXPECT_FALSE(file);
    if (!file) EXPECT_EQ(file.error().kind, ErrorKind::kContent);
    return file ? "" : file.error().message;
  }

  TemporaryFolder folder;
};

void expect_extent(const RenderSurface& surface, const Eigen::Vector3d& low,
                   const Eigen::Vector3d& high) {
  const BoundingBox box = bounding_box(surface.vertices);
  EXPECT_LT((box.low - low).norm(), 1e-5) << box.low.transpose();
  EXPECT_LT((box.high - high).norm(), 1e-5) << box.high.transpose();
}

std::string with(std::string text, const std::string& from, const std::string& to) {
  text.replace(text.find(from), from.size(), to);
  return text;
}

std::string requiring(const std::string& extension) {
  return with(box_gltf(data_uri(box_gltf_buffer())), "\"scene\":0",
              "\"extensionsUsed\":[\"" + extension + "\"],\"extensionsRequired\":[\"" + extension +
                  "\"],\"scene\":0");
}

TEST_F(Gltf, ARequiredExtensionThatIsNotUnderstoodIsRefusedByName) {
  for (const char* name : {"EXT_meshopt_compression", "KHR_something_new", "VENDOR_shape"}) {
    const std::string said = refusal(requiring(name));
    EXPECT_NE(said.find(name), std::string::npos) << said;
    EXPECT_NE(said.find("without"), std::string::npos) << said;
  }
  // Draco is assimp's affair: without compressed primitives there is nothing to unpack.
  for (const char* name : {"KHR_draco_mesh_compression", "KHR_materials_unlit",
                           "KHR_texture_transform", "KHR_texture_basisu", "KHR_mesh_quantization"})
    expect_extent(read(requiring(name)).surface, {0, 0, 0}, {1, 2, 3});
}

// The box on a grid of `unit`, as integers of the type; a scale of the node undoes it.
template <class T>
std::string integer_box(int component, bool normalised, double unit, double scale) {
  std::string buffer;
  for (const Corner& x : box_corners()) {
    for (const float value : x) append_bytes(buffer, static_cast<T>(value * unit));
    while (buffer.size() % 4 != 0) buffer += '\0';
  }
  const std::size_t positions = buffer.size();
  for (const auto& triangle : box_triangles()) append_bytes(buffer, triangle);
  const auto number = [](auto value) { return std::to_string(value); };
  return R"({"asset":{"version":"2.0"},"extensionsUsed":["KHR_mesh_quantization"],)"
         R"("extensionsRequired":["KHR_mesh_quantization"],"scene":0,"scenes":[{"nodes":[0]}],)"
         R"("nodes":[{"mesh":0,"scale":[)" +
         number(scale) + "," + number(scale) + "," + number(scale) +
         R"(]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
         R"("accessors":[{"bufferView":0,"componentType":)" +
         number(component) + ",\"normalized\":" + (normalised ? "true" : "false") +
         R"(,"count":8,"type":"VEC3"},{"bufferView":1,"componentType":5123,"count":36,)"
         R"("type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":)" +
         number(positions) + ",\"byteStride\":" + number(positions / 8) +
         R"(},{"buffer":0,"byteOffset":)" + number(positions) +
         R"(,"byteLength":72}],"buffers":[{"byteLength":)" + number(buffer.size()) + ",\"uri\":\"" +
         data_uri(buffer) + "\"}]}";
}

TEST_F(Gltf, PositionsMayBeIntegersOfAnyKind) {
  const Eigen::Vector3d low(0, 0, 0), high(1, 2, 3);
  expect_extent(read(integer_box<std::uint16_t>(5123, false, 1000, 1e-3)).surface, low, high);
  expect_extent(read(integer_box<std::int16_t>(5122, false, 100, 1e-2)).surface, low, high);
  expect_extent(read(integer_box<std::uint8_t>(5121, false, 50, 0.02)).surface, low, high);
  expect_extent(read(integer_box<std::int8_t>(5120, false, 40, 0.025)).surface, low, high);
  expect_extent(read(integer_box<std::uint16_t>(5123, true, 21845, 3)).surface, low, high);
  // 127 is one: 3 m are 127 with three of them a unit.
  expect_extent(read(integer_box<std::int8_t>(5120, true, 127.0 / 3, 3)).surface, low,
                {126.0 / 127, 252.0 / 127, 3});
}

TEST_F(Gltf, InstancesOnTheGraphicsCardAreObjects) {
  std::string buffer = box_gltf_buffer();
  for (const Corner& x : {Corner{0, 0, 0}, Corner{10, 0, 0}, Corner{0, 20, 0}})
    append_bytes(buffer, x);
  for (const Corner& x : {Corner{1, 1, 1}, Corner{2, 2, 2}, Corner{1, 1, 1}})
    append_bytes(buffer, x);
  std::string text =
      box_gltf(data_uri(buffer),
               R"([{"name":"Box","mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{
      "TRANSLATION":4,"SCALE":5}}}}])");
  text = with(text, "\"count\":36,\"type\":\"SCALAR\"}",
              "\"count\":36,\"type\":\"SCALAR\"},"
              R"({"bufferView":4,"componentType":5126,"count":3,"type":"VEC3"},)"
              R"({"bufferView":5,"componentType":5126,"count":3,"type":"VEC3"})");
  text = with(text, "\"byteOffset\":288,\"byteLength\":72}",
              R"("byteOffset":288,"byteLength":72},{"buffer":0,"byteOffset":360,"byteLength":36},)"
              R"({"buffer":0,"byteOffset":396,"byteLength":36})");
  text = with(text, "\"byteLength\":360", "\"byteLength\":432");
  text = with(text, "\"scene\":0",
              R"("extensionsUsed":["EXT_mesh_gpu_instancing"],"extensionsRequired":[)"
              R"("EXT_mesh_gpu_instancing"],"scene":0)");
  const RenderSurface surface = read(text).surface;
  EXPECT_EQ(surface.objects, (std::vector<std::string>{"Box", "Box 2", "Box 3"}));
  EXPECT_EQ(surface.triangles.size(), 36U);
  expect_extent(surface, {0, 0, 0}, {12, 22, 6});
}

// bind: the inverse bind matrix's scale, or 0 for a skin without matrices.
std::string skinned_box(const std::string& mesh_node, const std::string& joint_node, float bind) {
  std::string buffer = box_gltf_buffer();
  for (int v = 0; v < 8; ++v) append_bytes(buffer, std::array<std::uint8_t, 4>{0, 0, 0, 0});
  for (int v = 0; v < 8; ++v) append_bytes(buffer, std::array<float, 4>{1, 0, 0, 0});
  for (int k = 0; k < 16; ++k) append_bytes(buffer, k == 15 ? 1.0F : k % 5 == 0 ? bind : 0.0F);
  std::string text = box_gltf(data_uri(buffer), "[" + mesh_node + "," + joint_node + "]", "[0,1]");
  text = with(text, "\"COLOR_0\":2", "\"COLOR_0\":2,\"JOINTS_0\":4,\"WEIGHTS_0\":5");
  text = with(text, "\"count\":36,\"type\":\"SCALAR\"}",
              "\"count\":36,\"type\":\"SCALAR\"},"
              R"({"bufferView":4,"componentType":5121,"count":8,"type":"VEC4"},)"
              R"({"bufferView":5,"componentType":5126,"count":8,"type":"VEC4"},)"
              R"({"bufferView":6,"componentType":5126,"count":1,"type":"MAT4"})");
  text = with(text, "\"byteOffset\":288,\"byteLength\":72}",
              R"("byteOffset":288,"byteLength":72},{"buffer":0,"byteOffset":360,"byteLength":32},)"
              R"({"buffer":0,"byteOffset":392,"byteLength":128},)"
              R"({"buffer":0,"byteOffset":520,"byteLength":64})");
  text = with(text, "\"byteLength\":360", "\"byteLength\":584");
  return with(text, "\"scene\":0",
              std::string(R"("skins":[{"joints":[1])") +
                  (bind != 0 ? R"(,"inverseBindMatrices":6)" : "") + R"(}],"scene":0)");
}

TEST_F(Gltf, ASkinnedMeshIsWhereItsJointsPutItWhateverItsOwnNodeDoes) {
  const std::string mesh =
      R"({"name":"Box","mesh":0,"skin":0,"scale":[100,100,100],"translation":[5,0,0]})";
  const std::string plain_joint = R"({"name":"joint"})";
  expect_extent(read(skinned_box(mesh, plain_joint, 1)).surface, {0, 0, 0}, {1, 2, 3});
  expect_extent(read(skinned_box(mesh, plain_joint, 0)).surface, {0, 0, 0}, {1, 2, 3});
  expect_extent(read(skinned_box(mesh, R"({"name":"joint","translation":[0,0,7]})", 1)).surface,
                {0, 0, 7}, {1, 2, 10});
  expect_extent(read(skinned_box(mesh, R"({"name":"joint","scale":[10,10,10]})", 0.1F)).surface,
                {0, 0, 0}, {1, 2, 3});
  // Nodes of one name are still two.
  expect_extent(read(skinned_box(mesh, R"({"name":"Box","translation":[1,0,0]})", 1)).surface,
                {1, 0, 0}, {2, 2, 3});
}

}  // namespace
}  // namespace tremolo
