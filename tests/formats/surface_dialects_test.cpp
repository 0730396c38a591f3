// The same box as other programs write it: forms of OBJ, PLY and STL that are legal or in use.
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <string>

#include <gtest/gtest.h>

#include "formats/surface/surface_reader.h"
#include "tests/support/meshes/surface_files.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using namespace tremolo::testing;

class SurfaceDialects : public ::testing::Test {
 protected:
  SurfaceFile read(const std::string& name, const std::string& bytes) {
    Result<SurfaceFile> file = read_surface(folder.write(name, bytes));
    EXPECT_TRUE(file) << file.error().message;
    return file ? std::move(*file) : SurfaceFile{};
  }
  std::string refusal(const std::string& name, const std::string& bytes) {
    const Result<SurfaceFile> file = read_surface(folder.write(name, bytes));
    EXPECT_FALSE(file) << name;
    return file ? "" : file.error().message;
  }
  // 1 x 2 x 3, wound outwards.
  void expect_box(const std::string& name, const std::string& bytes) {
    const RenderSurface surface = read(name, bytes).surface;
    ASSERT_EQ(surface.triangles.size(), 12U) << name;
    double volume = 0;
    for (const Triangle& t : surface.triangles)
      volume +=
          surface.vertices[t[0]].dot(surface.vertices[t[1]].cross(surface.vertices[t[2]])) / 6;
    EXPECT_NEAR(volume, 6, 1e-9) << name;
  }

  TemporaryFolder folder;
};

std::string with_mark(const std::string& text) {
  return "\xef\xbb\xbf" + text;
}

std::string in_upper_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

std::string with(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos;
       at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

TEST_F(SurfaceDialects, AByteOrderMarkIsSkippedInEveryTextFormat) {
  expect_box("box.obj", with_mark(box_obj()));
  expect_box("box.ply", with_mark(box_ply(false)));
  expect_box("box.stl", with_mark(box_stl_text()));
  expect_box("box.off", with_mark(box_off()));
  expect_box("box.gltf", with_mark(box_gltf(data_uri(box_gltf_buffer()))));
}

// A .ply of which only the header and the order of its parts vary.
enum class Numbers { kText, kLittle, kBig };

template <class T>
void put(std::string& bytes, T value, Numbers numbers) {
  if (numbers == Numbers::kText) {
    bytes += std::to_string(value) + " ";
    return;
  }
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), &value, sizeof(T));
  if (numbers == Numbers::kBig) std::reverse(raw.begin(), raw.end());
  bytes.append(raw.data(), raw.size());
}

// order: v the vertices, f the faces, t strips in their place, x an element with lists and numbers.
std::string ply_of(const std::string& order, Numbers numbers) {
  std::string head = "ply\nformat ";
  head += numbers == Numbers::kText     ? "ascii"
          : numbers == Numbers::kLittle ? "binary_little_endian"
                                        : "binary_big_endian";
  head += " 1.0\ncomment by a test\n";
  std::string body;
  for (const char part : order) {
    if (part == 'v') {
      head += "element vertex 8\nproperty double x\nproperty double y\nproperty double z\n";
      for (const Corner& x : box_corners())
        for (const float value : x) put(body, static_cast<double>(value), numbers);
    } else if (part == 'f') {
      head += "element face 6\nproperty list uchar int vertex_index\n";
      for (const auto& quad : box_quads()) {
        put(body, std::uint8_t{4}, numbers);
        for (const std::int32_t v : quad) put(body, v, numbers);
      }
    } else if (part == 't') {
      head += "element tristrips 1\nproperty list int int vertex_indices\n";
      put(body, std::int32_t{6 * 5}, numbers);
      for (const auto& q : box_quads())
        for (const std::int32_t v : {int(q[0]), int(q[1]), int(q[3]), int(q[2]), -1})
          put(body, v, numbers);
    } else {
      head +=
          "element camera 2\nproperty list uchar float view\nproperty short id\nproperty float f\n";
      for (int k = 0; k < 2; ++k) {
        put(body, std::uint8_t{3}, numbers);
        for (int i = 0; i < 3; ++i) put(body, 0.5F, numbers);
        put(body, std::int16_t{7}, numbers);
        put(body, 1.5F, numbers);
      }
    }
  }
  return head + "end_header\n" + body + (numbers == Numbers::kText ? "\n" : "");
}

TEST_F(SurfaceDialects, APlyHasItsElementsInAnyOrderAndOthersAmongThem) {
  for (const Numbers numbers : {Numbers::kText, Numbers::kLittle, Numbers::kBig})
    for (const char* order : {"vf", "fv", "xvf", "vxf", "vfx", "xfxvx"})
      expect_box(std::string(order) + ".ply", ply_of(order, numbers));
}

// Of which the text has all numbers on one line.
TEST_F(SurfaceDialects, StripsOfAPlyAreTriangles) {
  for (const Numbers numbers : {Numbers::kText, Numbers::kLittle, Numbers::kBig})
    for (const char* order : {"vt", "tv", "xvt"})
      expect_box(std::string(order) + ".ply", ply_of(order, numbers));
  expect_box("one-number-a-line.ply", [] {
    std::string text = ply_of("vf", Numbers::kText);
    const std::size_t body = text.find("end_header\n") + 11;
    return text.substr(0, body) + with(text.substr(body), " ", "\n");
  }());
  expect_box("about.ply",
             with(ply_of("vf", Numbers::kText), "comment by a test", "Made by a test"));
  expect_box("mac.ply", with(ply_of("vf", Numbers::kText), "\n", "\r"));
  expect_box("dos.ply", with(ply_of("vf", Numbers::kText), "\n", "\r\n"));
}

TEST_F(SurfaceDialects, TextureCoordinatesOfAPlysCornersAreKept) {
  const SurfaceFile file =
      read("wedge.ply",
           "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty "
           "float z\nelement face 2\nproperty list uchar int vertex_indices\nproperty list uchar "
           "float texcoord\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 6 0 0 1 0 1 1\n"
           "3 0 2 3 6 0.5 0 1 1 0 1\n");
  ASSERT_EQ(file.surface.vertices.size(), 5U) << "one corner has two texture coordinates";
  EXPECT_EQ(file.surface.sources, (std::vector<VertexId>{0, 1, 2, 3, 0}));
  EXPECT_EQ(file.surface.uvs[4], Eigen::Vector2f(0.5F, 0));
}

TEST_F(SurfaceDialects, AnStlIsTextInAnyCaseAndLayout) {
  expect_box("upper.stl", in_upper_case(box_stl_text()));
  expect_box("blanks.stl", with(box_stl_text(), "\n", " \r\n\t  "));
  expect_box("line.stl", with(box_stl_text(), "\n", " "));
  expect_box("nameless.stl", with(box_stl_text(), "solid box", "solid"));
  expect_box("unended.stl", with(box_stl_text(), "endsolid box\n", ""));
}

TEST_F(SurfaceDialects, SolidsOfAnStlKeepTheWholeOfTheirNames) {
  std::string text;
  for (const char* name : {"part 2", "part 1", "facet normal holder", "Teil  3 (links)"})
    text += with(box_stl_text(), "solid box", std::string("solid ") + name);
  const SurfaceFile file = read("parts.stl", text);
  EXPECT_EQ(
      file.surface.objects,
      (std::vector<std::string>{"part 2", "part 1", "facet normal holder", "Teil  3 (links)"}));
  EXPECT_EQ(file.surface.triangles.size(), 48U);
  EXPECT_EQ(file.surface.object_of[12], 1U);
}

TEST_F(SurfaceDialects, ABinaryStlMayBeginWithSolidAndHaveBytesBehindItsEnd) {
  std::string named = box_stl_binary();
  named.replace(0, 25, "solid facet normal by CAD");
  expect_box("named.stl", named);
  expect_box("longer.stl", named + std::string(7, '\0'));
  expect_box("much longer.stl", box_stl_binary() + std::string(100, 'x'));
  const SurfaceFile file = read("longer.stl", box_stl_binary() + std::string(7, '\0'));
  ASSERT_EQ(file.notes.size(), 1U);
  EXPECT_EQ(file.notes[0].find("7 bytes behind"), 0U) << file.notes[0];
  EXPECT_NE(refusal("cut.stl", named.substr(0, named.size() - 20)).find("cut off"),
            std::string::npos);
}

TEST_F(SurfaceDialects, AnObjMayListFacesFirstContinueLinesAndEndThemAnyhow) {
  std::string vertices, faces;
  for (const Corner& x : box_corners()) vertices += "v " + corner_text(x) + " 1.0\n";
  for (const auto& q : box_quads())
    faces += "f " + std::to_string(q[0] + 1) + " " + std::to_string(q[1] + 1) + " \\\n " +
             std::to_string(q[2] + 1) + " " + std::to_string(q[3] + 1) + "\n";
  expect_box("continued.obj", vertices + faces);
  expect_box("faces-first.obj", faces + vertices);
  expect_box("mac.obj", with(vertices + faces, "\n", "\r"));
  expect_box("dos.obj", with(vertices + faces, "\n", "\r\n"));
  const std::string problem = refusal("bad.obj", vertices + "f 1 2 3\nf 1 2 9\n");
  EXPECT_NE(problem.find("line 10"), std::string::npos) << problem;
  EXPECT_NE(problem.find("found `9`"), std::string::npos) << problem;
}

// The file's numbers are those of the author's mesh in the modelling program.
TEST_F(SurfaceDialects, VerticesOfAnObjKeepTheirNumbersAndAreSplitOnlyWhereTheyDiffer) {
  std::string text;
  for (const Corner& x : box_corners()) text += "v " + corner_text(x) + "\n";
  text += "v 5 5 5\n";
  std::string plain = text;
  for (const auto& q : box_quads())
    plain += "f " + std::to_string(q[0] + 1) + " " + std::to_string(q[1] + 1) + " " +
             std::to_string(q[2] + 1) + " " + std::to_string(q[3] + 1) + "\n";
  const RenderSurface shared = read("plain.obj", plain).surface;
  ASSERT_EQ(shared.vertices.size(), 9U) << "eight corners, and one that no face has";
  EXPECT_TRUE(shared.sources.empty());
  EXPECT_EQ(shared.authored(), 9U);
  // Normals of the corners, written once a face: equal ones are not split.
  static constexpr std::array kNormals = {"0 0 -1", "0 0 1", "0 -1 0", "1 0 0", "0 1 0", "-1 0 0"};
  std::string smooth = text, flat = text;
  int face = 0;
  for (const auto& q : box_quads()) {
    for (const std::uint16_t v : q) {
      const Corner& x = box_corners()[v];
      smooth += "vn " + corner_text({x[0] * 2 - 1, x[1] - 1, x[2] * 2 / 3 - 1}) + "\n";
    }
    flat += std::string("vn ") + kNormals[face] + "\n";
    smooth += "f";
    flat += "f";
    for (int c = 0; c < 4; ++c) {
      smooth += " " + std::to_string(q[c] + 1) + "//" + std::to_string(4 * face + c + 1);
      flat += " " + std::to_string(q[c] + 1) + "//" + std::to_string(face + 1);
    }
    smooth += "\n";
    flat += "\n";
    ++face;
  }
  EXPECT_EQ(read("smooth.obj", smooth).surface.vertices.size(), 9U);
  const RenderSurface split = read("flat.obj", flat).surface;
  EXPECT_EQ(split.vertices.size(), 25U) << "three faces meet at each of eight corners";
  EXPECT_EQ(split.authored(), 9U);
  ASSERT_EQ(split.sources.size(), 25U);
  for (std::size_t v = 0; v < split.vertices.size(); ++v)
    EXPECT_EQ(split.vertices[v], shared.vertices[split.sources[v]]) << v;
}

}  // namespace
}  // namespace tremolo
