// Stress of a free surface: closed forms, the law in three dimensions, a beam that bends.
#include "runtime/apps/view/shape/surface_stress.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "runtime/apps/view/setup/view_setup.h"
#include "runtime/model.h"
#include "tests/viewer/viewer_files.h"

namespace tremolo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const Material kSoft{.young = 2.0e5, .poisson = 0.4};

// Two triangles that fold over an edge are two surfaces; one in a slanted plane is enough here.
const std::vector<Vector3d> kSlanted = {{0.1, 0.2, 0.3}, {1.2, 0.1, 0.5}, {0.4, 1.3, 0.1}};
const std::vector<Triangle> kOne = {{0, 1, 2}};

// Columns: two directions in the plane of kSlanted, and its normal.
Matrix3d slanted_axes() {
  const Vector3d a = (kSlanted[1] - kSlanted[0]).normalized();
  const Vector3d n = a.cross(kSlanted[2] - kSlanted[0]).normalized();
  Matrix3d axes;
  axes << a, n.cross(a), n;
  return axes;
}

// The stress of the triangle where x = F X, F given along slanted_axes().
double stress_at(const Matrix3d& f, const Material& material = kSoft) {
  const Matrix3d axes = slanted_axes(), all = axes * f * axes.transpose();
  std::vector<float> moved, out;
  for (const Vector3d& x : kSlanted)
    for (const double coordinate : all* x) moved.push_back(static_cast<float>(coordinate));
  const float most = SurfaceStress(kSlanted, kOne, material).look(moved, out);
  EXPECT_EQ(out, std::vector<float>(3, most));
  return static_cast<double>(most);
}

// By the law in three dimensions: the thickness is found by bisection so that S33 = 0.
double solid_stress(Matrix3d f, const Material& material) {
  const double lambda = lame_lambda(material), mu = lame_mu(material);
  f.col(2).setZero();
  const Vector3d normal = Vector3d(f.col(0)).cross(Vector3d(f.col(1))).normalized();
  double low = 1e-3, high = 3.0;
  Matrix3d s;
  for (int k = 0; k < 80; ++k) {
    const double thickness = 0.5 * (low + high);
    f.col(2) = thickness * normal;
    const Matrix3d strain = 0.5 * (f.transpose() * f - Matrix3d::Identity());
    s = lambda * strain.trace() * Matrix3d::Identity() + 2.0 * mu * strain;
    (s(2, 2) > 0.0 ? high : low) = thickness;
  }
  const Matrix3d sigma = f * s * f.transpose() / f.determinant();
  const Matrix3d deviator = sigma - sigma.trace() / 3.0 * Matrix3d::Identity();
  return std::sqrt(1.5) * deviator.norm();
}

TEST(SurfaceStress, AMotionAsAWholeHasNone) {
  const Matrix3d turn(Eigen::AngleAxisd(1.1, Vector3d(1, 2, -1).normalized()));
  EXPECT_LE(stress_at(turn), 3e-6 * kSoft.young);  // floats
  EXPECT_LE(stress_at(Matrix3d::Identity()), 3e-6 * kSoft.young);
}

TEST(SurfaceStress, OfAPulledBarIsItsForceOverItsSection) {
  for (const double stretch : {0.8, 0.99, 1.01, 1.3}) {
    const double strain = 0.5 * (stretch * stretch - 1.0);
    const double across = std::sqrt(1.0 - 2.0 * kSoft.poisson * strain);
    const Matrix3d f = Vector3d(stretch, across, across).asDiagonal();
    const double force = kSoft.young * strain * stretch;  // a unit of the section at rest
    EXPECT_NEAR(stress_at(f), std::abs(force) / (across * across), 2e-6 * kSoft.young) << stretch;
  }
}

TEST(SurfaceStress, IsThatOfTheSolidWhoseThicknessIsFree) {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> uniform(-0.3, 0.3);
  for (int k = 0; k < 40; ++k) {
    const Material material{.young = 1e5, .poisson = 0.012 * k};
    Matrix3d f = Matrix3d::Identity();
    for (int i = 0; i < 9; ++i) f(i / 3, i % 3) += uniform(generator);
    const double expected = solid_stress(f, material);
    // Floats of numbers of size one, in units of Young's modulus.
    EXPECT_NEAR(stress_at(f, material), expected, 1e-5 * (material.young + expected)) << k;
  }
}

TEST(SurfaceStress, IsFiniteWhereATriangleHasNoAreaOrIsStretchedTooFar) {
  const std::vector<Vector3d> rest = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}};
  const SurfaceStress stress(rest, std::vector<Triangle>{{0, 1, 2}, {0, 1, 3}}, kSoft);
  std::vector<float> out;
  EXPECT_EQ(stress.look(std::vector<float>{0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0}, out), 0.0f);
  const float most = stress.look(std::vector<float>{0, 0, 0, 9, 0, 0, 2, 0, 0, 0, 7, 0}, out);
  EXPECT_TRUE(std::isfinite(most) && most > 0.0f);
  EXPECT_EQ(out[2], 0.0f);
  EXPECT_EQ(stress.look(std::vector<float>(12, 0.5f), out), out[0]);
  EXPECT_TRUE(std::isfinite(out[0]));
}

TEST(SurfaceStress, KnowsTheMaterialThatAFileTells) {
  const auto known = material_of_provenance(R"({"material": {"young_pa": 3.5, "poisson": 0.25}})");
  ASSERT_TRUE(known);
  EXPECT_EQ(known->young, 3.5);
  EXPECT_EQ(known->poisson, 0.25);
  for (const char* other :
       {"", "[]", "{}", "{\"material\": 3}", R"({"materials": []})",
        R"({"material": {"young_123_pa": [1, 2, 3]}})",
        R"({"material": {"young_pa": -1, "poisson": 0.2}})",
        R"({"material": {"young_pa": 1, "poisson": 0.5}})",
        R"({"material": {"young_pa": "1", "poisson": 0.2}})", "{\"material\": {\"young_pa\": 1"})
    EXPECT_FALSE(material_of_provenance(other)) << other;
  EXPECT_FALSE(material_of_provenance("{\"material\":" + std::string(100, '[')));
  EXPECT_FALSE(material_of_model("nothing.tremolo"));
  const auto beam = material_of_model(testing::sample_model("beam"));
  ASSERT_TRUE(beam);
  EXPECT_GT(beam->young, 0.0);
}

// A rectangle b x h whose corners are rounded by r: its area, and its second moment for bending
// along h; m.
struct BeamSection {
  double b, h, r;

  double area() const { return b * h - (4.0 - std::numbers::pi) * r * r; }
  double second_moment() const {
    const double pi = std::numbers::pi, quarter = 0.25 * pi * r * r, off = 4.0 * r / (3.0 * pi);
    const double square = r * r * r * r / 12.0 + std::pow(r * (0.5 * h - 0.5 * r), 2);
    const double round =
        quarter * (0.25 * r * r - off * off) + quarter * std::pow(0.5 * h - r + off, 2);
    return b * h * h * h / 12.0 - 4.0 * (square - round);
  }
};

// Deflection of the beam along an axis, at each of so many sections: the mean of a section's
// vertices.
std::vector<double> sections_of(const DrawnSurface& drawn, const Eigen::VectorXd& u, int axis,
                                std::size_t count) {
  std::vector<double> sums(count, 0.0), many(count, 0.0);
  for (std::size_t v = 0; v < drawn.rest.size(); ++v) {
    const double x = drawn.rest[v].x() / 0.4 * static_cast<double>(count);
    const std::size_t k = std::min(count - 1, static_cast<std::size_t>(std::max(x, 0.0)));
    sums[k] += u[3 * static_cast<Eigen::Index>(v) + axis];
    many[k] += 1.0;
  }
  for (std::size_t k = 0; k < count; ++k) sums[k] /= many[k];
  return sums;
}

// The beam's two softest modes, by equilibrium alone: the part beyond a section is moved by its own
// inertia, rho lambda u per unit of volume, whose moment M acts on the section; at its edge, at the
// distance c from the middle, the stress is M c / I.
TEST(SurfaceStress, OfABeamThatBendsIsItsMomentOverItsSection) {
  const std::string path = testing::sample_model("beam");  // 0.4 x 0.1 x 0.09 m, rounded by 14 mm
  const auto model = Model::load(path);
  ASSERT_TRUE(model) << model.error().message;
  const auto material = material_of_model(path);
  ASSERT_TRUE(material);
  const DrawnSurface drawn = (*model)->drawn();
  const SurfaceStress stress(drawn.rest, drawn.triangles, *material);
  constexpr std::size_t kSections = 20;
  for (const int axis : {2, 1}) {
    const int mode = axis == 2 ? 0 : 1;
    const BeamSection section =
        axis == 2 ? BeamSection{0.1, 0.09, 0.014} : BeamSection{0.09, 0.1, 0.014};
    const Eigen::VectorXd u = 1e-3 * drawn.rows.col(mode);
    std::vector<float> moved, out;
    for (std::size_t v = 0; v < drawn.rest.size(); ++v)
      for (Eigen::Index k = 0; k < 3; ++k)
        moved.push_back(
            static_cast<float>(drawn.rest[v][k] + u[3 * static_cast<Eigen::Index>(v) + k]));
    stress.look(moved, out);
    const std::vector<double> aside = sections_of(drawn, u, axis, kSections);
    double moment = 0.0, mean = 0.0;
    for (std::size_t k = kSections / 2; k < kSections; ++k)
      moment += 1100.0 * section.area() * (*model)->lambda()[mode] * std::abs(aside[k]) *
                (0.4 / kSections) * ((static_cast<double>(k) + 0.5) / kSections - 0.5) * 0.4;
    int count = 0;
    for (std::size_t v = 0; v < drawn.rest.size(); ++v) {
      const Vector3d& x = drawn.rest[v];
      const Eigen::Vector2d across(x.y() / 0.1, x.z() / 0.09 - 0.5);  // each from -0.5 to 0.5
      if (std::abs(x.x() - 0.2) > 0.008 || std::abs(across[axis == 2 ? 0 : 1]) > 0.25 ||
          std::abs(across[axis - 1]) < 0.495)
        continue;
      mean += static_cast<double>(out[v]);
      ++count;
    }
    ASSERT_GE(count, 8) << axis;
    mean /= count;
    // A beam of four heights: 4 % for shear, for the section's turning inertia and for an end that
    // is rounded.
    EXPECT_NEAR(mean, moment * 0.5 * section.h / section.second_moment(), 0.04 * mean) << axis;
  }
}

// The positions are rounded to single precision, far from the origin more coarsely.
TEST(SurfaceStress, OfAnUnloadedBodyIsZeroAndSmallLoadsAreSeen) {
  const std::vector<Vector3d> rest = {{0, 0, 0}, {0.013, 0.001, 0}, {0.002, 0.011, 0.003}};
  const Material rubber{.young = 1e6, .poisson = 0.45};
  const SurfaceStress stress(rest, kOne, rubber);
  const auto look = [&](const Vector3d& aside, double stretch) {
    std::vector<float> positions, out;
    for (const Vector3d& x : rest) {
      const Vector3d place = stretch * x + aside;
      for (const double coordinate : place) positions.push_back(static_cast<float>(coordinate));
    }
    const float most = stress.look(positions, out);
    EXPECT_EQ(*std::max_element(out.begin(), out.end()), most);
    return static_cast<double>(most);
  };
  for (const double aside : {0.0, 0.1, 1.0, 10.0})
    EXPECT_EQ(look(Vector3d(aside, 0.3 * aside, -0.7 * aside), 1.0), 0.0) << aside;
  // Plane stress E e / (1 - nu), equal along both axes.
  EXPECT_NEAR(look(Vector3d::Zero(), 1.0 + 1e-5), 1e6 * 1e-5 / 0.55, 1.0);
}

TEST(SurfaceStress, EachTriangleHasItsOwnMaterial) {
  const std::vector<Vector3d> rest = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 0, 0}, {6, 0, 0},
                                      {5, 1, 0}, {9, 0, 0}, {9, 1, 0}, {8, 1, 0}};
  const std::vector<Triangle> three = {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}};
  const std::vector<std::optional<Material>> materials = {
      Material{.young = 1e5, .poisson = 0.3}, Material{.young = 3e5, .poisson = 0.3}, std::nullopt};
  const SurfaceStress stress(rest, three, materials);
  std::vector<float> positions, out;
  for (const Vector3d& x : rest)
    for (const double coordinate : x) positions.push_back(static_cast<float>(1.01 * coordinate));
  const float most = stress.look(positions, out);
  EXPECT_EQ(most, out[3]);
  EXPECT_NEAR(out[3] / out[0], 3.0, 1e-3);
  EXPECT_EQ(out[6], 0.0f);
  EXPECT_TRUE(SurfaceStress(rest, three, std::vector<std::optional<Material>>(3)).empty());
}

}  // namespace
}  // namespace tremolo
