// The render surface in a basis file (version 1.2): bytes as specified, and nothing in it is
// trusted.
#include <cstring>
#include <limits>

#include <gtest/gtest.h>

#include "formats/basis/basis_writer.h"
#include "tests/support/basis_bytes.h"
#include "tests/support/tiny_render.h"

namespace tremolo {
namespace {

using namespace basis_layout;
using namespace testing;

const char* const kGoldenRender =
    TREMOLO_SOURCE_DIR "/tests/formats/golden/tiny-render-1.2.tremolo";

constexpr std::string_view kNeeded[] = {kRenderRest,      kRenderBasis,   kRenderAnchors,
                                        kRenderTriangles, kRenderObjects, kRenderMaterials,
                                        kObjectNames,     kMaterialNames};
constexpr std::string_view kAdded[] = {kRenderNormals, kRenderUvs, kRenderColours};

Bytes render_bytes(BasisEncoding encoding = BasisEncoding::kFull) {
  return *encode_basis(tiny_render_basis(), encoding);
}

void expect_equal_surfaces(const RenderSurface& a, const RenderSurface& b) {
  EXPECT_EQ(a.vertices, b.vertices);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.normals, b.normals);
  EXPECT_EQ(a.uvs, b.uvs);
  EXPECT_EQ(a.colours, b.colours);
  EXPECT_EQ(a.object_of, b.object_of);
  EXPECT_EQ(a.material_of, b.material_of);
  EXPECT_EQ(a.objects, b.objects);
  EXPECT_EQ(a.materials, b.materials);
}

void expect_refused(Bytes bytes, const std::string& what) {
  reseal(bytes);
  const auto data = decode(bytes);
  ASSERT_FALSE(data) << what;
  EXPECT_EQ(data.error().kind, ErrorKind::kContent) << what;
}

TEST(RenderFile, WritesTheGoldenBytesOfVersionOneTwo) {
  EXPECT_EQ(render_bytes(), read_file(kGoldenRender));
}

TEST(RenderFile, ReadsTheGoldenFileOfVersionOneTwo) {
  const auto data = read_basis(kGoldenRender);
  ASSERT_TRUE(data) << data.error().message;
  expect_equal(*data, tiny_basis());
  ASSERT_TRUE(data->render);
  expect_equal_surfaces(data->render->surface, tiny_render().surface);
  EXPECT_EQ(data->render->rows, tiny_render().rows);
  EXPECT_EQ(data->render->anchors, tiny_render().anchors);
  EXPECT_EQ(data->render->column_scales.size(), 0);
}

TEST(RenderFile, WhatASurfaceDoesNotHaveIsNotInTheFile) {
  BasisData full = tiny_render_basis();
  full.render->surface.normals.clear();
  full.render->surface.uvs.clear();
  full.render->surface.colours.clear();
  const Bytes bytes = *encode_basis(full);
  const auto reader = BasisReader::from_memory(bytes);
  ASSERT_TRUE(reader);
  for (const std::string_view section : kAdded) EXPECT_FALSE(reader->has(section));
  const auto data = decode(bytes);
  ASSERT_TRUE(data) << data.error().message;
  expect_equal_surfaces(data->render->surface, full.render->surface);
}

TEST(RenderFile, ACompactFileKeepsItsRowsWithinHalfAStepAndTheRestExactly) {
  BasisData full = tiny_render_basis();
  full.render->rows *= 40.0;  // larger than the hull's: they set the scale then
  const auto data = decode(*encode_basis(full, BasisEncoding::kCompact));
  ASSERT_TRUE(data) << data.error().message;
  ASSERT_TRUE(data->render);
  expect_equal_surfaces(data->render->surface, full.render->surface);
  ASSERT_EQ(data->render->column_scales.size(), 2);
  EXPECT_EQ(data->render->column_scales, data->surface.column_scales);
  for (Eigen::Index i = 0; i < 2; ++i)
    // 1e-10: the division by the scale rounds.
    EXPECT_LE((data->render->rows - full.render->rows).col(i).cwiseAbs().maxCoeff(),
              full.render->rows.col(i).cwiseAbs().maxCoeff() / 32767 / 2 * (1 + 1e-10));
}

// A reader of 1.1 knows the element types and skips optional sections that it does not know.
TEST(RenderFile, AnOlderReaderMaySkipEverySectionOfIt) {
  const Bytes with = render_bytes();
  const auto reader = BasisReader::from_memory(with);
  ASSERT_TRUE(reader);
  EXPECT_EQ(reader->minor_version(), 2);
  for (const auto& names : {std::span<const std::string_view>(kNeeded), {kAdded}})
    for (const std::string_view name : names)
      EXPECT_EQ(get<std::uint32_t>(with, entry_of(with, name) + entry::kFlagsAt), 0u) << name;
}

TEST(RenderFile, ATruncatedFileIsRefusedAtEveryLength) {
  for (const BasisEncoding encoding : {BasisEncoding::kFull, BasisEncoding::kCompact}) {
    const Bytes bytes = render_bytes(encoding);
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      const Bytes cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
      EXPECT_FALSE(decode(cut)) << "length " << length;
    }
  }
}

TEST(RenderFile, AnyDamagedByteIsNoticed) {
  const Bytes bytes = render_bytes();
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    Bytes damaged = bytes;
    damaged[at] ^= std::byte{0x81};
    EXPECT_FALSE(decode(damaged)) << "byte " << at;
  }
}

TEST(RenderFile, NoFieldValueIsTrusted) {
  expect_no_field_is_trusted(render_bytes());
  expect_no_field_is_trusted(render_bytes(BasisEncoding::kCompact));
}

TEST(RenderFile, ItsSectionsComeTogether) {
  for (const std::string_view section : kNeeded) {
    Bytes bytes = render_bytes();
    std::memcpy(bytes.data() + entry_of(bytes, section), "another", 8);
    expect_refused(bytes, std::string(section));
  }
  for (const std::string_view section : kAdded) {
    Bytes bytes = render_bytes();
    for (std::size_t i = 0; i < std::size(kNeeded); ++i) {
      std::byte* name = bytes.data() + entry_of(bytes, kNeeded[i]);
      std::memset(name, 0, kNameSize);
      std::memcpy(name, "xyz", 3);
      name[3] = static_cast<std::byte>('0' + i);
    }
    expect_refused(bytes, std::string(section));
  }
}

TEST(RenderFile, IndicesThatNameNothingAreRefused) {
  for (const auto& [section, bound] : {std::pair{kRenderTriangles, 6u},
                                       {kRenderAnchors, 5u},
                                       {kRenderObjects, 2u},
                                       {kRenderMaterials, 1u}}) {
    Bytes bytes = render_bytes();
    put(bytes, offset_of(bytes, section), std::uint32_t{bound});
    expect_refused(bytes, std::string(section));
  }
}

TEST(RenderFile, ValuesThatAreNotFiniteAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const std::string_view section : {kRenderRest, kRenderBasis}) {
    Bytes bytes = render_bytes();
    put(bytes, offset_of(bytes, section) + 8, nan);
    expect_refused(bytes, std::string(section));
  }
  for (const std::string_view section : {kRenderNormals, kRenderUvs}) {
    Bytes bytes = render_bytes();
    put(bytes, offset_of(bytes, section) + 4, std::numeric_limits<float>::infinity());
    expect_refused(bytes, std::string(section));
  }
}

TEST(RenderFile, NamesThatDoNotEndAreRefused) {
  for (const std::string_view section : {kObjectNames, kMaterialNames}) {
    Bytes bytes = render_bytes();
    const auto size = get<std::uint64_t>(bytes, entry_of(bytes, section) + entry::kSizeAt);
    put(bytes, offset_of(bytes, section) + size - 1, 'x');
    expect_refused(bytes, std::string(section));
  }
}

TEST(RenderFile, TheWriterRefusesASurfaceWhosePartsDoNotFit) {
  for (int member = 0; member < 14; ++member) {
    BasisData data = tiny_render_basis();
    RenderBlock& render = *data.render;
    RenderSurface& surface = render.surface;
    if (member == 0) surface.vertices.pop_back();
    if (member == 1) surface.triangles.pop_back();
    if (member == 2) surface.normals.pop_back();
    if (member == 3) surface.uvs.pop_back();
    if (member == 4) surface.colours.pop_back();
    if (member == 5) surface.object_of[0] = 2;
    if (member == 6) surface.material_of[0] = 1;
    if (member == 7) surface.objects.clear();
    if (member == 8) surface.materials[0].push_back('\0');
    if (member == 9) surface.triangles[0][1] = 6;
    if (member == 10) surface.triangles[0][1] = -1;
    if (member == 11) render.anchors[0] = 5;
    if (member == 12) render.rows.conservativeResize(18, 1);
    if (member == 13) render = RenderBlock{};
    EXPECT_FALSE(encode_basis(data)) << member;
  }
}

}  // namespace
}  // namespace tremolo
