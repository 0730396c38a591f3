// The file in which a finished stage is kept: it gives back every bit, and believes nothing.
#include "formats/file/checkpoint_file.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include <gtest/gtest.h>

#include "common/hash.h"
#include "tests/support/run_program.h"

namespace tremolo {
namespace {

namespace layout = checkpoint_layout;
using testing::fresh_folder;
using testing::slurp;

const std::vector<double> kValues = {1.5, -0.0, 5e-324, 1e308, 1.0 / 3.0, -7};
const std::vector<std::int64_t> kIntegers = {0, -1, std::numeric_limits<std::int64_t>::min()};
const std::string kText = std::string("a\0b", 3) + "\n";

std::vector<NamedArray> sample_arrays() {
  return {named_array("text", kText), named_array("values", kValues, 3, 2),
          named_array("integers", kIntegers), named_array("empty", std::span<const double>{}, 0),
          named_array(std::string(layout::kNameSize, 'n'), kValues, 6)};
}

std::string sample_path() {
  const std::string path = fresh_folder() + "/sample";
  const Status status = write_checkpoint_file(path, sample_arrays());
  EXPECT_TRUE(status) << status.error().message;
  return path;
}

// Opened and every array asked for. The buffer is exactly as long as the file: one byte too far is
// an error under AddressSanitizer.
bool readable(const std::string& text) {
  const std::vector<char> bytes(text.begin(), text.end());
  const auto file = CheckpointFile::from_memory(std::as_bytes(std::span(bytes)));
  if (!file) return false;
  for (const NamedArray& array : file->arrays())
    if (!file->matrix(array.name) && !file->integers(array.name) && !file->text(array.name))
      return false;
  return true;
}

template <class T>
void put_number(std::string& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof(value));
}

template <class T>
T number_at(const std::string& bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

std::uint64_t hash_of(const std::string& bytes, std::size_t at, std::size_t size) {
  return hash_bytes(std::as_bytes(std::span(bytes)).subspan(at, size));
}

// Makes the checksums of header and table right again, as an attacker would.
void reseal_checkpoint(std::string& bytes) {
  const std::size_t table =
      std::min<std::size_t>(number_at<std::uint32_t>(bytes, layout::kArraysAt) * layout::kEntrySize,
                            bytes.size() - layout::kHeaderSize);
  put_number(bytes, layout::kTableHashAt, hash_of(bytes, layout::kHeaderSize, table));
  put_number(bytes, layout::kHeaderHashAt, hash_of(bytes, 0, layout::kHeaderHashAt));
}

TEST(CheckpointFile, GivesBackEveryBit) {
  const auto file = CheckpointFile::open(sample_path());
  ASSERT_TRUE(file) << file.error().message;
  const auto values = file->matrix("values");
  ASSERT_TRUE(values) << values.error().message;
  EXPECT_EQ(values->rows(), 3);
  EXPECT_EQ(values->cols(), 2);
  EXPECT_EQ(std::memcmp(values->data(), kValues.data(), 6 * sizeof(double)), 0);
  EXPECT_EQ(*file->integers("integers"), kIntegers);
  EXPECT_EQ(*file->text("text"), kText);
  const auto empty = file->matrix("empty");
  ASSERT_TRUE(empty) << empty.error().message;
  EXPECT_EQ(empty->size(), 0);
  EXPECT_EQ(file->matrix(std::string(layout::kNameSize, 'n'))->rows(), 6);
}

TEST(CheckpointFile, TheSameArraysAreTheSameBytes) {
  EXPECT_EQ(slurp(sample_path()), slurp(sample_path()));
}

TEST(CheckpointFile, AnArrayIsReadAsWhatItIsOnly) {
  const auto file = CheckpointFile::open(sample_path());
  ASSERT_TRUE(file);
  for (const char* name : {"text", "integers", "no such array"})
    EXPECT_EQ(file->matrix(name).error().kind, ErrorKind::kContent) << name;
  for (const char* name : {"text", "values", "no such array"})
    EXPECT_EQ(file->integers(name).error().kind, ErrorKind::kContent) << name;
  for (const char* name : {"values", "integers", "no such array"})
    EXPECT_EQ(file->text(name).error().kind, ErrorKind::kContent) << name;
}

TEST(CheckpointFile, IsRefusedAtEveryLength) {
  const std::string bytes = slurp(sample_path());
  ASSERT_TRUE(readable(bytes));
  for (std::size_t length = 0; length < bytes.size(); ++length)
    EXPECT_FALSE(readable(bytes.substr(0, length))) << "length " << length;
  EXPECT_FALSE(readable(bytes + '\0'));
}

TEST(CheckpointFile, AnyDamagedByteIsNoticed) {
  const std::string bytes = slurp(sample_path());
  for (std::size_t at = 0; at < bytes.size(); ++at)
    for (const unsigned bits : {0x01u, 0x80u, 0xffu}) {
      std::string damaged = bytes;
      damaged[at] = static_cast<char>(static_cast<unsigned char>(damaged[at]) ^ bits);
      EXPECT_FALSE(readable(damaged)) << "byte " << at;
    }
}

// Every field of header and table set to values that sizes overflow with, checksums made right.
TEST(CheckpointFile, NoFieldIsTrusted) {
  const std::string bytes = slurp(sample_path());
  const std::size_t front = layout::kHeaderSize + sample_arrays().size() * layout::kEntrySize;
  for (std::size_t at = 0; at + 8 <= front; at += 4)
    for (const std::uint64_t value :
         {std::uint64_t{1} << 29, std::uint64_t{1} << 31, std::uint64_t{1} << 40,
          std::uint64_t{1} << 61, std::uint64_t{1} << 63, ~std::uint64_t{0}}) {
      std::string changed = bytes;
      put_number(changed, at, value);
      reseal_checkpoint(changed);
      // A name may be any text; then nothing is lost.
      const auto file = CheckpointFile::from_memory(std::as_bytes(std::span(changed)));
      if (!file) continue;
      for (const NamedArray& array : file->arrays()) {
        const auto matrix = file->matrix(array.name);
        if (matrix) {
          EXPECT_LE(static_cast<std::size_t>(matrix->size()) * 8, bytes.size()) << at;
        }
      }
    }
}

TEST(CheckpointFile, CountsThatTheFileDoesNotHoldAreRefused) {
  const std::string bytes = slurp(sample_path());
  for (const std::uint32_t count :
       {0u, 1u, 4u, 6u, layout::kMaxArrays, layout::kMaxArrays + 1, ~0u}) {
    std::string changed = bytes;
    put_number(changed, layout::kArraysAt, count);
    reseal_checkpoint(changed);
    EXPECT_FALSE(readable(changed)) << count;
  }
  for (const std::uint64_t rows : {0ull, 2ull, 4ull, 1ull << 60, (1ull << 61) + 3, ~0ull}) {
    std::string changed = bytes;
    put_number(changed, layout::kHeaderSize + layout::kEntrySize + layout::kRowsAt, rows);
    reseal_checkpoint(changed);
    EXPECT_FALSE(readable(changed)) << rows;
  }
}

// 0 x 2^40 takes no memory, but a loop over its columns would not end.
TEST(CheckpointFile, NothingHasOneColumn) {
  std::string bytes = slurp(sample_path());
  const std::size_t entry = layout::kHeaderSize + 3 * layout::kEntrySize;  // of "empty"
  for (const std::uint64_t columns : {0ull, 2ull, 1ull << 40}) {
    put_number(bytes, entry + layout::kColumnsAt, std::uint64_t{columns});
    reseal_checkpoint(bytes);
    EXPECT_FALSE(readable(bytes)) << columns;
  }
}

TEST(CheckpointFile, NumbersThatAreNoneAreRefused) {
  for (const double value :
       {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity()}) {
    const std::string path = fresh_folder() + "/bad";
    const std::vector<double> values = {1, value};
    const std::vector<NamedArray> arrays = {named_array("values", values, 2)};
    ASSERT_TRUE(write_checkpoint_file(path, arrays));
    const auto file = CheckpointFile::open(path);
    ASSERT_TRUE(file);
    const auto matrix = file->matrix("values");
    ASSERT_FALSE(matrix);
    EXPECT_NE(matrix.error().message.find("values at byte 136"), std::string::npos)
        << matrix.error().message;
  }
}

TEST(CheckpointFile, AnotherVersionSaysSo) {
  std::string bytes = slurp(sample_path());
  put_number(bytes, layout::kVersionAt, layout::kVersion + 1);
  reseal_checkpoint(bytes);
  const auto file = CheckpointFile::from_memory(std::as_bytes(std::span(bytes)), "old");
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().message, "old: header at byte 8: version 2, this program writes 1");
}

TEST(CheckpointFile, TheWriterRefusesWhatTheReaderWould) {
  const std::string path = fresh_folder() + "/refused";
  const auto refused = [&](std::vector<NamedArray> arrays) {
    const Status status = write_checkpoint_file(path, arrays);
    return !status && status.error().kind == ErrorKind::kContent && !std::filesystem::exists(path);
  };
  EXPECT_TRUE(refused({}));
  EXPECT_TRUE(refused({named_array("", kText)}));
  EXPECT_TRUE(refused({named_array(std::string(layout::kNameSize + 1, 'n'), kText)}));
  EXPECT_TRUE(refused({named_array(std::string("a\0b", 3), kText)}));
  EXPECT_TRUE(refused({named_array("a", kText), named_array("a", kText)}));
  EXPECT_TRUE(refused({named_array("a", kValues, 5)}));
  EXPECT_TRUE(refused({named_array("a", std::span<const double>{}, 0, 4)}));
  EXPECT_TRUE(refused({named_array("a", kValues, std::uint64_t{1} << 63, 2)}));
  EXPECT_TRUE(refused(std::vector<NamedArray>(layout::kMaxArrays + 1, named_array("a", kText))));
}

TEST(CheckpointFile, AFullDiskIsAnErrorWithThePath) {
  const Status status = write_checkpoint_file("/dev/full", sample_arrays());
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, ErrorKind::kSystem);
  EXPECT_NE(status.error().message.find("/dev/full"), std::string::npos);
}

}  // namespace
}  // namespace tremolo
