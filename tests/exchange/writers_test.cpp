// The bytes of short files, and refused animations. tests/exchange/readers.sh checks them with
// other programs.
#include <bit>
#include <cstring>
#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "runtime/io/exchange/animation_writer.h"
#include "runtime/io/exchange/glb_writer.h"
#include "runtime/io/exchange/json_text.h"
#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/wavy_animation.h"

namespace tremolo {
namespace {

using testing::slurp;
using testing::TemporaryFolder;
using testing::wavy_animation;
using testing::wavy_sheet;

std::size_t files_in(const std::string& folder) {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    count += entry.is_regular_file() ? 1 : 0;
  return count;
}

TEST(GlbWriter, TenSecondsOfThirtyCoordinatesAreAsLargeAsTheyMustBe) {
  const TemporaryFolder folder;
  constexpr std::size_t kVertices = 40 * 40, kModes = 30, kKeys = 601;
  const Animation animation = wavy_animation(40, kModes, kKeys);
  const auto report = write_glb(folder.file("sheet.glb"), animation);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->bytes, std::filesystem::file_size(folder.file("sheet.glb")));
  EXPECT_LE(static_cast<double>(report->bytes),
            1.3 * (24.0 * kVertices * (kModes + 1) + 4.0 * kModes * kKeys));
  EXPECT_LE(report->position_error, 1e-6);
  EXPECT_EQ(report->targets, kModes);
}

TEST(GlbWriter, TenThousandTargetsAreRefusedWithAWord) {
  const TemporaryFolder folder;
  const Animation animation = wavy_animation(3, 10000, 2);
  for (const bool plain : {false, true}) {
    GlbOptions options;
    options.plain = plain;
    const auto report = write_glb(folder.file("sheet.glb"), animation, options);
    ASSERT_FALSE(report);
    EXPECT_EQ(report.error().kind, ErrorKind::kContent);
    EXPECT_NE(report.error().message.find("10000 coordinates"), std::string::npos)
        << report.error().message;
  }
  EXPECT_EQ(files_in(folder.path()), 0U);
  // The same model at rest has none of them.
  Animation still = animation;
  std::fill(still.bodies[0].q.begin(), still.bodies[0].q.end(), 0.0);
  const auto report = write_glb(folder.file("still.glb"), still);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->targets, 0U);
  EXPECT_EQ(report->dropped, 10000U);
}

// The file's chunk of JSON.
nlohmann::json glb_json(const std::string& path) {
  const std::string bytes = slurp(path);
  std::uint32_t size = 0;
  std::memcpy(&size, bytes.data() + 12, sizeof(size));
  return nlohmann::json::parse(bytes.substr(20, size), nullptr, false);
}

// Each has a position, which takes no bytes, and a weight in each frame.
TEST(GlbWriter, TargetsOfNormalsStandBehindTheOthersAndMoveNothing) {
  const TemporaryFolder folder;
  const Animation animation = wavy_animation(9, 4, 30, 0.12);
  const std::string path = folder.file("sheet.glb");
  const auto without = write_glb(path, animation);
  ASSERT_TRUE(without) << without.error().message;
  GlbOptions options;
  options.normal_targets = 6;
  const auto report = write_glb(path, animation, options);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->targets, 4U);
  EXPECT_EQ(report->normal_targets, 6U);
  EXPECT_LT(report->normal_max, 0.2 * without->normal_max);
  EXPECT_EQ(report->position_error, without->position_error);
  // Normals and weights, and what the JSON says of them.
  EXPECT_LE(report->bytes - without->bytes, 6U * (12U * 81U + 4U * 30U) + 6U * 400U);
  const nlohmann::json json = glb_json(path);
  const auto& mesh = json["meshes"][0];
  EXPECT_EQ(mesh["weights"].size(), 10U);
  EXPECT_EQ(mesh["extras"]["targetNames"][4], "normal0");
  for (const auto& primitive : mesh["primitives"]) {
    ASSERT_EQ(primitive["targets"].size(), 10U);
    for (std::size_t k = 4; k < 10; ++k) {
      const auto& target = primitive["targets"][k];
      const auto& still = json["accessors"][target["POSITION"].get<std::size_t>()];
      EXPECT_FALSE(still.contains("bufferView"));
      EXPECT_EQ(still["count"], 81);
      EXPECT_EQ(still["max"], nlohmann::json({0, 0, 0}));
      EXPECT_TRUE(json["accessors"][target["NORMAL"].get<std::size_t>()].contains("bufferView"));
    }
  }
  const auto& channels = json["animations"][0]["channels"];
  for (const auto& channel : channels)
    if (channel["target"]["path"] == "weights") {
      const auto& sampler =
          json["animations"][0]["samplers"][channel["sampler"].get<std::size_t>()];
      EXPECT_EQ(json["accessors"][sampler["output"].get<std::size_t>()]["count"], 10 * 30);
    }
  options.normal_targets = kMostGlbTargets - 3;
  const auto refused = write_glb(folder.file("more.glb"), animation, options);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("at most 252 of normals"), std::string::npos)
      << refused.error().message;
}

TEST(GlbWriter, ATextureThatLiesNowhereIsRefused) {
  const TemporaryFolder folder;
  const Animation animation = wavy_animation(3, 2, 3);
  const std::string png = folder.write("paint.png", "\x89PNG\r\n\x1a\n and so on");
  const std::string text = folder.write("paint.txt", "no picture");
  const auto refused = [&](const GlbTexture& texture, const char* word) {
    GlbOptions options;
    options.textures = {texture};
    const auto report = write_glb(folder.file("sheet.glb"), animation, options);
    ASSERT_FALSE(report) << word;
    EXPECT_NE(report.error().message.find(word), std::string::npos) << report.error().message;
  };
  refused({"middle", png}, "'left', 'right'");
  refused({"left", text}, ".png or a .jpg");
  refused({"", folder.file("none.png")}, "none.png");
  EXPECT_EQ(files_in(folder.path()), 2U);
  GlbOptions options;
  options.textures = {{"left", png}};
  EXPECT_TRUE(write_glb(folder.file("sheet.glb"), animation, options));
  EXPECT_NE(slurp(folder.file("sheet.glb")).find("\x89PNG\r\n\x1a\n and so on"), std::string::npos);
}

TEST(PointCache, Pc2IsLittleAndMddBigEndian) {
  const TemporaryFolder folder;
  Animation animation = wavy_animation(2, 1, 3);
  ASSERT_TRUE(write_pc2(folder.file("a.pc2"), animation, 0));
  ASSERT_TRUE(write_mdd(folder.file("a.mdd"), animation, 0));
  const std::string pc2 = slurp(folder.file("a.pc2")), mdd = slurp(folder.file("a.mdd"));
  ASSERT_EQ(pc2.size(), 32U + 3 * 4 * 12);
  ASSERT_EQ(mdd.size(), 8U + 3 * 4 + 3 * 4 * 12);
  EXPECT_EQ(pc2.substr(0, 32),
            std::string("POINTCACHE2\0\1\0\0\0\4\0\0\0\0\0\0\0\0\0\x80\x3f\3\0\0\0", 32));
  EXPECT_EQ(mdd.substr(0, 8), std::string("\0\0\0\3\0\0\0\4", 8));
  std::vector<double> places(12);
  for (std::size_t f = 0; f < 3; ++f) {
    world_positions(animation, animation.bodies[0], f, places);
    for (std::size_t i = 0; i < 12; ++i) {
      float little = 0.0f, big = 0.0f;
      std::memcpy(&little, pc2.data() + 32 + 48 * f + 4 * i, 4);
      std::string turned = mdd.substr(20 + 48 * f + 4 * i, 4);
      std::reverse(turned.begin(), turned.end());
      std::memcpy(&big, turned.data(), 4);
      EXPECT_EQ(little, static_cast<float>(places[i]));
      EXPECT_EQ(big, static_cast<float>(places[i]));
    }
  }
}

// Vertices that are copies for their normals or texture coordinates are not the author's: a cache
// with them would not fit his mesh.
TEST(PointCache, HasTheVerticesOfTheAuthorsFileInTheirOrder) {
  const TemporaryFolder folder;
  const Animation plain = wavy_animation(3, 2, 4);
  Animation split = plain;
  AnimatedShape& shape = split.shapes[0];
  RenderSurface& surface = shape.surface;
  for (VertexId v = 0; v < 9; ++v) surface.sources.push_back(v);
  for (const VertexId source : {4, 0, 4}) {
    const auto copy = static_cast<VertexId>(surface.vertices.size());
    surface.vertices.push_back(Eigen::Vector3d(surface.vertices[source]));
    surface.uvs.emplace_back(0.5F, 0.25F);
    surface.sources.push_back(source);
    surface.triangles.back()[1] = copy;
  }
  BasisRows modes(3 * 12, shape.modes.cols());
  for (Eigen::Index v = 0; v < 12; ++v)
    modes.middleRows(3 * v, 3) = shape.modes.middleRows(3 * surface.sources[v], 3);
  shape.modes = modes;
  for (const char* name : {"a.pc2", "a.mdd"}) {
    ASSERT_TRUE(write_point_caches(folder.file(name), plain));
    const std::string expected = slurp(folder.file(name));
    ASSERT_TRUE(write_point_caches(folder.file(name), split));
    EXPECT_EQ(slurp(folder.file(name)), expected) << name;
    // The rest shape beside it: nine vertices, twelve texture coordinates.
    const std::string obj = slurp(folder.file("a.obj"));
    const auto lines = [&obj](const std::string& head) {
      std::size_t count = obj.starts_with(head) ? 1 : 0;
      for (std::size_t at = obj.find("\n" + head); at != std::string::npos;
           at = obj.find("\n" + head, at + 1))
        ++count;
      return count;
    };
    EXPECT_EQ(lines("v "), 9U);
    EXPECT_EQ(lines("vt "), 12U);
    EXPECT_NE(obj.find("5/12"), std::string::npos) << "vertex 5 with the copy's coordinates";
  }
}

TEST(PointCache, SeveralBodiesAreAFileEachWithItsRestShape) {
  const TemporaryFolder folder;
  Animation animation = wavy_animation(3, 2, 2);
  animation.bodies.push_back(animation.bodies[0]);
  animation.bodies[1].name = "a/b";
  AnimatedBody floor = animation.bodies[0];
  floor.name = "floor";
  floor.collider = true;
  animation.bodies.push_back(floor);
  const auto files = write_point_caches(folder.file("all.mdd"), animation);
  ASSERT_TRUE(files) << files.error().message;
  std::vector<std::string> names;
  for (const WrittenFile& file : *files) {
    names.push_back(std::filesystem::path(file.path).filename().string());
    EXPECT_EQ(std::filesystem::file_size(file.path), file.bytes);
  }
  EXPECT_EQ(names, (std::vector<std::string>{"all-sheet.mdd", "all-sheet.obj", "all-a_b.mdd",
                                             "all-a_b.obj"}));
  animation.bodies[0].name = "a?b";
  EXPECT_FALSE(write_point_caches(folder.file("all.mdd"), animation)) << "one file for two";
}

TEST(Series, WhatStandsStillIsWrittenOnce) {
  const TemporaryFolder folder;
  Animation animation = wavy_animation(3, 2, 4);
  AnimatedShape still = wavy_sheet(3, 0);
  AnimatedBody floor;
  floor.name = "floor";
  floor.shape = 1;
  floor.collider = true;
  floor.poses.resize(4);
  animation.shapes.push_back(still);
  animation.bodies.push_back(floor);
  const auto pvd = write_pvd(folder.file("s.pvd"), animation);
  ASSERT_TRUE(pvd) << pvd.error().message;
  EXPECT_EQ(pvd->size(), 1U + 4 + 1);
  const auto series = write_surface_series(folder.file("s.obj"), animation);
  ASSERT_TRUE(series) << series.error().message;
  EXPECT_EQ(series->size(), 1U + 4);
  EXPECT_NE(slurp(folder.file("s.csv")).find("3,0.05,sheet,s-0003.obj"), std::string::npos);
  EXPECT_FALSE(write_surface_series(folder.file("s.stl"), animation));
}

// Frames 0 and 3 are without the body.
TEST(AnimationWriter, ABodyThatComesAndGoesIsHiddenOrRefused) {
  const TemporaryFolder folder;
  Animation animation = wavy_animation(3, 2, 4);
  animation.bodies.push_back(animation.bodies[0]);
  animation.bodies[1].name = "guest";
  animation.bodies[1].shown = {0, 1, 1, 0};
  ASSERT_TRUE(write_usda(folder.file("a.usda"), animation));
  const std::string usda = slurp(folder.file("a.usda"));
  const std::size_t at = usda.find("token visibility.timeSamples = {\n");
  ASSERT_NE(at, std::string::npos);
  EXPECT_GT(at, usda.find("def Mesh \"guest\""));
  EXPECT_NE(usda.find("0: \"invisible\",\n            1: \"inherited\",\n            2: "
                      "\"inherited\",\n            3: \"invisible\",\n",
                      at),
            std::string::npos);
  ASSERT_TRUE(write_glb(folder.file("a.glb"), animation));
  const nlohmann::json json = glb_json(folder.file("a.glb"));
  int sizes = 0;
  for (const auto& channel : json["animations"][0]["channels"]) {
    if (channel["target"]["path"] != "scale") continue;
    ++sizes;
    EXPECT_EQ(json["nodes"][channel["target"]["node"].get<std::size_t>()]["name"], "guest");
    const auto& sampler = json["animations"][0]["samplers"][channel["sampler"].get<std::size_t>()];
    EXPECT_EQ(sampler["interpolation"], "STEP");
    EXPECT_EQ(json["accessors"][sampler["output"].get<std::size_t>()]["count"], 4);
  }
  EXPECT_EQ(sizes, 1);
  const auto pvd = write_pvd(folder.file("a.pvd"), animation);
  ASSERT_TRUE(pvd) << pvd.error().message;
  EXPECT_EQ(pvd->size(), 1U + 4 + 2);
  const auto series = write_surface_series(folder.file("a.ply"), animation);
  ASSERT_TRUE(series) << series.error().message;
  EXPECT_EQ(series->size(), 1U + 4 + 2);
  EXPECT_EQ(slurp(folder.file("a.csv")).find("guest,a-guest-0003.ply"), std::string::npos);
  for (const char* name : {"a.pc2", "a.mdd"}) {
    const std::size_t before = files_in(folder.path());
    const auto cache = write_animation(folder.file(name), animation);
    ASSERT_FALSE(cache);
    EXPECT_EQ(cache.error().kind, ErrorKind::kUsage);
    EXPECT_NE(cache.error().message.find("'guest' comes or goes"), std::string::npos);
    EXPECT_EQ(files_in(folder.path()), before);
  }
  animation.bodies[1].shown.pop_back();
  EXPECT_FALSE(write_usda(folder.file("a.usda"), animation));
}

TEST(Usda, NamesAreIdentifiersAndTimesExact) {
  const TemporaryFolder folder;
  Animation animation = wavy_animation(3, 1, 3);
  animation.times = {0.0, 0.018, 0.033};
  animation.bodies[0].name = "2nd horse";
  ASSERT_TRUE(write_usda(folder.file("a.usda"), animation));
  const std::string text = slurp(folder.file("a.usda"));
  EXPECT_TRUE(text.starts_with("#usda 1.0\n"));
  EXPECT_NE(text.find("def Mesh \"_2nd_horse\""), std::string::npos);
  EXPECT_NE(text.find("upAxis = \"Z\""), std::string::npos);
  EXPECT_NE(text.find("            1.08: ["), std::string::npos) << "0.018 s times 60";
  EXPECT_NE(text.find("def GeomSubset \"right\""), std::string::npos);
}

TEST(AnimationWriter, TheEndingChooses) {
  const TemporaryFolder folder;
  const Animation animation = wavy_animation(3, 2, 2);
  for (const char* name : {"a.glb", "a.usda", "a.pvd", "a.pc2", "a.mdd", "a.ply"})
    EXPECT_TRUE(write_animation(folder.file(name), animation)) << name;
  const auto other = write_animation(folder.file("a.fbx"), animation);
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().kind, ErrorKind::kUsage);
  for (const char* name : {"no/a.glb", "no/a.usda", "no/a.pc2"}) {
    const auto nowhere = write_animation(folder.file(name), animation);
    ASSERT_FALSE(nowhere) << name;
    EXPECT_EQ(nowhere.error().kind, ErrorKind::kSystem) << name;
  }
}

TEST(JsonText, AStringIsJsonWhateverItHolds) {
  EXPECT_EQ(json_string("a \"b\"\\\n"), "\"a \\\"b\\\"\\\\\\u000a\"");
  EXPECT_EQ(json_string("H\xc3\xa4nsel"), "\"H\xc3\xa4nsel\"");
  EXPECT_EQ(json_string("H\xe4nsel"), "\"H?nsel\"");
  EXPECT_EQ(json_string("\xc0\x80\xed\xa0\x80"), "\"?????\"") << "no overlong forms, no halves";
  EXPECT_EQ(json_number(0.1f), "0.1");
  EXPECT_EQ(json_numbers(std::vector<double>{1.0, -0.25}), "[1,-0.25]");
}

}  // namespace
}  // namespace tremolo
