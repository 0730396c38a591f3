// The child's answer, whole and damaged.
#include "formats/surface/surface_answer.h"

#include <cmath>
#include <cstring>
#include <set>

#include <gtest/gtest.h>

namespace tremolo {
namespace {

SurfaceFile small_surface() {
  SurfaceFile file;
  RenderSurface& s = file.surface;
  s.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  s.triangles = {{0, 2, 1}, {0, 1, 3}};
  s.normals = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.6F, 0.8F, 0}};
  s.uvs = {{0, 0}, {1, 0}, {0, 1}, {0.5F, 0.5F}};
  s.colours = {{1, 2, 3, 4}, {5, 6, 7, 8}, {9, 10, 11, 12}, {255, 255, 255, 255}};
  s.object_of = {0, 1};
  s.material_of = {1, 0};
  s.objects = {"body", "Körper"};
  s.materials = {"steel", "glass"};
  file.format = "OFF";
  file.unit = "metres";
  file.metres_per_unit = 0.5;
  file.notes = {"first", "second"};
  return file;
}

void expect_promises_kept(const SurfaceFile& file) {
  const RenderSurface& s = file.surface;
  ASSERT_FALSE(s.triangles.empty());
  ASSERT_EQ(s.object_of.size(), s.triangles.size());
  ASSERT_EQ(s.material_of.size(), s.triangles.size());
  ASSERT_TRUE(s.normals.empty() || s.normals.size() == s.vertices.size());
  ASSERT_TRUE(s.uvs.empty() || s.uvs.size() == s.vertices.size());
  ASSERT_TRUE(s.colours.empty() || s.colours.size() == s.vertices.size());
  for (const Triangle& t : s.triangles)
    for (const VertexId v : t) ASSERT_TRUE(v >= 0 && std::size_t(v) < s.vertices.size());
  for (const std::uint32_t o : s.object_of) ASSERT_LT(o, s.objects.size());
  for (const std::uint32_t m : s.material_of) ASSERT_LT(m, s.materials.size());
  for (const auto& x : s.vertices) ASSERT_TRUE(x.allFinite());
  for (const auto& uv : s.uvs) ASSERT_TRUE(uv.allFinite());
  for (const auto& n : s.normals) ASSERT_NEAR(n.norm(), 1, 1e-3);
  ASSERT_TRUE(std::isfinite(file.metres_per_unit));
  for (const auto* names : {&s.objects, &s.materials}) {
    ASSERT_EQ(std::set<std::string>(names->begin(), names->end()).size(), names->size());
    for (const std::string& name : *names) ASSERT_TRUE(is_printable_text(name, kLongestName));
  }
}

TEST(SurfaceAnswer, ComesBackAsItWasSent) {
  const SurfaceFile sent = small_surface();
  const Result<SurfaceFile> got = decode_surface(encode_surface(sent));
  ASSERT_TRUE(got) << got.error().message;
  EXPECT_EQ(got->surface.vertices, sent.surface.vertices);
  EXPECT_EQ(got->surface.triangles, sent.surface.triangles);
  EXPECT_EQ(got->surface.normals, sent.surface.normals);
  EXPECT_EQ(got->surface.uvs, sent.surface.uvs);
  EXPECT_EQ(got->surface.colours, sent.surface.colours);
  EXPECT_EQ(got->surface.object_of, sent.surface.object_of);
  EXPECT_EQ(got->surface.material_of, sent.surface.material_of);
  EXPECT_EQ(got->surface.objects, sent.surface.objects);
  EXPECT_EQ(got->surface.materials, sent.surface.materials);
  EXPECT_EQ(got->format, sent.format);
  EXPECT_EQ(got->unit, sent.unit);
  EXPECT_EQ(got->metres_per_unit, sent.metres_per_unit);
  EXPECT_EQ(got->notes, sent.notes);
  const Result<SurfaceFile> refused = decode_surface(encode_refusal("no\x07 good"));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message, "no  good");
}

TEST(SurfaceAnswer, CutAnywhereItIsRefused) {
  const std::vector<std::byte> bytes = encode_surface(small_surface());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    const Result<SurfaceFile> got = decode_surface(std::span(bytes).first(length));
    ASSERT_FALSE(got) << length;
    EXPECT_EQ(got.error().kind, ErrorKind::kContent);
  }
  std::vector<std::byte> longer = bytes;
  longer.push_back(std::byte{0});
  EXPECT_FALSE(decode_surface(longer));
}

TEST(SurfaceAnswer, DamagedAnywhereItIsRefusedOrKeepsThePromises) {
  const std::vector<std::byte> bytes = encode_surface(small_surface());
  for (std::size_t at = 0; at < bytes.size(); ++at)
    for (const int value : {0x00, 0x01, 0x7f, 0x80, 0xff, 0x0a}) {
      std::vector<std::byte> damaged = bytes;
      damaged[at] = static_cast<std::byte>(value);
      const Result<SurfaceFile> got = decode_surface(damaged);
      if (got) expect_promises_kept(*got);
    }
}

TEST(SurfaceAnswer, EachBrokenPromiseIsSeen) {
  const auto refused = [](void (*break_it)(SurfaceFile&)) {
    SurfaceFile file = small_surface();
    break_it(file);
    return !decode_surface(encode_surface(file));
  };
  EXPECT_FALSE(refused([](SurfaceFile&) {}));
  EXPECT_TRUE(refused([](SurfaceFile& f) { f.surface.triangles[1][2] = 4; }));
  EXPECT_TRUE(refused([](SurfaceFile& f) { f.surface.triangles[0][0] = -1; }));
  EXPECT_TRUE(refused([](SurfaceFile& f) { f.surface.vertices[1].y() = std::nan(""); }));
  EXPECT_TRUE(refused([](SurfaceFile& f) { f.surface.uvs[1].y() = INFINITY; }));
  EXPECT_TRUE(refused([](SurfaceFile& f) { f.surface.normals[1].setZero(); }));
  EXPECT_TRUE(refused([](SurfaceFile& f) { f.surface.object_of[0] = 2; }));
  EXPECT_TRUE(refused([](SurfaceFile& f) { f.surface.material_of[0] = 2; }));
  EXPECT_TRUE(refused([](SurfaceFile& f) { f.surface.objects[1] = "body"; }));
  EXPECT_TRUE(refused([](SurfaceFile& f) { f.surface.objects[1] = "a\tb"; }));
  EXPECT_TRUE(refused([](SurfaceFile& f) { f.surface.materials.clear(); }));
  EXPECT_TRUE(refused([](SurfaceFile& f) { f.notes[1] = "\x1b[2J"; }));
  EXPECT_TRUE(refused([](SurfaceFile& f) { f.metres_per_unit = INFINITY; }));
  EXPECT_TRUE(refused([](SurfaceFile& f) {
    f.surface.triangles.clear();
    f.surface.object_of.clear();
    f.surface.material_of.clear();
  }));
}

TEST(SurfaceAnswer, ARefusalSaysWhy) {
  const Result<SurfaceFile> decoded = decode_surface(encode_refusal("a hole"));
  ASSERT_FALSE(decoded);
  EXPECT_EQ(decoded.error().message, "a hole");
  for (const char* text : {"", "  "}) {
    const Result<SurfaceFile> silent = decode_surface(encode_refusal(text));
    ASSERT_FALSE(silent);
    EXPECT_NE(silent.error().message.find("without words"), std::string::npos);
  }
}

TEST(SurfaceAnswer, TextIsMadePrintable) {
  EXPECT_EQ(printable_text("Körper 球 🎻", 100), "Körper 球 🎻");
  EXPECT_EQ(printable_text("a\nb\x7f", 100), "a b ");
  EXPECT_EQ(printable_text("\xc2\x9b[0m", 100), " [0m");  // a control of the second set
  EXPECT_EQ(printable_text("\xff\xc0\x80", 100), "???");  // no such bytes, overlong
  EXPECT_EQ(printable_text("\xed\xa0\x80", 100), "???");  // half of a surrogate pair
  EXPECT_EQ(printable_text("\xf4\x90\x80\x80\xe2\x82", 100), "??????");  // too high, cut
  EXPECT_EQ(printable_text("aäa", 2), "a");
  EXPECT_FALSE(is_printable_text(std::string_view("a\0b", 3), 10));
  EXPECT_FALSE(is_printable_text("long", 3));
}

}  // namespace
}  // namespace tremolo
