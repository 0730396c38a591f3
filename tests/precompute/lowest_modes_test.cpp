// The lowest frequencies of a basis where they are a cluster: a free ring against the closed forms
// of Love and of the thin ring's bending out of its plane.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "precompute/problem/rigid_motion.h"
#include "precompute/ranks/halo.h"
#include "precompute/reduction/basis.h"
#include "precompute/reduction/derivatives.h"
#include "precompute/reduction/third_derivatives.h"
#include "tests/support/assembled_body.h"
#include "tests/support/meshes/box_mesh.h"
#include "tests/support/solved_pencil.h"

namespace tremolo {
namespace {

constexpr double kRadius = 0.2, kThickness = 0.01;  // m
const Material kRubber{1e6, 0.0, 1000.0};

// A bar of square section, bent into a ring whose ends are one.
TetMesh ring_mesh(int cells) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const TetMesh bar = testing::box_mesh({cells, 1, 1}, {1.0, kThickness, kThickness});
  std::vector<VertexId> number(bar.vertices.size());
  TetMesh ring;
  const auto bent = [&](const Eigen::Vector3d& x) {
    const double radius = kRadius + x.y() - 0.5 * kThickness, angle = kTurn * x.x();
    return Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), x.z());
  };
  for (std::size_t v = 0; v < number.size(); ++v) {
    const Eigen::Vector3d place = bent(bar.vertices[v]);
    std::size_t same = 0;
    while (same < ring.vertices.size() && (ring.vertices[same] - place).norm() > 1e-6) ++same;
    if (same == ring.vertices.size()) ring.vertices.push_back(place);
    number[v] = static_cast<VertexId>(same);
  }
  for (Tetrahedron tetrahedron : bar.tetrahedra) {
    for (VertexId& v : tetrahedron) v = number[v];
    ring.tetrahedra.push_back(tetrahedron);
  }
  EXPECT_TRUE(check_mesh(ring));
  return ring;
}

// Frequencies of bending with n waves in the ring's plane and out of it, rad/s, twice each.
std::vector<double> closed_form(int most_waves) {
  const double area = kThickness * kThickness, bending = kRubber.young * area * area / 12.0;
  const double torsion = 0.1406 * 0.5 * kRubber.young * area * area;
  const double unit = std::sqrt(bending / (kRubber.density * area * std::pow(kRadius, 4)));
  std::vector<double> omega;
  for (int n = 2; n <= most_waves; ++n)
    for (const double ratio : {1.0, bending / torsion})
      omega.insert(omega.end(), 2, unit * n * (n * n - 1) / std::sqrt(n * n + ratio));
  std::sort(omega.begin(), omega.end());
  return omega;
}

TEST(LowestModes, OfARingAreThoseOfTheClosedForm) {
  constexpr int kModes = 20, kCoordinates = 30;
  const testing::AssembledBody ring(testing::of_order(ring_mesh(48), 2), {{{"", kRubber}}, {}}, {},
                                    {}, MassKind::kConsistent);
  const Columns rigid =
      rigid_modes(ring.mesh, ring.report.part_of_vertex, 1, ring.local, ring.matrices.mass.get());
  testing::SolvedPencil solved(ring.matrices, rigid, -40.0);
  const Modes modes = solved.modes(kModes);
  const Eigen::MatrixXd psi = expand_to_vertices(ring.map, ring.local, modes.vectors);
  ModalDerivatives derivatives =
      modal_derivatives(ring.solid, ring.local, solved.pencil, *solved.solver, modes.vectors, psi);
  const Eigen::VectorXd& w2 = modes.squared_frequencies;
  add_third_derivatives({ring.solid, ring.map, ring.local, solved.pencil, *solved.solver}, psi,
                        leading_modes(w2), derivatives);
  const double amplitude = 0.04 / psi.col(0).cwiseAbs().maxCoeff();
  const PrincipalColumns all =
      principal_columns(ring.matrices, derivatives.columns, w2, amplitude, 2);
  const std::vector<double> truth = closed_form(4);
  const auto farthest = [&](std::optional<int> asked) {
    PrincipalColumns principal = all;
    const Eigen::Index kept =
        keep_lowest_modes(ring.matrices, modes.vectors, w2, kCoordinates, asked, 2, principal);
    EXPECT_EQ(kept, asked ? *asked : lowest_modes(w2, kCoordinates));
    const Basis basis = make_basis(ring.matrices, std::move(principal), {kCoordinates, 2});
    EXPECT_LE(basis.orthonormality_error, 1e-10);
    EXPECT_EQ(note_on_modes(basis.lambda, w2.head(12)).empty(), !asked);
    double off = 0.0;
    for (std::size_t i = 0; i < truth.size(); ++i)
      off = std::max(
          off, std::abs(std::sqrt(basis.lambda[static_cast<Eigen::Index>(i)]) / truth[i] - 1.0));
    return off;
  };
  EXPECT_LE(farthest({}), 0.04);  // the closed forms' own error: rotary inertia, shear, mesh
  EXPECT_GE(farthest(0), 0.5);    // by singular values alone
}

TEST(LowestModes, AreNamedWhereTheBasisHasThemTooHigh) {
  const auto squares = [](Eigen::ArrayXd hertz) {
    return Eigen::VectorXd((2.0 * std::numbers::pi * hertz).square());
  };
  const Eigen::VectorXd mesh = squares(Eigen::Array3d(1.0, 2.0, 3.0));
  EXPECT_EQ(note_on_modes(squares(Eigen::Array4d(1.01, 2.03, 3.0, 9.0)), mesh), "");
  const std::string note = note_on_modes(squares(Eigen::Array4d(1.0, 2.5, 3.0, 9.0)), mesh);
  EXPECT_NE(note.find("1 of the 3 linear modes"), std::string::npos) << note;
  EXPECT_NE(note.find("2 (2 Hz in the mesh, 2.5 in the model)"), std::string::npos) << note;
  EXPECT_NE(note.find("--modes 6"), std::string::npos) << note;
}

TEST(LowestModes, AreHalfOfTheCoordinatesAndWholeClusters) {
  Eigen::VectorXd w2(6);
  w2 << 1.0, 2.0, 2.0005, 5.0, 6.0, 7.0;
  EXPECT_EQ(lowest_modes(w2, 4), 3);
  EXPECT_EQ(lowest_modes(w2, 6), 3);
  EXPECT_EQ(lowest_modes(w2, 30), 6);
  EXPECT_EQ(lowest_modes(w2, 1), 0);
}

}  // namespace
}  // namespace tremolo
