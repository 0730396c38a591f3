// The Gram matrix of the strains in a basis file: as specified, compact without gain of energy, and
// a reader that trusts it no more than the rest.
#include <cmath>
#include <limits>
#include <random>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "common/packed_index.h"
#include "formats/basis/basis_writer.h"
#include "tests/support/basis_bytes.h"
#include "tests/support/tiny_basis.h"

namespace tremolo {
namespace {

using namespace basis_layout;
using namespace testing;

constexpr const char* kGolden = TREMOLO_SOURCE_DIR "/tests/formats/golden/tiny-strains-1.4.tremolo";

// The tiny basis with a matrix of its five strain terms.
BasisData basis_with_strains() {
  BasisData data = tiny_basis();
  for (int i = 0; i < 15; ++i) data.strain_gram.push_back(0.125 * i);
  for (std::size_t a = 0; a < 5; ++a) data.strain_gram[pair_index(a, a)] = 16.0;
  return data;
}

Eigen::MatrixXd whole(const std::vector<double>& packed, std::size_t terms) {
  Eigen::MatrixXd matrix(terms, terms);
  for (std::size_t b = 0; b < terms; ++b)
    for (std::size_t a = 0; a <= b; ++a)
      matrix(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) = matrix(
          static_cast<Eigen::Index>(b), static_cast<Eigen::Index>(a)) = packed[pair_index(a, b)];
  return matrix;
}

TEST(StrainGramFile, WritesAndReadsTheGoldenBytesOfVersionOneFour) {
  const Bytes bytes = *encode_basis(basis_with_strains());
  EXPECT_EQ(bytes, read_file(kGolden));
  const auto data = read_basis(kGolden);
  ASSERT_TRUE(data) << data.error().message;
  expect_equal(*data, basis_with_strains());
  EXPECT_EQ(data->strain_gram, basis_with_strains().strain_gram);
  EXPECT_EQ(BasisReader::open(kGolden)->minor_version(), kMinorStrains);
}

TEST(StrainGramFile, AFileWithoutItKeepsItsVersion) {
  const Bytes bytes = *encode_basis(tiny_basis());
  const auto reader = BasisReader::from_memory(bytes);
  ASSERT_TRUE(reader);
  EXPECT_EQ(reader->minor_version(), kMinor);
  EXPECT_TRUE(decode(bytes)->strain_gram.empty());
}

TEST(StrainGramFile, AReaderThatDoesNotKnowItSkipsIt) {
  Bytes bytes = *encode_basis(basis_with_strains());
  const std::size_t at = entry_of(bytes, kStrainGram);
  std::memset(bytes.data() + at, 0, kNameSize);
  std::memcpy(bytes.data() + at, "unknown", 7);
  reseal(bytes);
  const auto data = decode(bytes);
  ASSERT_TRUE(data) << data.error().message;
  expect_equal(*data, tiny_basis());
}

TEST(StrainGramFile, ATruncatedFileADamagedByteAndAHostileFieldAreRefused) {
  for (const BasisEncoding encoding : {BasisEncoding::kFull, BasisEncoding::kCompact}) {
    const Bytes bytes = *encode_basis(basis_with_strains(), encoding);
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      const Bytes cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
      EXPECT_FALSE(decode(cut)) << "length " << length;
    }
    testing::expect_every_damaged_byte_is_noticed(bytes);
    testing::expect_no_field_is_trusted(bytes);
  }
}

TEST(StrainGramFile, ADiagonalThatIsNegativeAndValuesThatAreNotFiniteAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double value : {-1.0, nan, std::numeric_limits<double>::infinity()}) {
    Bytes bytes = *encode_basis(basis_with_strains());
    put(bytes, offset_of(bytes, kStrainGram), value);
    reseal(bytes);
    const auto refused = decode(bytes);
    ASSERT_FALSE(refused) << value;
    EXPECT_NE(refused.error().message.find("strain_gram"), std::string::npos)
        << refused.error().message;
  }
  for (const double scale : {0.0, -1.0, nan}) {
    Bytes bytes = *encode_basis(basis_with_strains(), BasisEncoding::kCompact);
    put(bytes, offset_of(bytes, kStrainScale), scale);
    reseal(bytes);
    EXPECT_FALSE(decode(bytes)) << scale;
  }
  BasisData data = basis_with_strains();
  data.strain_gram.pop_back();
  EXPECT_FALSE(encode_basis(data));
}

// Floats with a larger diagonal: never less than the matrix, and near it.
TEST(StrainGramFile, CompactItIsNeverLessThanItWasAndNearIt) {
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> sign(-1.0, 1.0), exponent(-6.0, 6.0);
  for (int sample = 0; sample < 20; ++sample) {
    // Of rank two, and rows of very different size: nothing to spare.
    Eigen::MatrixXd strains(2, 5);
    for (Eigen::Index a = 0; a < 5; ++a)
      strains.col(a) =
          std::pow(10.0, exponent(engine)) * Eigen::Vector2d(sign(engine), sign(engine));
    const Eigen::MatrixXd gram = strains.transpose() * strains;
    BasisData data = tiny_basis();
    for (Eigen::Index b = 0; b < 5; ++b)
      for (Eigen::Index a = 0; a <= b; ++a) data.strain_gram.push_back(gram(a, b));
    const auto kept = decode(*encode_basis(data, BasisEncoding::kCompact));
    ASSERT_TRUE(kept) << kept.error().message;
    const Eigen::VectorXd unit = gram.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd more =
        unit.asDiagonal() * (whole(kept->strain_gram, 5) - gram) * unit.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(more);
    EXPECT_GE(eigen.eigenvalues().minCoeff(), 0.0);
    // 6 x 2^-24 of the diagonal, and as much again from rounding.
    EXPECT_LE(eigen.eigenvalues().maxCoeff(), 12.0 * std::ldexp(1.0, -24));
  }
}

}  // namespace
}  // namespace tremolo
