// The same box from every format, and the additions of a scene.
#include "formats/surface/surface_reader.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/meshes/surface_files.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using namespace tremolo::testing;

double enclosed_volume(const RenderSurface& surface) {
  double volume = 0;
  for (const Triangle& t : surface.triangles)
    volume += surface.vertices[t[0]].dot(surface.vertices[t[1]].cross(surface.vertices[t[2]])) / 6;
  return volume;
}

bool says(const SurfaceFile& file, const std::string& part) {
  return std::any_of(file.notes.begin(), file.notes.end(),
                     [&](const std::string& note) { return note.find(part) != std::string::npos; });
}

class SurfaceReader : public ::testing::Test {
 protected:
  SurfaceFile read(const std::string& name, const std::string& bytes,
                   const SurfaceReadOptions& options = {}) {
    Result<SurfaceFile> file = read_surface(folder.write(name, bytes), options);
    EXPECT_TRUE(file) << file.error().message;
    return file ? std::move(*file) : SurfaceFile{};
  }
  Error refusal(const std::string& name, const std::string& bytes,
                const SurfaceReadOptions& options = {}) {
    const Result<SurfaceFile> file = read_surface(folder.write(name, bytes), options);
    EXPECT_FALSE(file);
    return file ? Error{} : file.error();
  }

  TemporaryFolder folder;
};

// The box, times `scale`. Single precision leaves seven digits.
void expect_box(const SurfaceFile& file, double scale = 1, int boxes = 1) {
  EXPECT_EQ(file.surface.triangles.size(), 12U * boxes);
  const BoundingBox box = bounding_box(file.surface.vertices);
  EXPECT_LT(box.low.norm(), 1e-6 * scale);
  EXPECT_LT((box.high - scale * Eigen::Vector3d(1, 2, 3)).norm(), 1e-6 * scale);
  EXPECT_NEAR(enclosed_volume(file.surface), 6 * boxes * scale * scale * scale,
              1e-5 * scale * scale * scale);
}

TEST_F(SurfaceReader, TheSameBoxComesOutOfEveryFormat) {
  folder.write("box.bin", box_gltf_buffer());
  expect_box(read("box.obj", box_obj()));
  expect_box(read("text.ply", box_ply(false)));
  expect_box(read("binary.ply", box_ply(true)));
  expect_box(read("text.stl", box_stl_text()));
  expect_box(read("binary.stl", box_stl_binary()));
  expect_box(read("box.off", box_off()));
  expect_box(read("beside.gltf", box_gltf("box.bin")));
  expect_box(read("inside.gltf", box_gltf(data_uri(box_gltf_buffer()))));
  expect_box(read("box.glb", box_glb()));
  expect_box(read("box.dae", box_dae()));
  expect_box(read("box.fbx", box_fbx()), 2.54);
}

// The corners of each triangle, in order.
std::vector<std::array<double, 9>> corners_of(const RenderSurface& surface) {
  std::vector<std::array<double, 9>> corners;
  for (const Triangle& t : surface.triangles) {
    auto& nine = corners.emplace_back();
    for (std::size_t i = 0; i < 9; ++i)
      nine[i] = surface.vertices[t[i / 3]][static_cast<int>(i % 3)];
  }
  return corners;
}

TEST_F(SurfaceReader, AnOffIsTheSameSurfaceAsTheObj) {
  const std::array<std::string, 2> star = star_prism();
  const SurfaceFile obj = read("star.obj", star[0]);
  const SurfaceFile off = read("star.off", star[1]);
  // Two stars of 24 corners and a wall of 24 quads.
  EXPECT_EQ(off.surface.triangles.size(), 2U * 22 + 2 * 24);
  EXPECT_EQ(off.surface.vertices.size(), 48U) << "corners stay shared";
  EXPECT_EQ(corners_of(off.surface), corners_of(obj.surface)) << "to the bit";
  EXPECT_TRUE(off.notes.empty());
}

// assimp's rounding of long numbers is its own, and not always to the nearest float.
TEST_F(SurfaceReader, LongNumbersOfAnOffAreRoundedAsAnObjs) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-10, 10);
  std::string obj, off = "OFF\n999 333 0\n", obj_faces, off_faces;
  char line[100];
  for (int v = 0; v < 999; ++v) {
    std::snprintf(line, sizeof(line), "%.17g %.17g %.17g\n", uniform(random), uniform(random),
                  uniform(random));
    obj += std::string("v ") + line;
    off += line;
    if (v % 3 != 2) continue;
    std::snprintf(line, sizeof(line), "%d %d %d\n", v - 1, v, v + 1);
    obj_faces += std::string("f ") + line;
    std::snprintf(line, sizeof(line), "3 %d %d %d\n", v - 2, v - 1, v);
    off_faces += line;
  }
  const SurfaceFile first = read("long.obj", obj + obj_faces);
  const SurfaceFile second = read("long.off", off + off_faces);
  EXPECT_EQ(first.surface.triangles.size(), 333U);
  EXPECT_EQ(corners_of(second.surface), corners_of(first.surface));
}

TEST_F(SurfaceReader, AnOffsColoursAreSelectable) {
  const std::string head = "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
  const SurfaceFile painted = read(
      "faces.off", head + "3 0 2 1 255 0 0\n3 0 1 3 255 0 0\n3 0 3 2 0 0 255\n3 1 2 3 0 0 255\n");
  const RenderSurface& surface = painted.surface;
  ASSERT_EQ(surface.colours.size(), surface.vertices.size());
  EXPECT_EQ(surface.vertices.size(), 8U) << "where colours meet there are two vertices";
  for (std::size_t t = 0; t < 4; ++t)
    for (const VertexId v : surface.triangles[t])
      EXPECT_EQ(surface.colours[v], (t < 2 ? Colour{255, 0, 0, 255} : Colour{0, 0, 255, 255}));
}

TEST_F(SurfaceReader, WhatOfAnOffIsNotReadIsTold) {
  EXPECT_TRUE(says(read("more.off", box_off() + "3 0 1 2\n"), "behind the last of"));
  const std::string points = "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_NE(refusal("points.off", points).message.find("holds no faces"), std::string::npos);
}

TEST_F(SurfaceReader, AnOffThatIsWrongNamesItsLineAndTheFileOnce) {
  const std::string off = box_off();
  const Error error = refusal("cut.off", off.substr(0, off.rfind("4 3 0")));
  EXPECT_EQ(error.kind, ErrorKind::kContent);
  EXPECT_NE(error.message.find("behind 5 of 6 faces"), std::string::npos) << error.message;
  EXPECT_EQ(error.message.find("cut.off"), error.message.rfind("cut.off")) << error.message;
  EXPECT_NE(refusal("bad.off", "OFF\n1 1 0\n0 0 x\n1 0\n").message.find("line 3"),
            std::string::npos);
}

TEST_F(SurfaceReader, AnObjKeepsItsNormalsTextureAndMaterials) {
  folder.write("box.mtl", box_mtl());
  const SurfaceFile file = read("box.obj", box_obj());
  const RenderSurface& surface = file.surface;
  EXPECT_EQ(file.format, "Wavefront OBJ");
  EXPECT_EQ(surface.objects, std::vector<std::string>{"Box"});
  EXPECT_EQ(surface.materials, (std::vector<std::string>{"steel", "glass"}));
  EXPECT_TRUE(surface.colours.empty());
  ASSERT_EQ(surface.normals.size(), surface.vertices.size());
  ASSERT_EQ(surface.uvs.size(), surface.vertices.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const Triangle& v = surface.triangles[t];
    EXPECT_EQ(surface.material_of[t], t < 6 ? 0U : 1U);
    const Eigen::Vector3d normal = (surface.vertices[v[1]] - surface.vertices[v[0]])
                                       .cross(surface.vertices[v[2]] - surface.vertices[v[0]])
                                       .normalized();
    for (const VertexId corner : v)
      EXPECT_LT((surface.normals[corner].cast<double>() - normal).norm(), 1e-6);
    // Every face shows the whole picture: its triangles have half of it each.
    const Eigen::Vector2f a = surface.uvs[v[1]] - surface.uvs[v[0]];
    const Eigen::Vector2f b = surface.uvs[v[2]] - surface.uvs[v[0]];
    EXPECT_FLOAT_EQ(a.x() * b.y() - a.y() * b.x(), 1);
  }
}

TEST_F(SurfaceReader, VertexColoursOfAPlyStayWhereTheyWere) {
  const SurfaceFile file = read("box.ply", box_ply(true));
  const RenderSurface& surface = file.surface;
  ASSERT_EQ(surface.colours.size(), surface.vertices.size());
  for (std::size_t v = 0; v < surface.vertices.size(); ++v) {
    EXPECT_EQ(surface.colours[v][0] > 127, surface.vertices[v].x() > 0.5);
    EXPECT_EQ(surface.colours[v][1] > 127, surface.vertices[v].y() > 1);
    EXPECT_EQ(surface.colours[v][2] > 127, surface.vertices[v].z() > 1.5);
    EXPECT_EQ(surface.colours[v][3], 255);
  }
  EXPECT_TRUE(surface.uvs.empty());
  EXPECT_TRUE(surface.normals.empty());
}

TEST_F(SurfaceReader, AGltfKeepsTextureCoordinatesColoursAndMaterial) {
  const SurfaceFile file = read("box.glb", box_glb());
  const RenderSurface& surface = file.surface;
  EXPECT_EQ(surface.objects, std::vector<std::string>{"Box"});
  EXPECT_EQ(surface.materials, std::vector<std::string>{"brass"});
  ASSERT_EQ(surface.uvs.size(), surface.vertices.size());
  ASSERT_EQ(surface.colours.size(), surface.vertices.size());
  for (std::size_t v = 0; v < surface.vertices.size(); ++v) {
    int corner = 0;
    while (
        (surface.vertices[v] - Eigen::Vector3d(box_corners()[corner][0], box_corners()[corner][1],
                                               box_corners()[corner][2]))
            .norm() > 1e-6)
      ASSERT_LT(++corner, 8);
    EXPECT_NEAR(surface.uvs[v].x(), corner / 8.0, 1e-6);
    // glTF counts v from the top.
    EXPECT_NEAR(surface.uvs[v].y(), corner / 16.0, 1e-6);
    EXPECT_NEAR(surface.colours[v][0], corner / 8.0 * 255, 0.51);
  }
}

TEST_F(SurfaceReader, TheUnitIsTheFilesUnlessItIsGiven) {
  EXPECT_EQ(read("box.dae", box_dae()).metres_per_unit, 0.01);
  EXPECT_DOUBLE_EQ(read("box.fbx", box_fbx()).metres_per_unit, 0.0254);
  EXPECT_NE(read("box.off", box_off()).unit.find("does not say"), std::string::npos);
  EXPECT_EQ(read("box.glb", box_glb()).unit.find("does not say"), std::string::npos);
  for (const auto& [name, bytes, scale] : {std::tuple{"box.dae", box_dae(), 100.0},
                                           {"box.fbx", box_fbx(), 100.0},
                                           {"box.off", box_off(), 1.0},
                                           {"box.glb", box_glb(), 1.0}}) {
    const SurfaceFile file = read(name, bytes, {.metres_per_unit = 0.5});
    expect_box(file, scale * 0.5);
    EXPECT_EQ(file.metres_per_unit, 0.5) << name;
  }
}

TEST_F(SurfaceReader, AnUnlikelySizeBringsUpTheUnit) {
  EXPECT_FALSE(says(read("box.off", box_off()), "--unit"));
  EXPECT_TRUE(says(read("fine.off", "OFF\n3 1 0\n0 0 0\n300 0 0\n0 5 0\n3 0 1 2\n"), "--unit"));
  EXPECT_TRUE(
      says(read("fine.off", "OFF\n3 1 0\n0 0 0\n.0003 0 0\n0 .0005 0\n3 0 1 2\n"), "--unit"));
  EXPECT_FALSE(says(read("box.off", box_off(), {.metres_per_unit = 1000}), "--unit"));
}

TEST_F(SurfaceReader, InstancesAreObjectsAndMirrorsKeepTheOutsideOut) {
  const std::string nodes = R"([{"name":"Box","mesh":0,"children":[1]},
    {"name":"Box","mesh":0,"scale":[-1,1,1],"translation":[1,0,0]},
    {"name":"Turned","mesh":0,"rotation":[0,0,1,0],"translation":[1,2,0]}])";
  const SurfaceFile file =
      read("scene.gltf", box_gltf(data_uri(box_gltf_buffer()), nodes, "[0,2]"));
  expect_box(file, 1, 3);
  EXPECT_EQ(file.surface.objects, (std::vector<std::string>{"Box", "Box 2", "Turned"}));
  EXPECT_EQ(file.surface.object_of.front(), 0U);
  EXPECT_EQ(file.surface.object_of.back(), 2U);
}

TEST_F(SurfaceReader, TransformsAddUpAlongTheTree) {
  const std::string nodes = R"([{"children":[1],"scale":[2,2,2]},
    {"children":[2],"translation":[0,0,1]},{"mesh":0,"name":"leaf","scale":[1,0.5,1]}])";
  const SurfaceFile file = read("scene.gltf", box_gltf(data_uri(box_gltf_buffer()), nodes));
  const BoundingBox box = bounding_box(file.surface.vertices);
  EXPECT_LT((box.low - Eigen::Vector3d(0, 0, 2)).norm(), 1e-6);
  EXPECT_LT((box.high - Eigen::Vector3d(2, 2, 8)).norm(), 1e-6);
  EXPECT_NEAR(enclosed_volume(file.surface), 24, 1e-4);
}

// One triangle with the normal (1, 1, 1), stretched, mirrored, flattened.
std::string scaled_triangle_dae(const std::string& scale) {
  const auto source = [](const std::string& id, const std::string& values, int count) {
    return "<source id=\"" + id + "\"><float_array id=\"" + id + "a\" count=\"" +
           std::to_string(3 * count) + "\">" + values +
           "</float_array><technique_common><accessor source=\"#" + id + "a\" count=\"" +
           std::to_string(count) +
           "\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/>"
           "<param name=\"Z\" type=\"float\"/></accessor></technique_common></source>";
  };
  return R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="1"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g" name="shape"><mesh>)" +
         source("p", "1 0 0 0 1 0 0 0 1", 3) + source("n", "0.57735 0.57735 0.57735", 1) +
         R"(<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="NORMAL" source="#n" offset="1"/><p>0 0 1 0 2 0</p></triangles></mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="s"><node id="n1"><scale>)" +
         scale + R"(</scale><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
}

TEST_F(SurfaceReader, NormalsStandOnTheirTriangleWhateverTheTransform) {
  for (const char* scale : {"1 1 1", "2 1 0.5", "-2 1 3", "-1 -3 -0.2", "1 -1e-3 1"}) {
    const RenderSurface surface = read("one.dae", scaled_triangle_dae(scale)).surface;
    ASSERT_EQ(surface.triangles.size(), 1U) << scale;
    ASSERT_EQ(surface.normals.size(), 3U) << scale;
    const Triangle& t = surface.triangles[0];
    const Eigen::Vector3d normal = (surface.vertices[t[1]] - surface.vertices[t[0]])
                                       .cross(surface.vertices[t[2]] - surface.vertices[t[0]])
                                       .normalized();
    // The file has five digits.
    for (const Eigen::Vector3f& n : surface.normals)
      EXPECT_LT((n.cast<double>() - normal).norm(), 1e-5) << scale;
  }
}

TEST_F(SurfaceReader, ConcavePolygonsAreCutInsideTheirOutline) {
  // An L of area 3, and a star of five points.
  std::string text = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6\n";
  const auto area_of = [](const RenderSurface& surface) {
    double area = 0;
    for (const Triangle& t : surface.triangles)
      area += (surface.vertices[t[1]] - surface.vertices[t[0]])
                  .cross(surface.vertices[t[2]] - surface.vertices[t[0]])
                  .z() /
              2;
    return area;
  };
  const SurfaceFile corner = read("corner.obj", text);
  EXPECT_EQ(corner.surface.triangles.size(), 4U);
  EXPECT_NEAR(area_of(corner.surface), 3, 1e-6);

  text.clear();
  std::string face = "f";
  for (int i = 0; i < 10; ++i) {
    const double angle = std::numbers::pi * i / 5;
    const double radius = i % 2 == 0 ? 2 : 1;
    text += "v " + std::to_string(radius * std::cos(angle)) + " " +
            std::to_string(radius * std::sin(angle)) + " 0\n";
    face += " " + std::to_string(i + 1);
  }
  const SurfaceFile star = read("star.obj", text + face + "\n");
  EXPECT_EQ(star.surface.triangles.size(), 8U);
  // Ten triangles from the centre; six digits in the text.
  EXPECT_NEAR(area_of(star.surface), 10 * std::sin(std::numbers::pi / 5), 1e-5);
}

TEST_F(SurfaceReader, WhatIsNoTriangleIsLeftOutAndSaid) {
  const SurfaceFile mixed =
      read("mixed.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 9 9 9\nf 1 2 3\np 4\nl 1 4\n");
  EXPECT_EQ(mixed.surface.triangles.size(), 1U);
  EXPECT_EQ(mixed.surface.vertices.size(), 4U) << "the file's vertices keep their numbers";
  EXPECT_TRUE(says(mixed, "1 point ")) << mixed.notes.size();
  EXPECT_TRUE(says(mixed, "1 line "));
  const Error none = refusal("lines.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\nl 2 3\nl 3 1\n");
  EXPECT_EQ(none.kind, ErrorKind::kContent);
  EXPECT_NE(none.message.find("no triangles"), std::string::npos) << none.message;
}

TEST_F(SurfaceReader, TrianglesWithoutNumbersAreLeftOutAndCounted) {
  std::string bytes = box_stl_binary();
  const float nan = std::nanf("");
  // The second vertex of the third triangle.
  std::memcpy(bytes.data() + 84 + 2 * 50 + 12 + 12, &nan, sizeof nan);
  const SurfaceFile file = read("nan.stl", bytes);
  EXPECT_EQ(file.surface.triangles.size(), 11U);
  EXPECT_TRUE(says(file, "1 triangle with"));
}

TEST_F(SurfaceReader, NormalsThatSomeLackAreMadeFromTheirTriangles) {
  const SurfaceFile file =
      read("half.obj",
           "o with\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0.6 0 0.8\nf 1//1 2//1 3//1\n"
           "o without\nv 0 0 1\nv 0 1 1\nv 0 0 2\nf 4 5 6\n");
  const RenderSurface& surface = file.surface;
  ASSERT_EQ(surface.normals.size(), 6U);
  EXPECT_EQ(surface.objects, (std::vector<std::string>{"with", "without"}));
  for (std::size_t t = 0; t < 2; ++t)
    for (const VertexId v : surface.triangles[t])
      EXPECT_LT((surface.normals[v] -
                 (t == 0 ? Eigen::Vector3f(0.6F, 0, 0.8F) : Eigen::Vector3f(1, 0, 0)))
                    .norm(),
                1e-6);
}

TEST_F(SurfaceReader, FarFromTheOriginTheLostDigitsAreSaid) {
  EXPECT_TRUE(says(read("far.off", "OFF\n3 1 0\n1e6 0 0\n1000001 0 0\n1e6 1 0\n3 0 1 2\n"),
                   "from the origin"));
  EXPECT_FALSE(says(read("box.off", box_off()), "from the origin"));
}

TEST_F(SurfaceReader, NamesAreMadePrintable) {
  const SurfaceFile file =
      read("names.obj", "o a\x1b[31mb\xff\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  ASSERT_EQ(file.surface.objects.size(), 1U);
  for (const char c : file.surface.objects[0]) EXPECT_TRUE(c >= 0x20 && c < 0x7f);
}

TEST(SurfaceFiles, AreKnownByTheirExtension) {
  for (const char* name : {"a.obj", "a.OBJ", "dir.msh/a.Stl", "a.gltf", "a.glb", "x.fbx", "x.dae",
                           "x.3ds", "x.ply", "x.off", "ogre.mesh.xml"})
    EXPECT_TRUE(is_surface_file(name)) << name;
  for (const char* name : {"a.msh", "a.vtk", "a.vtu", "a.veg", "a.node", "a.ele", "a.toml", "obj",
                           ".obj", "a.obj/b", "a.xml", "a.bvh", ""})
    EXPECT_FALSE(is_surface_file(name)) << name;
}

}  // namespace
}  // namespace tremolo
