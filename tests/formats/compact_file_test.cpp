// Compact and linear basis files: how much rounding costs, and a reader that trusts them no more
// than a full one.
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "common/packed_index.h"
#include "formats/basis/basis_writer.h"
#include "formats/basis/compact_values.h"
#include "tests/support/basis_bytes.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_basis.h"

namespace tremolo {
namespace {

using namespace basis_layout;
using namespace testing;

constexpr const char* kGoldenCompact =
    TREMOLO_SOURCE_DIR "/tests/formats/golden/tiny-compact-1.1.tremolo";

Bytes compact_bytes(const BasisData& data = tiny_basis()) {
  return *encode_basis(data, BasisEncoding::kCompact);
}

BasisData linear_basis() {
  BasisData data = tiny_basis();
  data.cubic.clear();
  data.quartic.clear();
  return data;
}

// Every kind of file that 1.0 does not know.
std::vector<Bytes> new_files() {
  return {compact_bytes(), *encode_basis(linear_basis()), compact_bytes(linear_basis())};
}

// The tiny basis with r = 6 and entries of very different size.
BasisData random_basis(unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> sign(-1.0, 1.0), exponent(-12.0, 12.0);
  const auto any = [&] { return sign(engine) * std::pow(10.0, exponent(engine)); };
  constexpr Eigen::Index kModes = 6;
  BasisData data = tiny_basis();
  data.lambda = Eigen::VectorXd::LinSpaced(kModes, 1.0, 77.7);
  data.cubic.resize(triple_count(kModes));
  data.quartic.resize(quad_count(kModes));
  for (double& c : data.cubic) c = any();
  for (double& c : data.quartic) c = any();
  for (BasisRows* rows : {&data.surface.rows, &data.interior.rows}) {
    rows->resize(rows->rows(), kModes);
    for (Eigen::Index i = 0; i < kModes; ++i)
      for (Eigen::Index row = 0; row < rows->rows(); ++row)
        (*rows)(row, i) = std::pow(10.0, static_cast<double>(3 * i - 8)) * sign(engine);
  }
  data.surface.rows.topRows(3).setZero();
  return data;
}

void rename(Bytes& bytes, std::string_view from, std::string_view to) {
  const std::size_t at = entry_of(bytes, from);
  std::memset(bytes.data() + at, 0, kNameSize);
  std::memcpy(bytes.data() + at, to.data(), to.size());
}

// max |kept - full| / |full|
double largest_relative(const std::vector<double>& kept, const std::vector<double>& full) {
  double largest = 0.0;
  for (std::size_t i = 0; i < full.size(); ++i)
    largest = std::max(largest, std::abs(kept[i] - full[i]) / std::abs(full[i]));
  return largest;
}

TEST(CompactFile, WritesTheGoldenBytesOfVersionOneOne) {
  EXPECT_EQ(compact_bytes(), read_file(kGoldenCompact));
}

TEST(CompactFile, ReadsTheGoldenFileOfVersionOneOne) {
  const auto data = read_basis(kGoldenCompact);
  ASSERT_TRUE(data) << data.error().message;
  EXPECT_EQ(data->lambda, tiny_basis().lambda);
  EXPECT_EQ(data->cubic, tiny_basis().cubic) << "these are f32 as they are";
  // 0.5 in a column whose largest entry is 1.375: 11915.3 steps of 1.375 / 32767.
  EXPECT_EQ(data->interior.rows(0, 0), 11915 * (1.375 / 32767));
  EXPECT_EQ(data->surface.rows(11, 0), 32767 * (1.375 / 32767));
}

TEST(CompactFile, ABasisEntryIsWithinHalfAStepOf65534ToItsColumnsLargest) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const BasisData full = random_basis(seed);
    const auto kept = decode(compact_bytes(full));
    ASSERT_TRUE(kept) << kept.error().message;
    for (Eigen::Index i = 0; i < full.lambda.size(); ++i) {
      const double largest = std::max(full.surface.rows.col(i).cwiseAbs().maxCoeff(),
                                      full.interior.rows.col(i).cwiseAbs().maxCoeff());
      const double half = largest / 32767 / 2 * (1 + 1e-10);  // the division by the scale rounds
      EXPECT_LE((kept->surface.rows - full.surface.rows).col(i).cwiseAbs().maxCoeff(), half);
      EXPECT_LE((kept->interior.rows - full.interior.rows).col(i).cwiseAbs().maxCoeff(), half);
    }
    EXPECT_TRUE(kept->surface.rows.topRows(3).isZero(0.0)) << "a fixed vertex stays";
  }
}

TEST(CompactFile, ACoefficientIsWithinHalfAUnitInTheLastPlaceOfAFloat) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const BasisData full = random_basis(seed);
    const auto kept = decode(compact_bytes(full));
    ASSERT_TRUE(kept);
    EXPECT_LE(largest_relative(kept->cubic, full.cubic), std::ldexp(1.0, -24));
    EXPECT_LE(largest_relative(kept->quartic, full.quartic), std::ldexp(1.0, -24));
  }
}

TEST(CompactFile, CoefficientsFarOutsideTheRangeOfFloatsKeepTheirAccuracy) {
  for (const double factor : {1e-200, 1e-60, 1e60, 1e200}) {
    BasisData full = tiny_basis();
    for (double& c : full.cubic) c *= factor * 1.1;
    for (double& c : full.quartic) c *= 1.3 / factor;
    const auto kept = decode(compact_bytes(full));
    ASSERT_TRUE(kept) << kept.error().message;
    EXPECT_LE(largest_relative(kept->cubic, full.cubic), std::ldexp(1.0, -24)) << factor;
    EXPECT_LE(largest_relative(kept->quartic, full.quartic), std::ldexp(1.0, -24)) << factor;
  }
}

TEST(CompactFile, EverythingElseIsKeptExactly) {
  BasisData full = random_basis(7);
  const auto kept = decode(compact_bytes(full));
  ASSERT_TRUE(kept);
  full.cubic = kept->cubic;
  full.quartic = kept->quartic;
  full.surface.rows = kept->surface.rows;
  full.interior.rows = kept->interior.rows;
  expect_equal(*kept, full);
}

TEST(CompactFile, RoundingTwiceIsRoundingOnce) {
  const auto once = decode(compact_bytes(random_basis(3)));
  ASSERT_TRUE(once);
  const auto twice = decode(compact_bytes(*once));
  ASSERT_TRUE(twice);
  EXPECT_EQ(twice->cubic, once->cubic);
  // The scale is recovered except for its last bit.
  EXPECT_TRUE(twice->surface.rows.isApprox(once->surface.rows, 1e-15));
}

TEST(CompactFile, ZerosOnlyAreZerosAgain) {
  BasisData full = tiny_basis();
  full.cubic.assign(full.cubic.size(), 0.0);
  full.surface.rows.col(1).setZero();
  full.interior.rows.col(1).setZero();
  const auto kept = decode(compact_bytes(full));
  ASSERT_TRUE(kept) << kept.error().message;
  EXPECT_EQ(kept->cubic, full.cubic);
  EXPECT_TRUE(kept->surface.rows.col(1).isZero(0.0));
}

TEST(CompactFile, TheReaderSaysWhichEncodingItIs) {
  for (const bool linear : {false, true})
    for (const BasisEncoding encoding : {BasisEncoding::kFull, BasisEncoding::kCompact}) {
      const Bytes bytes = *encode_basis(linear ? linear_basis() : tiny_basis(), encoding);
      const auto reader = BasisReader::from_memory(bytes);
      ASSERT_TRUE(reader) << reader.error().message;
      EXPECT_EQ(reader->compact(), encoding == BasisEncoding::kCompact);
      EXPECT_EQ(reader->linear(), linear);
      EXPECT_EQ(reader->minor_version(), linear || reader->compact() ? 1 : 0);
    }
}

// Version 1.0 knows the element types 1 to 4 and requires all coefficients.
TEST(CompactFile, AReaderOfVersionOneZeroRefusesWhatItCannotUnderstand) {
  for (const Bytes& bytes : new_files()) {
    const auto reader = BasisReader::from_memory(bytes);
    ASSERT_TRUE(reader);
    bool refused = false;
    for (const BasisSection& section : reader->sections())
      refused = refused || static_cast<std::uint32_t>(section.type) > 4 ||
                (section.name == kQuartic && section.rows != quad_count(2));
    EXPECT_TRUE(refused);
  }
}

TEST(CompactFile, ALinearModelHasNoTermsInEitherEncoding) {
  for (const BasisEncoding encoding : {BasisEncoding::kFull, BasisEncoding::kCompact}) {
    const auto data = decode(*encode_basis(linear_basis(), encoding));
    ASSERT_TRUE(data) << data.error().message;
    EXPECT_TRUE(data->cubic.empty());
    EXPECT_TRUE(data->quartic.empty());
    EXPECT_EQ(data->lambda, tiny_basis().lambda);
  }
}

TEST(CompactFile, TermsOfOneOrderWithoutTheOtherAreRefused) {
  for (const bool cubic : {false, true}) {
    BasisData data = tiny_basis();
    (cubic ? data.cubic : data.quartic).clear();
    EXPECT_FALSE(encode_basis(data));
    // A file the writer does not make: the terms and the empty provenance exchange their names.
    data = tiny_basis();
    data.provenance.clear();
    Bytes bytes = *encode_basis(data);
    const std::string_view name = cubic ? kCubic : kQuartic;
    rename(bytes, name, "other");
    put(bytes, entry_of(bytes, "other") + entry::kFlagsAt, std::uint32_t{0});
    rename(bytes, kProvenance, name);
    put(bytes, entry_of(bytes, name) + entry::kTypeAt, ElementType::kF64);
    reseal(bytes);
    const auto refused = decode(bytes);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("does not fit"), std::string::npos)
        << refused.error().message;
  }
}

TEST(CompactFile, ATruncatedFileIsRefusedAtEveryLength) {
  for (const Bytes& bytes : new_files())
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      const Bytes cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
      EXPECT_FALSE(decode(cut)) << "length " << length;
    }
}

TEST(CompactFile, AnyDamagedByteIsNoticed) {
  for (const Bytes& bytes : new_files()) testing::expect_every_damaged_byte_is_noticed(bytes);
}

TEST(CompactFile, NoFieldValueIsTrusted) {
  for (const Bytes& bytes : new_files()) expect_no_field_is_trusted(bytes);
}

TEST(CompactFile, ScalesAndFloatsThatMakeNoSenseAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinite = std::numeric_limits<double>::infinity();
  const Bytes bytes = compact_bytes();
  for (const std::string_view section : {kCoefficientScales, kBasisScales})
    for (const std::size_t which : {0, 1})
      for (const double value : {nan, infinite, -infinite, 0.0, -1.0, 1e307}) {
        Bytes changed = bytes;
        put(changed, offset_of(changed, section) + 8 * which, value);
        reseal(changed);
        EXPECT_FALSE(decode(changed)) << section << " = " << value;
      }
  for (const std::string_view section : {kCubic, kQuartic})
    for (const float value : {static_cast<float>(nan), static_cast<float>(infinite)}) {
      Bytes changed = bytes;
      put(changed, offset_of(changed, section) + 4, value);
      reseal(changed);
      EXPECT_FALSE(decode(changed)) << section;
    }
  Bytes changed = bytes;  // finite each, but not their product
  put(changed, offset_of(changed, kCoefficientScales), 1e300);
  put(changed, offset_of(changed, kCubic), 1e30f);
  reseal(changed);
  EXPECT_FALSE(decode(changed));
}

TEST(CompactFile, ScalesComeTogetherAndWithTheirTypes) {
  for (const std::string_view section : {kCoefficientScales, kBasisScales}) {
    Bytes bytes = compact_bytes();
    rename(bytes, section, "other");
    put(bytes, entry_of(bytes, "other") + entry::kFlagsAt, std::uint32_t{0});
    reseal(bytes);
    EXPECT_FALSE(decode(bytes)) << section;
  }
  // A full file in which an optional section of the right shape poses as one of the scales.
  for (const std::string_view section : {kCoefficientScales, kBasisScales}) {
    BasisData data = tiny_basis();
    data.singular_values = {1.0, 0.5};
    Bytes bytes = *encode_basis(data);
    rename(bytes, kSingularValues, section);
    reseal(bytes);
    EXPECT_FALSE(decode(bytes)) << section;
  }
}

TEST(CompactFile, TheWriterRefusesValuesThatAreNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int member = 0; member < 4; ++member) {
    BasisData data = tiny_basis();
    if (member == 0) data.cubic[1] = nan;
    if (member == 1) data.quartic[0] = std::numeric_limits<double>::infinity();
    if (member == 2) data.surface.rows(4, 1) = nan;
    if (member == 3) data.interior.rows(1, 0) = -std::numeric_limits<double>::infinity();
    const auto bytes = encode_basis(data, BasisEncoding::kCompact);
    ASSERT_FALSE(bytes) << member;
    EXPECT_EQ(bytes.error().kind, ErrorKind::kContent);
  }
}

TEST(CompactFile, IsAQuarterOrLessInItsRoundedSections) {
  const auto size = [](const Bytes& bytes, std::string_view section) {
    return get<std::uint64_t>(bytes, entry_of(bytes, section) + entry::kSizeAt);
  };
  const Bytes full = *encode_basis(tiny_basis());
  const Bytes compact = compact_bytes();
  for (const std::string_view section : {kSurfaceBasis, kInteriorBasis})
    EXPECT_EQ(4 * size(compact, section), size(full, section));
  for (const std::string_view section : {kCubic, kQuartic})
    EXPECT_EQ(2 * size(compact, section), size(full, section));
}

}  // namespace
}  // namespace tremolo
