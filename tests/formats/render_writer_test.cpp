#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>

#include <gtest/gtest.h>

#include "formats/surface/surface_writer.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/text_lines.h"
#include "tests/support/tiny_render.h"

namespace tremolo {
namespace {

using testing::lines_with;
using testing::TemporaryFolder;
using testing::tiny_render;

std::string written(const RenderSurface& surface, const std::string& name) {
  const TemporaryFolder folder;
  const Status status = write_render_surface(folder.file(name), surface);
  EXPECT_TRUE(status) << (status ? "" : status.error().message);
  std::ifstream stream(folder.file(name), std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(RenderWriter, AnObjKeepsTextureCoordinatesNormalsObjectsAndMaterials) {
  const std::string text = written(tiny_render().surface, "s.obj");
  EXPECT_EQ(lines_with(text, "v").size(), 6u);
  EXPECT_EQ(lines_with(text, "v")[2], "v 0.5 0.5 1 0 0 1") << "with its colour";
  EXPECT_EQ(lines_with(text, "vt")[1], "vt 0.5 0");
  EXPECT_EQ(lines_with(text, "vn")[5], "vn 0 0 1");
  EXPECT_EQ(text.substr(text.find("o lid")),
            "o lid\nusemtl Blech\nf 1/1/1 2/2/2 3/3/3\n"
            "o left half\nusemtl Blech\nf 4/4/4 5/5/5 6/6/6\n");
}

TEST(RenderWriter, AnObjWithoutThemIsStillAnObj) {
  RenderSurface surface = tiny_render().surface;
  surface.colours.clear();
  surface.uvs.clear();
  const std::string with_normals = written(surface, "s.obj");
  EXPECT_EQ(lines_with(with_normals, "f")[1], "f 4//4 5//5 6//6");
  EXPECT_EQ(lines_with(with_normals, "v")[1], "v 0.5 0 1");
  surface.normals.clear();
  EXPECT_EQ(lines_with(written(surface, "s.obj"), "f")[0], "f 1 2 3");
  surface.uvs = tiny_render().surface.uvs;
  EXPECT_EQ(lines_with(written(surface, "s.obj"), "f")[0], "f 1/1 2/2 3/3");
}

TEST(RenderWriter, ALibraryHasTheMeanColourOfEachMaterial) {
  RenderSurface surface = tiny_render().surface;
  surface.materials = {"lid", "not used"};
  surface.material_of = {0, 0};
  for (std::size_t v = 0; v < 6; ++v)
    surface.colours[v] = v < 3 ? Colour{255, 0, 0, 255} : Colour{0, 0, 255, 255};
  const std::string library = material_library(surface);
  EXPECT_EQ(lines_with(library, "newmtl"),
            (std::vector<std::string>{"newmtl lid", "newmtl not used"}));
  EXPECT_EQ(lines_with(library, "Kd"),
            (std::vector<std::string>{"Kd 0.5 0 0.5", "Kd 0.8 0.8 0.8"}));
  surface.colours.clear();
  EXPECT_EQ(lines_with(material_library(surface), "Kd")[0], "Kd 0.8 0.8 0.8");
}

TEST(RenderWriter, ANameCannotBreakItsLine) {
  RenderSurface surface = tiny_render().surface;
  surface.objects = {"a\nf 1 2 3", ""};
  const std::string text = written(surface, "s.obj");
  EXPECT_EQ(lines_with(text, "f").size(), 2u);
  EXPECT_EQ(lines_with(text, "o"), (std::vector<std::string>{"o a_f 1 2 3", "o unnamed"}));
}

TEST(RenderWriter, APlyHasOneRecordAVertexWithAllOfIt) {
  const RenderSurface surface = tiny_render().surface;
  const std::string bytes = written(surface, "s.ply");
  for (const char* property : {"float nx", "float s", "uchar alpha"})
    EXPECT_NE(bytes.find(property), std::string::npos);
  const std::size_t start = bytes.find("end_header\n") + std::strlen("end_header\n");
  constexpr std::size_t kVertex = 4 * 8 + 4;
  ASSERT_EQ(bytes.size() - start, 6 * kVertex + 2 * 13);
  const char* fifth = bytes.data() + start + 5 * kVertex;
  float numbers[8];
  std::memcpy(numbers, fifth, sizeof(numbers));
  const float expected[] = {0, 0.5f, 1, 0, 0, 1, 0.5f, 1};
  EXPECT_EQ(std::memcmp(numbers, expected, sizeof(numbers)), 0);
  EXPECT_EQ(std::string(fifth + 32, 4), std::string("\1\2\3\4"));
}

TEST(RenderWriter, PovRayGetsItsVectorsInItsOrder) {
  const std::string text = written(tiny_render().surface, "s.inc");
  const std::size_t at[] = {text.find("vertex_vectors"), text.find("normal_vectors"),
                            text.find("uv_vectors"), text.find("face_indices")};
  for (std::size_t i = 1; i < 4; ++i) EXPECT_LT(at[i - 1], at[i]);
  EXPECT_NE(text.find("<3, 4, 5>"), std::string::npos);
}

TEST(RenderWriter, AnotherEndingIsWrongUsage) {
  const TemporaryFolder folder;
  for (const char* name : {"s.stl", "obj", "x"})
    EXPECT_EQ(write_render_surface(folder.file(name), tiny_render().surface).error().kind,
              ErrorKind::kUsage);
}

}  // namespace
}  // namespace tremolo
