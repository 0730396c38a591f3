// Modes of equal frequency: the same vectors from every solver.
#include "precompute/modes/mode_clusters.h"

#include <random>

#include <Eigen/QR>
#include <gtest/gtest.h>

#include "common/energy.h"
#include "precompute/modes/certificate.h"
#include "precompute/problem/rigid_motion.h"
#include "precompute/ranks/halo.h"
#include "tests/support/computed_basis.h"
#include "tests/support/meshes/joined_mesh.h"
#include "tests/support/meshes/mesh_writers.h"
#include "tests/support/meshes/random_mesh.h"
#include "tests/support/meshes/symmetric_mesh.h"
#include "tests/support/solved_pencil.h"

namespace tremolo {
namespace {

using testing::symmetric_box;

struct ClusteredSystem {
  TetMesh mesh;
  MeshReport report;
  DofMap map;
  LocalDofs local;
  Matrices matrices;
  Marker marker;

  ClusteredSystem(const TetMesh& source, const std::vector<VertexId>& fixed)
      : mesh(source),
        report(*check_mesh(mesh)),
        map(make_dof_map(mesh, fixed, 1)),
        local(local_dofs(mesh, map, 0)),
        matrices(assemble(make_solid(mesh, {1e6, 0.4, 1100.0}), map, local, MassKind::kConsistent)),
        marker(make_marker(mesh, report.part_of_vertex, local)) {}

  Columns rigid() const {
    return rigid_modes(mesh, report.part_of_vertex, static_cast<int>(report.parts), local,
                       matrices.mass.get());
  }
  WholeModes modes(int count, bool extend = false) const {
    testing::SolvedPencil solved(matrices);
    return modes(solved, count, extend);
  }
  WholeModes modes(testing::SolvedPencil& solved, int count, bool extend = false) const {
    return make_whole(matrices.mass.get(), marker, count, available_modes(solved.pencil), extend,
                      compute_modes_and_equals(solved.pencil, *solved.solver, solved.shift, count));
  }
};

// A cantilever of square section, rotated by 0.3 about its length: bending in pairs.
TetMesh square_beam(int cells = 8) {
  TetMesh mesh = symmetric_box({cells, 2, 2}, {0.05 * cells, 0.1, 0.1});
  const Eigen::AngleAxisd turn(0.3, Eigen::Vector3d::UnitX());
  for (Eigen::Vector3d& x : mesh.vertices) x = turn * x;
  return mesh;
}
std::vector<VertexId> low_end(const TetMesh& mesh) {
  std::vector<VertexId> ids;
  const double low = bounding_box(mesh.vertices).low.x();
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (mesh.vertices[v].x() < low + 1e-6) ids.push_back(static_cast<VertexId>(v));
  return ids;
}
ClusteredSystem clamped_beam(int cells = 8) {
  const TetMesh mesh = square_beam(cells);
  return ClusteredSystem(mesh, low_end(mesh));
}

// While it lives SLEPc finds the modes.
struct BySlepc {
  BySlepc() { PetscOptionsSetValue(nullptr, "-eps_purify", "1"); }
  ~BySlepc() { PetscOptionsClearValue(nullptr, "-eps_purify"); }
};

// Largest distance of columns, up to the sign of each, relative.
double distance(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  double largest = 0;
  for (Eigen::Index c = 0; c < a.cols(); ++c)
    largest =
        std::max(largest, std::min((a.col(c) - b.col(c)).norm(), (a.col(c) + b.col(c)).norm()) /
                              a.col(c).norm());
  return largest;
}

Eigen::MatrixXd random_rotation(Eigen::Index size, unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  const Eigen::MatrixXd random =
      Eigen::MatrixXd::NullaryExpr(size, size, [&] { return normal(engine); });
  return Eigen::HouseholderQR<Eigen::MatrixXd>(random).householderQ();
}

TEST(ModeClusters, AreRunsOfNearValuesEitherWay) {
  Eigen::VectorXd values(8);
  values << 1.0, 1.0 + 1e-9, 2.0, 3.0, 3.0 * (1 + 5e-7), 3.0 * (1 + 1e-6), 4.0, 5.0;
  const auto up = find_clusters(values, {1e-6});
  ASSERT_EQ(up.size(), 2u);
  EXPECT_EQ(up[0].first, 0);
  EXPECT_EQ(up[0].count, 2);
  EXPECT_EQ(up[1].first, 3);
  EXPECT_EQ(up[1].count, 3);
  const auto down = find_clusters(values.reverse(), {1e-6});
  ASSERT_EQ(down.size(), 2u);
  EXPECT_EQ(down[0].first, 2);
  EXPECT_EQ(cluster_at_cut(values, 4, {1e-6}).count, 3);
  EXPECT_EQ(cluster_at_cut(values, 5, {1e-6}).first, 3);
  EXPECT_EQ(cluster_at_cut(values, 3, {1e-6}).count, 0) << "before the cluster";
  EXPECT_EQ(cluster_at_cut(values, 6, {1e-6}).count, 0) << "behind it";
  EXPECT_EQ(cluster_at_cut(values, 8, {1e-6}).count, 0);
}

TEST(ModeClusters, OfASlenderBodyAreWiderByItsRounding) {
  // Psi^T K psi of terms 1e8 times as large: eps * 1e8 is noise.
  const Nearness near = nearness(1.0, 1e-9);
  EXPECT_TRUE(near(1.0, 1.0 + 1e-5));
  EXPECT_FALSE(near(1.0, 1.0 + 1e-4));
  EXPECT_FALSE(near(1e4, 1e4 * (1 + 1e-5))) << "the same noise is less of a high mode";
  EXPECT_FALSE(nearness(1.0, 1e-14)(1.0, 1.002)) << "not everything is noise";
}

TEST(ModeClusters, AreTheSameHoweverASolverTurnedThem) {
  const ClusteredSystem beam = clamped_beam();
  const ClusteredSystem cube(symmetric_box({3, 3, 3}, {0.3, 0.3, 0.3}), {});
  const Modes of_beam = beam.modes(12, true).modes;
  testing::SolvedPencil free(cube.matrices, cube.rigid(), -100.0);
  const Modes of_cube = cube.modes(free, 16, true).modes;
  int largest = 0;
  for (const auto& [system, modes] : {std::pair{&beam, &of_beam}, {&cube, &of_cube}}) {
    const auto clusters = find_clusters(modes->squared_frequencies, {kClusterGap});
    EXPECT_GE(clusters.size(), 4u);
    for (const Cluster& cluster : clusters) {
      largest = std::max(largest, static_cast<int>(cluster.count));
      for (unsigned seed : {1u, 2u, 3u}) {
        Columns turned = modes->vectors;
        turned.middleCols(cluster.first, cluster.count) *= random_rotation(cluster.count, seed);
        make_canonical(system->matrices.mass.get(), system->marker, {cluster}, turned);
        // Rounding over the distance of the marks, which is a hundredth and more.
        EXPECT_LE(distance(modes->vectors, turned), 1e-12) << cluster.first;
      }
    }
  }
  EXPECT_EQ(largest, 3) << "a cube has triples";
}

TEST(ModeClusters, AreTheSameByBlocksAndBySlepc) {
  for (int cells : {8, 40}) {
    const ClusteredSystem beam = clamped_beam(cells);
    const Modes blocks = beam.modes(10, true).modes;
    ASSERT_GT(blocks.solves, 0);
    const BySlepc by_slepc;
    const Modes slepc = beam.modes(10, true).modes;
    ASSERT_EQ(slepc.solves, 0);
    // The spans differ by rounding only, 1e-12 of the slender beam's.
    EXPECT_LE(distance(blocks.vectors, slepc.vectors), 1e-9) << cells;
  }
}

TEST(ModeClusters, OfEqualPartsBelongToOnePartEach) {
  const TetMesh beam = symmetric_box({8, 2, 1}, {0.4, 0.1, 0.06});
  TetMesh two = beam;
  testing::join(two, beam, {0, 0.3, 0});
  const ClusteredSystem system(two, low_end(two));
  const Modes modes = system.modes(4).modes;
  ASSERT_EQ(find_clusters(modes.squared_frequencies, {kClusterGap}).size(), 2u);
  Columns turned = modes.vectors;
  turned.leftCols(2) *= random_rotation(2, 4);
  make_canonical(system.matrices.mass.get(), system.marker, {{0, 2}}, turned);
  EXPECT_LE(distance(modes.vectors, turned), 1e-12);
}

TEST(ModeClusters, DoNotDependOnPlaceSizeOrNumbersOfVertices) {
  const ClusteredSystem beam = clamped_beam();
  testing::Random random(2);
  const auto order = testing::random_permutation(beam.mesh.vertices.size(), random);
  TetMesh other = testing::renumbered(beam.mesh, order);
  for (Eigen::Vector3d& x : other.vertices) x = 8.0 * x + Eigen::Vector3d(1, -2, 3);
  const ClusteredSystem moved(other, low_end(other));
  const Eigen::MatrixXd a =
      expand_to_vertices(beam.map, beam.local, beam.modes(8, true).modes.vectors);
  const Eigen::MatrixXd b =
      expand_to_vertices(moved.map, moved.local, moved.modes(8, true).modes.vectors);
  Eigen::MatrixXd back(b.rows(), b.cols());
  for (std::size_t v = 0; v < order.size(); ++v)
    back.middleRows<3>(3 * static_cast<Eigen::Index>(v)) =
        b.middleRows<3>(3 * Eigen::Index{order[v]});
  // Moving the mesh rounds its coordinates again: pairs separate by 1e-14.
  EXPECT_LE(distance(a, std::sqrt(512.0) * back), 1e-8);
}

TEST(ModeClusters, CutInAPairGiveItsFirstAndANote) {
  const ClusteredSystem beam = clamped_beam();
  const WholeModes both = beam.modes(2);
  EXPECT_EQ(both.note, "") << both.note;
  testing::SolvedPencil solved(beam.matrices);
  const WholeModes one = beam.modes(solved, 1);
  EXPECT_NE(one.note.find("modes 1 and 2 have the same frequency"), std::string::npos) << one.note;
  EXPECT_NE(one.note.find("--linear-modes 2 takes both"), std::string::npos) << one.note;
  ASSERT_EQ(one.modes.vectors.cols(), 1);
  EXPECT_LE(distance(both.modes.vectors.leftCols(1), one.modes.vectors), 1e-9);
  ASSERT_GE(one.modes.left_out.size(), 2u);
  EXPECT_NEAR(one.modes.left_out[0], one.modes.squared_frequencies[0],
              kClusterGap * one.modes.left_out[0]);
  // The bound lies beyond the pair: it is known to be one.
  const InertiaCertificate certificate = certify(*solved.solver, one.modes, 0);
  EXPECT_EQ(certificate.expected, 2);
  EXPECT_TRUE(certificate.complete());
  const WholeModes extended = beam.modes(1, true);
  EXPECT_EQ(extended.modes.vectors.cols(), 2);
  EXPECT_NE(extended.note.find("2 linear modes, not 1"), std::string::npos) << extended.note;
}

TEST(ModeClusters, LargerThanAPairAreComputedToTheirEnd) {
  // Five equal plates, four of them cut off.
  const TetMesh plate = symmetric_box({4, 3, 1}, {0.4, 0.23, 0.03});
  TetMesh five = plate;
  for (int i = 1; i < 5; ++i) testing::join(five, plate, {0, 0, 0.1 * i});
  const ClusteredSystem system(five, low_end(five));
  const WholeModes one = system.modes(1);
  EXPECT_NE(one.note.find("modes 1 to 5 have"), std::string::npos) << one.note;
  EXPECT_NE(one.note.find("--linear-modes 5 takes all"), std::string::npos) << one.note;
  EXPECT_EQ(system.modes(1, true).modes.vectors.cols(), 5);
  EXPECT_LE(distance(system.modes(5).modes.vectors.leftCols(1), one.modes.vectors), 1e-9);
}

BasisData precompute(const TetMesh& mesh, int k, int r) {
  PrecomputeRequest request = testing::basis_request({1e6, 0.4, 1100.0}, "x<-0.199");
  if (k > 0) request.basis.linear_modes = k;
  if (r > 0) request.basis.modes = r;
  testing::ComputedBasis made = testing::compute_basis(mesh, request);
  collect_rows(spread(made.loaded, made.result.rows), made.result.data);
  return std::move(made.result.data);
}

Eigen::VectorXd force(const BasisData& data, const Eigen::VectorXd& q) {
  return reduced_energy(data.lambda, data.cubic, data.quartic, q).force;
}

TEST(ModeClusters, TheModelOfASymmetricBodyIsTheSameBySlepc) {
  // Neither k nor r cut between equals; r does; k does; both do.
  for (const auto& [k, r] : {std::pair{6, 12}, {6, 5}, {7, 11}, {1, 1}}) {
    const BasisData a = precompute(square_beam(), k, r);
    const BySlepc by_slepc;
    const BasisData b = precompute(square_beam(), k, r);
    ASSERT_EQ(a.lambda.size(), r);
    ASSERT_EQ(b.lambda.size(), r);
    const Eigen::MatrixXd x = a.surface.rows, y = b.surface.rows;
    // The same span, and the same forces in it.
    const Eigen::MatrixXd turn = y.colPivHouseholderQr().solve(x);
    EXPECT_LE((x - y * turn).norm(), 1e-10 * x.norm()) << k << " " << r;
    Eigen::VectorXd q =
        Eigen::VectorXd::LinSpaced(r, 1.0, 0.3)
            .cwiseQuotient(
                a.lambda.cwiseSqrt());  // centimetres: the nonlinear half is as large as the linear
    q *= 0.1 / (x * q).cwiseAbs().maxCoeff();
    EXPECT_LE((force(a, q) - turn.transpose() * force(b, turn * q)).norm(),
              1e-10 * force(a, q).norm())
        << k << " " << r;
    // A model of half a pair has no symmetry left: the first two Lambdas differ by 3e-8, and their
    // coordinates rotate by rounding over that. Signs are a convention of the file.
    const double tolerance = k == 7 || r == 5 ? 1e-4 : 1e-10;
    EXPECT_LE((x - y).norm(), tolerance * x.norm()) << k << " " << r;
  }
}

TEST(ModeClusters, DefaultsDoNotCutBetweenEquals) {
  const auto modes = [](int r) { return precompute(square_beam(), 0, r).linear_mode_count; };
  EXPECT_EQ(modes(0), 15U);
  EXPECT_EQ(modes(32), 16U);
  EXPECT_EQ(modes(29), 21U) << "modes 20 and 21 are a pair";
  EXPECT_EQ(modes(48), 21U);
}

}  // namespace
}  // namespace tremolo
