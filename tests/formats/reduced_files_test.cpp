// VegaFEM's .cub and .U: the meaning of the numbers, and files that must do no harm.
#include "formats/vega/reduced_files.h"

#include <cstring>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/meshes/vega_files.h"

namespace tremolo {
namespace {

using testing::ByteWriter;

constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();

// r = 2: every coefficient is another number.
std::string small_cub() {
  ByteWriter bytes(false);
  for (std::int32_t count : {2, 2, 3, 4}) bytes.put(count);
  for (int value = 1; value <= 18; ++value) bytes.put(static_cast<double>(value));
  return bytes.str();
}

std::string small_u() {
  return testing::basis_file(Eigen::MatrixXd::Random(6, 2));
}

std::string with_count(std::string bytes, std::size_t at, std::int32_t value) {
  std::memcpy(bytes.data() + at, &value, sizeof(value));
  return bytes;
}

template <class Read>
void expect_refused(const Read& read, const std::string& bytes, const std::string& words) {
  const auto result = read(bytes, "a file");
  ASSERT_FALSE(result) << words;
  EXPECT_EQ(result.error().kind, ErrorKind::kContent);
  EXPECT_NE(result.error().message.find("a file, byte "), std::string::npos)
      << result.error().message;
  EXPECT_NE(result.error().message.find(words), std::string::npos) << result.error().message;
}

TEST(Cub, ACoefficientBelongsToAMonomialAndARowToAForce) {
  const Result<ReducedForces> forces = read_cub(small_cub(), "a.cub");
  ASSERT_TRUE(forces) << forces.error().message;
  // At q = (2, 3): q0 q0, q0 q1, q1 q1 are 4, 6, 9 and the cubes 8, 12, 18, 27.
  const Eigen::VectorXd f = evaluate(*forces, Eigen::Vector2d(2, 3));
  EXPECT_EQ(f[0],
            (1 * 2 + 2 * 3) + (5 * 4 + 6 * 6 + 7 * 9) + (11 * 8 + 12 * 12 + 13 * 18 + 14 * 27));
  EXPECT_EQ(f[1],
            (3 * 2 + 4 * 3) + (8 * 4 + 9 * 6 + 10 * 9) + (15 * 8 + 16 * 12 + 17 * 18 + 18 * 27));
}

TEST(Cub, ForcesOfAnEnergyAreItsGradient) {
  for (int r : {1, 2, 5}) {
    const testing::StrainModel model =
        testing::random_strain_model(testing::spread_omega(r, 3, 40), 0.3, 4);
    const BasisData data = testing::sample_basis(model);
    const ReducedForces forces = reduced_forces(data.lambda, data.cubic, data.quartic);
    const Eigen::VectorXd q = testing::random_vector(r, 1.5, 8);
    const Eigen::VectorXd expected = testing::strain_force(model, q);
    // Sums of at most a few hundred terms of one size.
    EXPECT_LE((evaluate(forces, q) - expected).norm(), 1e-13 * expected.norm()) << r;
    const testing::ForceRows rows = testing::parse_cub(*cub_bytes(forces));
    EXPECT_LE((testing::evaluate_rows(rows, q) - expected).norm(), 1e-13 * expected.norm()) << r;
  }
}

TEST(Cub, ALinearModelHasNoHigherTerms) {
  const ReducedForces forces = reduced_forces(Eigen::Vector2d(4, 9), {}, {});
  EXPECT_EQ(forces.linear, (std::vector<double>{4, 0, 0, 9}));
  EXPECT_EQ(forces.quadratic, std::vector<double>(6, 0.0));
  EXPECT_EQ(forces.cubic, std::vector<double>(8, 0.0));
}

TEST(ReducedFiles, ComeOutAsTheyCameIn) {
  EXPECT_EQ(*cub_bytes(*read_cub(small_cub(), "")), small_cub());
  const std::string u = small_u();
  EXPECT_EQ(*basis_matrix_bytes(*read_basis_matrix(u, "")), u);
}

TEST(ReducedFiles, CutAnywhereOrLongerAreRefused) {
  const std::string cub = small_cub(), u = small_u();
  for (std::size_t length = 0; length < cub.size(); ++length)
    EXPECT_FALSE(read_cub(cub.substr(0, length), "")) << length;
  for (std::size_t length = 0; length < u.size(); ++length)
    EXPECT_FALSE(read_basis_matrix(u.substr(0, length), "")) << length;
  expect_refused(read_cub, cub + '\0', "1 too many");
  expect_refused(read_basis_matrix, u + "12345678", "8 too many");
}

TEST(ReducedFiles, CountsThatLieAreRefusedBeforeMemoryIsTaken) {
  const std::string cub = small_cub(), u = small_u();
  for (std::int32_t r : {0, -1, 4097, kMost, -kMost - 1})
    expect_refused(read_cub, with_count(cub, 0, r), "from 1 to 4096, found " + std::to_string(r));
  expect_refused(read_cub, with_count(cub, 0, 3), "expected L = r");
  expect_refused(read_cub, with_count(cub, 4, 1), "expected L = r");
  expect_refused(read_cub, with_count(cub, 8, kMost), "Q = r(r+1)/2, quadratic terms, 3");
  expect_refused(read_cub, with_count(cub, 12, -4), "C = r(r+1)(r+2)/6, cubic terms, 4");
  // Counts that fit each other, r = 1000, and no file of 4 GB behind them.
  std::string large = cub;
  for (const auto& [at, count] : {std::pair{0, 1000}, {4, 1000}, {8, 500500}, {12, 167167000}})
    large = with_count(large, static_cast<std::size_t>(at), count);
  expect_refused(read_cub, large, "before the end of the file");
  for (std::int32_t rows : {0, -6})
    expect_refused(read_basis_matrix, with_count(u, 0, rows), "a number of rows");
  for (std::int32_t columns : {0, -2, 4097, kMost})
    expect_refused(read_basis_matrix, with_count(u, 4, columns), "a number of columns");
  expect_refused(read_basis_matrix, with_count(u, 0, kMost), "before the end of the file");
}

TEST(ReducedFiles, ANumberThatIsNotFiniteIsRefusedWithItsPlace) {
  for (double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    for (std::size_t at = 16; at < small_cub().size(); at += 8) {
      std::string cub = small_cub();
      std::memcpy(cub.data() + at, &bad, sizeof(bad));
      expect_refused(read_cub, cub, "byte " + std::to_string(at) + ": expected a finite number");
    }
    std::string u = small_u();
    std::memcpy(u.data() + 8 + 40, &bad, sizeof(bad));
    expect_refused(read_basis_matrix, u, "byte 48: expected a finite number");
  }
}

TEST(ReducedFiles, WithAnyBytesChangedAreReadOrRefused) {
  std::mt19937 random(3);
  for (int round = 0; round < 2000; ++round) {
    std::string cub = small_cub(), u = small_u();
    for (int n = 0; n < 3; ++n) {
      cub[random() % cub.size()] = static_cast<char>(random() & 0xff);
      u[random() % u.size()] = static_cast<char>(random() & 0xff);
    }
    const auto forces = read_cub(cub, "");
    EXPECT_TRUE(!forces || forces->size == 2);
    const auto basis = read_basis_matrix(u, "");
    EXPECT_TRUE(!basis || basis->size() == 12);
  }
}

TEST(ReducedFiles, MoreThanVegaFEMCanCountIsRefused) {
  const auto bytes = cub_bytes({337, {}, {}, {}});
  ASSERT_FALSE(bytes);
  EXPECT_NE(bytes.error().message.find("336"), std::string::npos) << bytes.error().message;
  EXPECT_FALSE(cub_bytes({}));
}

}  // namespace
}  // namespace tremolo
