// The basis file: bytes as specified, and a reader that trusts nothing.

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "formats/basis/basis_reader.h"
#include "formats/basis/basis_writer.h"
#include "formats/basis/derived_basis.h"
#include "formats/sound/wav_writer.h"
#include "tests/support/basis_bytes.h"
#include "tests/support/sample_basis.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_basis.h"

namespace tremolo {
namespace {

using namespace basis_layout;
using namespace testing;

Bytes tiny_bytes() {
  return *encode_basis(tiny_basis());
}

TEST(BasisFile, WritesTheGoldenBytesOfVersionOneZero) {
  EXPECT_EQ(tiny_bytes(), read_file(TREMOLO_SOURCE_DIR "/tests/formats/golden/tiny-1.0.tremolo"));
}

TEST(BasisFile, ReadsTheGoldenFileOfVersionOneZero) {
  const auto data = read_basis(TREMOLO_SOURCE_DIR "/tests/formats/golden/tiny-1.0.tremolo");
  ASSERT_TRUE(data) << data.error().message;
  expect_equal(*data, tiny_basis());
}

TEST(BasisFile, WhatIsWrittenIsRead) {
  const std::string path = testing::fresh_folder() + "/round-trip.tremolo";
  const auto written = write_basis(path, tiny_basis());
  ASSERT_TRUE(written) << written.error().message;
  const auto data = read_basis(path);
  ASSERT_TRUE(data) << data.error().message;
  expect_equal(*data, tiny_basis());
}

TEST(BasisFile, ElementsThatAreKeptAreReadAndThoseThatAreNoneRefused) {
  BasisData data = tiny_basis();
  data.elements.corners = {{0, 1, 2, 3}, {0, 1, 2, 4}, {0, 1, 3, 4}, {1, 2, 3, 4}};
  data.elements.masses = {1.0, 2.0, 3.0, 4.0};
  const Bytes bytes = *encode_basis(data);
  const auto read = decode(bytes);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->elements.corners, data.elements.corners);
  EXPECT_EQ(read->elements.masses, data.elements.masses);
  expect_equal(*read, tiny_basis());
  Bytes changed = bytes;
  put(changed, offset_of(changed, kTetrahedra), std::uint32_t{5});
  reseal(changed);
  EXPECT_FALSE(decode(changed));
  for (const double mass : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    changed = bytes;
    put(changed, offset_of(changed, kTetrahedronMasses), mass);
    reseal(changed);
    EXPECT_FALSE(decode(changed)) << mass;
  }
  data.elements.masses.pop_back();
  EXPECT_FALSE(encode_basis(data));
}

TEST(BasisFile, BytesAtAnOddAddressAreReadToo) {
  const Bytes bytes = tiny_bytes();
  Bytes shifted(bytes.size() + 1);
  std::memcpy(shifted.data() + 1, bytes.data(), bytes.size());
  auto reader = BasisReader::from_memory(std::span(shifted).subspan(1));
  ASSERT_TRUE(reader) << reader.error().message;
  const auto data = read_basis(*reader);
  ASSERT_TRUE(data) << data.error().message;
  expect_equal(*data, tiny_basis());
}

TEST(BasisFile, ATruncatedFileIsRefusedAtEveryLength) {
  const Bytes bytes = tiny_bytes();
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    // A buffer of exactly that length: one byte too far is an error under AddressSanitizer.
    const Bytes cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
    EXPECT_FALSE(decode(cut)) << "length " << length;
  }
}

TEST(BasisFile, AnyDamagedByteIsNoticed) {
  testing::expect_every_damaged_byte_is_noticed(tiny_bytes());
}

TEST(BasisFile, AppendedBytesAreRefused) {
  Bytes bytes = tiny_bytes();
  bytes.resize(bytes.size() + kAlignment);
  EXPECT_FALSE(decode(bytes));
  put(bytes, header::kFileSizeAt, static_cast<std::uint64_t>(bytes.size()));
  reseal(bytes);
  EXPECT_FALSE(decode(bytes));
}

TEST(BasisFile, NoFieldValueIsTrusted) {
  expect_no_field_is_trusted(tiny_bytes());
}

// Every entry of `dimensions` set to hostile values with right checksums.
TEST(BasisFile, DimensionsMustFitTheSections) {
  const Bytes bytes = tiny_bytes();
  const std::size_t at = offset_of(bytes, kDimensions);
  for (std::size_t d = 0; d < dimension::kCount; ++d) {
    if (d == dimension::kTetrahedra || d == dimension::kLinearModes || d == dimension::kRigid)
      continue;  // counts for the reader's information: no section has their size
    for (std::uint64_t value : {std::uint64_t{0}, std::uint64_t{3}, std::uint64_t{1} << 31,
                                std::uint64_t{1} << 61, ~std::uint64_t{0}}) {
      Bytes changed = bytes;
      put(changed, at + 8 * d, value);
      reseal(changed);
      EXPECT_FALSE(decode(changed)) << "dimension " << d << " = " << value;
    }
  }
}

TEST(BasisFile, ValuesThatMakeNoSenseAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinite = std::numeric_limits<double>::infinity();
  for (std::string_view section : {kLambda, kCubic, kQuartic, kSurfaceRest, kSurfaceBasis,
                                   kInteriorBasis, kLoadForces, kSingularValues})
    for (double value : {nan, infinite}) {
      Bytes changed = tiny_bytes();
      put(changed, offset_of(changed, section), value);
      reseal(changed);
      EXPECT_FALSE(decode(changed)) << section;
    }
  for (std::string_view section : {kSurfaceIds, kTriangles, kInteriorIds, kFixedIds, kLoadIds}) {
    Bytes changed = tiny_bytes();
    put(changed, offset_of(changed, section), std::uint32_t{5});
    reseal(changed);
    EXPECT_FALSE(decode(changed)) << section;
  }
  for (double value : {-1.0, 0.0, 1e6}) {  // negative, zero, larger than its successor
    Bytes changed = tiny_bytes();
    put(changed, offset_of(changed, kLambda), value);
    reseal(changed);
    EXPECT_FALSE(decode(changed)) << value;
  }
}

TEST(BasisFile, AnUnknownOptionalSectionIsSkippedAndACriticalOneRefused) {
  Bytes bytes = tiny_bytes();
  const std::size_t at = entry_of(bytes, kSingularValues);
  std::memcpy(bytes.data() + at, "from_the_future", 16);
  reseal(bytes);
  const auto data = decode(bytes);
  ASSERT_TRUE(data) << data.error().message;
  EXPECT_TRUE(data->singular_values.empty());
  put(bytes, at + entry::kFlagsAt, kCritical);
  reseal(bytes);
  const auto refused = decode(bytes);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("from_the_future"), std::string::npos);
}

TEST(BasisFile, AnErrorNamesFileSectionAndOffset) {
  Bytes bytes = tiny_bytes();
  const std::size_t at = offset_of(bytes, kQuartic);
  bytes[at + 3] ^= std::byte{4};
  auto reader = BasisReader::from_memory(bytes, "damaged.tremolo");
  ASSERT_TRUE(reader) << "the damage is inside a section: found on first use";
  const auto values = reader->doubles(kQuartic);
  ASSERT_FALSE(values);
  EXPECT_EQ(values.error().kind, ErrorKind::kContent);
  EXPECT_NE(values.error().message.find("damaged.tremolo: quartic at byte " + std::to_string(at)),
            std::string::npos)
      << values.error().message;
  EXPECT_TRUE(reader->doubles(kCubic)) << "other sections can still be used";
}

TEST(BasisFile, ASectionWhoseCompanionIsMissingIsRefusedWithBothNames) {
  for (const auto& [gone, alone] :
       {std::pair{kLoadIds, kLoadForces}, std::pair{kLoadForces, kLoadIds}}) {
    Bytes bytes = tiny_bytes();
    std::byte* name = bytes.data() + entry_of(bytes, gone);
    std::memset(name, 0, kNameSize);
    std::memcpy(name, "other", 5);
    reseal(bytes);
    const auto refused = decode(bytes);
    ASSERT_FALSE(refused);
    for (const std::string_view section : {gone, alone})
      EXPECT_NE(refused.error().message.find(section), std::string::npos)
          << refused.error().message;
  }
}

TEST(BasisFile, ThePageOfTheFormatNamesEverySection) {
  std::ifstream file(TREMOLO_SOURCE_DIR "/docs/basis-format.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  for (const SectionShape& shape : section_shapes({})) {
    EXPECT_NE(page.find('`' + std::string(shape.name) + '`'), std::string::npos) << shape.name;
  }
}

TEST(BasisFile, MissingEmptyAndForeignFilesAreErrors) {
  const std::string folder = testing::fresh_folder() + "/";
  EXPECT_EQ(read_basis(folder + "no-such-file").error().kind, ErrorKind::kSystem);
  EXPECT_EQ(read_basis(folder).error().kind, ErrorKind::kSystem);
  std::ofstream(folder + "empty").flush();
  EXPECT_EQ(read_basis(folder + "empty").error().kind, ErrorKind::kContent);
  std::ofstream(folder + "foreign") << std::string(5000, 'x');
  EXPECT_EQ(read_basis(folder + "foreign").error().kind, ErrorKind::kContent);
}

TEST(BasisFile, TheWriterRefusesDataOfUnequalShape) {
  for (int member = 0; member < 6; ++member) {
    BasisData data = tiny_basis();
    if (member == 0) data.cubic.pop_back();
    if (member == 1) data.quartic.push_back(0);
    if (member == 2) data.surface.rows.conservativeResize(9, 2);
    if (member == 3) data.vertex_count = 6;
    if (member == 4) data.load.forces.clear();
    if (member == 5) data.fixed_vertices.clear();
    EXPECT_FALSE(encode_basis(data)) << member;
  }
}

TEST(BasisFile, AnUnwritableTargetIsAnErrorAndLeavesNothing) {
  const std::string folder = testing::fresh_folder() + "/atomic-test";
  std::filesystem::create_directories(folder);
  EXPECT_EQ(write_basis(folder + "/no/such/folder/x.tremolo", tiny_basis()).error().kind,
            ErrorKind::kSystem);
  EXPECT_EQ(write_basis(folder, tiny_basis()).error().kind, ErrorKind::kSystem);
  EXPECT_EQ(write_basis("/dev/full", tiny_basis()).error().kind, ErrorKind::kSystem);
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

}  // namespace

// Models without their inside, and sounds.

namespace {

BasisData sample_data() {
  Eigen::VectorXd omega(3);
  omega << 10.0, 20.0, 50.0;
  return testing::sample_basis(testing::random_strain_model(omega, 0.2, 3));
}

TEST(LightBasis, KeepsTheBodyAndItsSurface) {
  BasisData data = sample_data();
  ASSERT_FALSE(data.interior.vertex_ids.empty());
  const Result<BasisData> light = without_interior(data);
  ASSERT_TRUE(light) << light.error().message;
  EXPECT_EQ(light->vertex_count, data.surface.vertex_ids.size());
  EXPECT_EQ(light->lambda, data.lambda);
  EXPECT_EQ(light->cubic, data.cubic);
  EXPECT_EQ(light->quartic, data.quartic);
  EXPECT_EQ(light->surface.rows, data.surface.rows);
  EXPECT_TRUE(light->interior.vertex_ids.empty());
  for (std::size_t i = 0; i < light->surface.vertex_ids.size(); ++i)
    EXPECT_EQ(light->surface.vertex_ids[i], static_cast<VertexId>(i));
  // Whoever is named is the same vertex under its new number.
  for (std::size_t i = 0; i < light->load.vertices.size(); ++i)
    EXPECT_EQ(data.surface.vertex_ids[light->load.vertices[i]], data.load.vertices[i]);
  for (const VertexId fixed : light->fixed_vertices)
    EXPECT_NE(std::find(data.fixed_vertices.begin(), data.fixed_vertices.end(),
                        data.surface.vertex_ids[fixed]),
              data.fixed_vertices.end());
  // It can be written and is read.
  const Result<std::vector<std::byte>> bytes = encode_basis(*light);
  ASSERT_TRUE(bytes) << bytes.error().message;
  const Result<std::vector<std::byte>> whole = encode_basis(data);
  ASSERT_TRUE(whole);
  EXPECT_LT(bytes->size(), whole->size());
}

TEST(LightBasis, ALoadInsideIsLeftOut) {
  BasisData data = sample_data();
  data.load.vertices = {data.interior.vertex_ids.front()};
  data.load.forces = {{1.0, 2.0, 3.0}};
  const Result<BasisData> light = without_interior(data);
  ASSERT_TRUE(light);
  EXPECT_TRUE(light->load.vertices.empty());
  EXPECT_TRUE(light->load.forces.empty());
}

TEST(Wav, HoldsItsSamples) {
  const testing::TemporaryFolder folder;
  const std::string path = folder.path() + "/sound.wav";
  const double samples[] = {0.0, 0.5, -1.0, 1.0, 7.0, -7.0};
  ASSERT_TRUE(write_wav(path, 48000, samples));
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  ASSERT_EQ(bytes.size(), 44U + 12U);
  const auto number = [&bytes](std::size_t at, int count) {
    std::uint32_t value = 0;
    for (int k = count - 1; k >= 0; --k)
      value = value << 8 | static_cast<unsigned char>(bytes[at + static_cast<std::size_t>(k)]);
    return value;
  };
  EXPECT_EQ(bytes.substr(0, 4) + bytes.substr(8, 8), "RIFFWAVEfmt ");
  EXPECT_EQ(number(4, 4), 48U);
  EXPECT_EQ(number(24, 4), 48000U);
  EXPECT_EQ(number(40, 4), 12U);
  const int expected[] = {0, 16384, -32767, 32767, 32767, -32767};
  for (std::size_t k = 0; k < 6; ++k)
    EXPECT_EQ(static_cast<std::int16_t>(number(44 + 2 * k, 2)), expected[k]) << k;
  EXPECT_FALSE(write_wav(folder.path() + "/no/such/sound.wav", 48000, samples));
}

}  // namespace
}  // namespace tremolo
