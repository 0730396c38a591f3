// The collider file: bytes as specified, and a reader that trusts nothing.
#include "formats/collider/collider_file.h"

#include <limits>

#include <gtest/gtest.h>

#include "tests/support/section_bytes.h"
#include "tests/support/small_collider.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using testing::Bytes;

Bytes collider_bytes() {
  const Result<std::vector<std::byte>> bytes = encode_collider(testing::small_collider());
  EXPECT_TRUE(bytes);
  return *bytes;
}

bool takes_collider(const Bytes& bytes) {
  return static_cast<bool>(read_collider(bytes));
}

std::string collider_refusal(const Bytes& bytes) {
  const Result<ColliderFile> file = read_collider(bytes, "a.collider");
  EXPECT_FALSE(file);
  return file ? std::string() : file.error().message;
}

TEST(ColliderFile, ComesBackAsItWasWritten) {
  const ColliderData data = testing::small_collider();
  const testing::TemporaryFolder folder;
  const std::string path = folder.file("a.collider");
  ASSERT_TRUE(write_collider(path, data));
  EXPECT_EQ(testing::read_file(path), collider_bytes());
  const Result<ColliderFile> file = read_collider(path);
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->provenance, data.provenance);
  EXPECT_EQ(file->grid.nodes().counts, data.nodes.counts);
  EXPECT_EQ(file->grid.nodes().origin, data.nodes.origin);
  EXPECT_EQ(file->grid.nodes().spacing, data.nodes.spacing);
  const Result<DistanceGrid> grid = DistanceGrid::create(data.nodes, data.distances);
  ASSERT_TRUE(grid);
  for (const Eigen::Vector3d& x : {Eigen::Vector3d(0.3, -0.2, 0.9), Eigen::Vector3d(2, 2, 2)}) {
    EXPECT_EQ(file->grid.at(x).distance, grid->at(x).distance);
    EXPECT_EQ(file->grid.at(x).gradient, grid->at(x).gradient);
  }
}

// docs/collider-format.md, byte by byte.
TEST(ColliderFile, BytesAreAsSpecified) {
  const ColliderData data = testing::small_collider();
  const Bytes bytes = collider_bytes();
  EXPECT_EQ(std::memcmp(bytes.data(), "TREMCOLL", 8), 0);
  EXPECT_EQ(testing::get<std::uint16_t>(bytes, 8), 1);
  EXPECT_EQ(testing::get<std::uint16_t>(bytes, 10), 0);
  EXPECT_EQ(testing::get<std::uint32_t>(bytes, 12), 4U);
  EXPECT_EQ(testing::get<std::uint64_t>(bytes, 16), bytes.size());
  EXPECT_EQ(bytes.size(), 64U + 4 * 64 + 64 + 64 + 640 + 64);
  const std::size_t counts = testing::offset_of(bytes, "grid_counts");
  EXPECT_EQ(counts, 320U);
  EXPECT_EQ(testing::get<std::uint64_t>(bytes, counts + 8), 6U);
  const std::size_t frame = testing::offset_of(bytes, "grid_frame");
  EXPECT_EQ(testing::get<double>(bytes, frame + 8), data.nodes.origin.y());
  EXPECT_EQ(testing::get<double>(bytes, frame + 24), data.nodes.spacing);
  const std::size_t distances = testing::offset_of(bytes, "distances");
  // Node (2, 1, 3).
  EXPECT_EQ(testing::get<float>(bytes, distances + 4 * (2 + 5 * (1 + 6 * 3))),
            static_cast<float>(data.nodes.at(2, 1, 3).norm() - 1.0));
}

TEST(ColliderFile, EveryDamagedByteIsNoticed) {
  testing::expect_every_damaged_byte_is_noticed(collider_bytes(), takes_collider);
}

TEST(ColliderFile, EveryTruncationIsNoticed) {
  testing::expect_every_truncation_is_noticed(collider_bytes(), takes_collider);
}

TEST(ColliderFile, NoFieldIsTrusted) {
  testing::expect_no_field_is_trusted(collider_bytes(), takes_collider);
}

TEST(ColliderFile, HostileNumbersAreRefusedByName) {
  const Bytes bytes = collider_bytes();
  const auto changed = [&bytes](const char* section, std::size_t at, auto value) {
    Bytes copy = bytes;
    testing::put(copy, testing::offset_of(copy, section) + at, value);
    testing::reseal(copy);
    return collider_refusal(copy);
  };
  for (const std::uint64_t count :
       {std::uint64_t{0}, std::uint64_t{3}, std::uint64_t{1} << 32, ~std::uint64_t{0}})
    EXPECT_NE(changed("grid_counts", 0, count).find("nodes along an axis"), std::string::npos);
  EXPECT_NE(changed("grid_counts", 0, std::uint64_t{6}).find("does not fit"), std::string::npos);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(changed("grid_frame", 8, nan).find("grid_frame at byte 392: a value is not finite"),
            std::string::npos);
  EXPECT_NE(changed("grid_frame", 24, 0.0).find("spacing"), std::string::npos);
  EXPECT_NE(changed("grid_frame", 24, -1.0).find("spacing"), std::string::npos);
  EXPECT_NE(changed("distances", 0, std::numeric_limits<float>::infinity()).find("not finite"),
            std::string::npos);
  EXPECT_NE(changed("distances", 0, -1.0F).find("margin"), std::string::npos);
  EXPECT_NE(changed("distances", 0, 4.0F).find("more than they are apart"), std::string::npos);
  EXPECT_NE(changed("distances", 0, 99.0F).find("a.collider: distances at byte"),
            std::string::npos);
}

TEST(ColliderFile, OtherFilesAreRefused) {
  EXPECT_NE(collider_refusal({}).find("a collider file has a header"), std::string::npos);
  const Bytes basis = testing::read_file(std::string(TREMOLO_SOURCE_DIR) +
                                         "/tests/formats/golden/tiny-1.0.tremolo");
  EXPECT_NE(collider_refusal(basis).find("not a collider file but a basis file"),
            std::string::npos);
  EXPECT_EQ(read_collider("/nonexistent/a.collider").error().kind, ErrorKind::kSystem);
}

TEST(ColliderFile, WhatIsNoGridIsNotWritten) {
  ColliderData data = testing::small_collider();
  data.distances[60] = 50.0F;
  const testing::TemporaryFolder folder;
  const std::string path = folder.file("a.collider");
  const Status status = write_collider(path, data);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, ErrorKind::kContent);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace tremolo
