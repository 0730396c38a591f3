// Files with false contents, and their effects on the process that reads them, which must be none.
#include <csignal>
#include <filesystem>
#include <random>
#include <string>
#include <sys/stat.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "formats/polygons/polygon_mesh.h"
#include "formats/surface/surface_reader.h"
#include "tests/support/meshes/surface_files.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using namespace tremolo::testing;

class HostileSurface : public ::testing::Test {
 protected:
  // The error of reading `path`; a name, a colon and something must stand there.
  Error refusal(const std::string& path, const SurfaceReadOptions& options = {}) {
    const Result<SurfaceFile> file = read_surface(path, options);
    if (file) {
      ADD_FAILURE() << path << " was read: " << file->surface.triangles.size();
      return {};
    }
    EXPECT_TRUE(file.error().message.starts_with(path + ": ")) << file.error().message;
    EXPECT_EQ(file.error().message.find('\n'), std::string::npos) << file.error().message;
    return file.error();
  }
  void expect_refused(const std::string& path, ErrorKind kind, const std::string& part = "") {
    const Error error = refusal(path);
    EXPECT_EQ(error.kind, kind) << error.message;
    EXPECT_NE(error.message.find(part), std::string::npos) << error.message;
  }

  TemporaryFolder folder;
};

TEST_F(HostileSurface, WhatIsNoFileIsTheSystemsError) {
  expect_refused(folder.file("none.obj"), ErrorKind::kSystem, "No such file");
  expect_refused(folder.path(), ErrorKind::kSystem, "not a regular file");
  ASSERT_EQ(::mkfifo(folder.file("pipe.obj").c_str(), 0600), 0);
  expect_refused(folder.file("pipe.obj"), ErrorKind::kSystem, "not a regular file");
  expect_refused("/dev/zero", ErrorKind::kSystem, "not a regular file");
}

TEST_F(HostileSurface, EmptyFilesAndGarbageAreRefusedInEveryFormat) {
  for (const char* extension : {"obj", "ply", "stl", "off", "gltf", "glb", "fbx", "dae", "3ds",
                                "blend", "x", "3mf", "ms3d", "lwo"}) {
    const std::string name = std::string("file.") + extension;
    expect_refused(folder.write(name, ""), ErrorKind::kContent, "empty");
    expect_refused(folder.write(name, "Dear reader,\nthis is a letter and no surface.\n"),
                   ErrorKind::kContent);
    expect_refused(folder.write(name, std::string(4000, '\0')), ErrorKind::kContent);
  }
}

// A file cut anywhere is refused or gives its complete part; it never ends the process.
TEST_F(HostileSurface, CutFilesAreRefusedOrGiveLess) {
  const std::vector<std::pair<const char*, std::string>> files = {
      {"box.stl", box_stl_binary()}, {"box.glb", box_glb()}, {"box.ply", box_ply(true)},
      {"box.obj", box_obj()},        {"box.off", box_off()}, {"box.dae", box_dae()},
      {"box.fbx", box_fbx()}};
  for (const auto& [name, bytes] : files)
    for (std::size_t length = 1; length < bytes.size(); length += 1 + bytes.size() / 12) {
      const Result<SurfaceFile> file = read_surface(folder.write(name, bytes.substr(0, length)));
      if (file)
        EXPECT_LE(file->surface.triangles.size(), 12U) << name << " " << length;
      else
        EXPECT_EQ(file.error().kind, ErrorKind::kContent) << file.error().message;
    }
}

TEST_F(HostileSurface, APlyWithoutAnEndOfItsHeaderIsRefusedAtOnce) {
  const std::string ply = box_ply(false);
  expect_refused(folder.write("cut.ply", ply.substr(0, ply.find("end_header"))),
                 ErrorKind::kContent, "end_header");
}

TEST_F(HostileSurface, CountsThatTheFileCannotHoldAreRefused) {
  std::string stl = box_stl_binary();
  const std::uint32_t many = 0xfffffff0;
  std::memcpy(stl.data() + 80, &many, 4);
  expect_refused(folder.write("many.stl", stl), ErrorKind::kContent);

  for (const char* element : {"vertex 8", "face 6"}) {
    for (const bool binary : {false, true}) {
      std::string ply = box_ply(binary);
      const std::string huge = std::string(element, std::strlen(element) - 1) + "4000000000";
      ply.replace(ply.find(element), std::strlen(element), huge);
      // Any result of assimp is acceptable, but read_surface() must return.
      const Result<SurfaceFile> file = read_surface(folder.write("many.ply", ply));
      if (file) {
        EXPECT_LE(file->surface.triangles.size(), 12U);
      }
    }
  }
  std::string off = box_off();
  off.replace(off.find("8 6 12"), 6, "4000000000 4000000000 0");
  expect_refused(folder.write("many.off", off), ErrorKind::kContent);
}

// In this process: a reader that leaves its bounds ends it.
TEST_F(HostileSurface, FilesThatWereChangedAtRandomAreRefusedOrGiveWholeSurfaces) {
  using Parser = Result<PolygonMesh> (*)(std::string_view, const std::string&);
  const std::vector<std::pair<Parser, std::string>> files = {
      {parse_obj_polygons, box_obj()},        {parse_obj_polygons, star_prism()[0]},
      {parse_ply_polygons, box_ply(false)},   {parse_ply_polygons, box_ply(true)},
      {parse_stl_polygons, box_stl_binary()}, {parse_stl_polygons, box_stl_text()}};
  std::mt19937 random(11);
  for (const auto& [parse, whole] : files)
    for (int round = 0; round < 2000; ++round) {
      std::string bytes = whole;
      for (int k = 0; k < 1 + round % 4; ++k) {
        const std::size_t at = random() % bytes.size();
        switch (random() % 4) {
          case 0:
            bytes[at] = static_cast<char>(random());
            break;
          case 1:
            bytes[at] = "0123456789-+/. \\\n"[random() % 17];
            break;
          case 2:
            bytes.erase(at, random() % 9);
            break;
          default:
            bytes.insert(at, bytes.substr(random() % bytes.size(), random() % 40));
        }
        if (bytes.empty()) bytes = " ";
      }
      Result<PolygonMesh> mesh = parse(bytes, "file");
      if (!mesh) {
        EXPECT_EQ(mesh.error().kind, ErrorKind::kContent);
        continue;
      }
      const std::size_t vertices = mesh->vertices.size();
      std::vector<std::string> notes;
      const RenderSurface surface = render_surface_of(std::move(*mesh), notes);
      ASSERT_TRUE(surface.sources_hold());
      ASSERT_EQ(surface.authored(), vertices);
      for (const Triangle& triangle : surface.triangles)
        for (const VertexId v : triangle)
          ASSERT_TRUE(v >= 0 && static_cast<std::size_t>(v) < surface.vertices.size());
    }
}

TEST_F(HostileSurface, NodesNestAsDeepAsTheyLike) {
  std::string nodes = "[";
  const int depth = 20'000;
  for (int i = 0; i + 1 < depth; ++i) nodes += "{\"children\":[" + std::to_string(i + 1) + "]},";
  nodes += "{\"mesh\":0}]";
  const Result<SurfaceFile> file =
      read_surface(folder.write("deep.gltf", box_gltf(data_uri(box_gltf_buffer()), nodes)));
  if (file)
    EXPECT_EQ(file->surface.triangles.size(), 12U);
  else
    EXPECT_EQ(file.error().kind, ErrorKind::kContent) << file.error().message;
}

TEST_F(HostileSurface, NodesThatDoubleAtEveryLevelEndAtALimit) {
#if defined(TREMOLO_SANITIZED)
  GTEST_SKIP() << "the address space of a sanitized process is not limited";
#endif
  std::string nodes = "[";
  for (int i = 0; i < 40; ++i) {
    const std::string next = std::to_string(i + 1);
    nodes += "{\"children\":[" + next + "," + next + "]},";
  }
  nodes += "{\"mesh\":0}]";
  const std::string path =
      folder.write("doubling.gltf", box_gltf(data_uri(box_gltf_buffer()), nodes));
  EXPECT_EQ(refusal(path, {.seconds = 20, .bytes = 50'000'000}).kind, ErrorKind::kContent);
}

TEST_F(HostileSurface, FilesElsewhereAreNotOpened) {
  std::filesystem::create_directories(folder.file("inside/deeper"));
  folder.write("secret.bin", box_gltf_buffer());
  folder.write("inside/deeper/good.bin", box_gltf_buffer());
  std::filesystem::create_symlink(folder.file("secret.bin"), folder.file("inside/link.bin"));
  ASSERT_EQ(::mkfifo(folder.file("inside/pipe.bin").c_str(), 0600), 0);
  for (const std::string& uri :
       {std::string("../secret.bin"), std::string("deeper/../../secret.bin"),
        std::string("link.bin"), std::string("pipe.bin")})
    expect_refused(folder.write("inside/scene.gltf", box_gltf(uri)), ErrorKind::kContent,
                   "no file in this folder: ");
  // assimp searches for this file below the folder.
  expect_refused(folder.write("inside/scene.gltf", box_gltf(folder.file("secret.bin"))),
                 ErrorKind::kContent);
  EXPECT_TRUE(read_surface(folder.write("inside/scene.gltf", box_gltf("deeper/good.bin"))));
}

TEST_F(HostileSurface, AFileThatIsALinkIsReadFromWhereItLeads) {
  folder.write("store.off", box_off());
  std::filesystem::create_directory(folder.file("view"));
  std::filesystem::create_symlink(folder.file("store.off"), folder.file("view/box.off"));
  EXPECT_TRUE(read_surface(folder.file("view/box.off")));
}

TEST_F(HostileSurface, ReadingTakesNoLongerThanItMay) {
  const Error error = refusal(folder.write("box.off", box_off()), {.seconds = 1e-6});
  EXPECT_EQ(error.kind, ErrorKind::kContent);
  EXPECT_NE(error.message.find("took longer than 1e-06 s"), std::string::npos) << error.message;
}

TEST_F(HostileSurface, ReadingTakesNoMoreMemoryThanItMay) {
#if defined(TREMOLO_SANITIZED)
  GTEST_SKIP() << "the address space of a sanitized process is not limited";
#endif
  // The child may also use what the heap of this process has free: then the surface is too large.
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (int i = 0; i < 200'000; ++i) text += "f 1 2 3\n";
  const std::string path = folder.write("large.obj", text);
  const Error error = refusal(path, {.bytes = 2'000'000});
  EXPECT_NE(error.message.find("more than 2 MB"), std::string::npos) << error.message;
  const Result<SurfaceFile> file = read_surface(path);
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->surface.triangles.size(), 200'000U);
}

}  // namespace
}  // namespace tremolo
