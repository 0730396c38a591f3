// Static equilibrium of the unreduced body: against its own forces, its linear limit, and closed
// forms of homogeneous deformation that linear tetrahedra take exactly.
#include <cmath>

#include <gtest/gtest.h>

#include "precompute/reference/full/step_equation.h"
#include "tests/support/reference_body.h"

namespace tremolo {
namespace {

using testing::bar_problem;
using testing::ReferenceBody;
using testing::vertices_on_plane;

Vector force_at(const FullOrder& body, const Vector& u) {
  return restrict_to(body.unknowns, internal_force(body.solid, expand(body.unknowns, u)));
}

std::vector<VertexId> all_vertices(const TetMesh& mesh) {
  std::vector<VertexId> ids;
  for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertices.size()); ++v) ids.push_back(v);
  return ids;
}

TEST(ReferenceStatics, TheInnerForceBalancesALargeLoad) {
  for (const Material& material : {Material{2e5, 0.3, 1000.0}, testing::wood()}) {
    ReferenceBody bar(bar_problem(material));
    const Vector load = bar.tip_load(5.0) + gravity_load(bar.body, {0, -9.81, 0});
    const StaticSolution solution = static_solution(bar.system, load);
    EXPECT_GT(solution.u.cwiseAbs().maxCoeff(), 0.1);
    EXPECT_LE((force_at(bar.body, solution.u) - load).norm(), 1e-7 * load.norm());
    EXPECT_LE(solution.residual, bar.solver.options.tolerance);
    EXPECT_NEAR(solution.energy, potential_energy(bar.body, solution.u), 1e-14 * solution.energy);
    ReferenceBody again(bar_problem(material));
    again.body.threads = 2;
    EXPECT_EQ(static_solution(again.system, load).u, solution.u);
  }
}

TEST(ReferenceStatics, AMinimumAndNotOnlyAnEquilibrium) {
  ReferenceBody bar(bar_problem());
  const Vector load = bar.tip_load(5.0);
  const StaticSolution solution = static_solution(bar.system, load);
  const double least = solution.energy - solution.work;
  for (unsigned seed = 0; seed < 10; ++seed) {
    const Vector near = solution.u + bar.random(1e-3, seed);
    EXPECT_GT(potential_energy(bar.body, near) - load.dot(near), least);
  }
}

TEST(ReferenceStatics, SmallLoadsAnswerLinearlyUpToTheirSquare) {
  ReferenceBody bar(bar_problem());
  const auto miss = [&](double newton) {
    const Vector load = bar.tip_load(newton);
    const Vector u = static_solution(bar.system, load).u;
    return (multiply(bar.body, bar.body.stiffness, u) - load).norm() / load.norm();
  };
  const double large = miss(1e-3), small = miss(1e-4);
  EXPECT_LE(large, 1e-2);
  EXPECT_NEAR(large / small, 10.0, 1.0);  // K u - f is of the order u^2
}

TEST(ReferenceStatics, AFreeBodyDeformsWithoutRigidMotion) {
  Problem problem = testing::box_problem({4, 1, 2}, {0.4, 0.05, 0.1}, {2e5, 0.3, 1000.0});
  problem.free_body = true;
  ReferenceBody bar(problem);
  Vector load = bar.tip_load(4.0);
  const StaticSolution solution = static_solution(bar.system, load);
  const double size = std::sqrt(solution.u.dot(bar.system.mass_times(solution.u)));
  EXPECT_GT(size, 0);
  EXPECT_LE((bar.body.mass_rigid.transpose() * solution.u).norm(), 1e-10 * size);
  Vector left = force_at(bar.body, solution.u) - load;
  remove_rigid_force(bar.body, left);
  EXPECT_LE(left.norm(), 1e-7 * load.norm());
  // Gravity accelerates all parts equally: the motion is rigid.
  Vector weight = gravity_load(bar.body, {0, 0, -9.81});
  const double heavy = weight.norm();
  remove_rigid_force(bar.body, weight);
  EXPECT_LE(weight.norm(), 1e-12 * heavy);
}

// E = (s^2 - 1)/2, S = (lambda + 2 mu) E, and the force on the unit of undeformed area is s S.
TEST(ReferenceStatics, AColumnInUniaxialStrainHasItsClosedForm) {
  const Material material{3e5, 0.35, 900.0};
  Problem problem = testing::box_problem({2, 2, 4}, {0.2, 0.2, 0.5}, material);
  problem.fixed = vertices_on_plane(problem.mesh, 2, 0.0);
  problem.held[0] = problem.held[1] = all_vertices(problem.mesh);
  ReferenceBody column(problem);
  const double modulus = lame_lambda(material) + 2 * lame_mu(material);
  for (const double stretch : {1.4, 1.05, 0.8}) {
    const double traction = modulus * stretch * 0.5 * (stretch * stretch - 1);
    const Vector load =
        point_load(column.body, testing::traction_load(problem.mesh, 2, 0.5, {0, 0, traction}));
    const Vector u = expand(column.body.unknowns, static_solution(column.system, load).u);
    for (std::size_t v = 0; v < problem.mesh.vertices.size(); ++v)
      EXPECT_NEAR(u[3 * static_cast<Eigen::Index>(v) + 2],
                  (stretch - 1) * problem.mesh.vertices[v].z(), 1e-8)
          << stretch;
  }
}

// Held along z everywhere, free to contract along y: S_yy = 0.
TEST(ReferenceStatics, ASlabInPlaneStrainHasItsClosedForm) {
  const Material material{3e5, 0.3, 900.0};
  Problem problem = testing::box_problem({4, 3, 1}, {0.4, 0.3, 0.05}, material);
  problem.held[0] = vertices_on_plane(problem.mesh, 0, 0.0);
  problem.held[1] = vertices_on_plane(problem.mesh, 1, 0.0);
  problem.held[2] = all_vertices(problem.mesh);
  ReferenceBody slab(problem);
  const double lambda = lame_lambda(material), mu = lame_mu(material), stretch = 1.3;
  const double strain = 0.5 * (stretch * stretch - 1);
  const double across = std::sqrt(1 - 2 * strain * lambda / (lambda + 2 * mu));
  const double traction = stretch * strain * 4 * mu * (lambda + mu) / (lambda + 2 * mu);
  const Vector load =
      point_load(slab.body, testing::traction_load(problem.mesh, 0, 0.4, {traction, 0, 0}));
  const Vector u = expand(slab.body.unknowns, static_solution(slab.system, load).u);
  for (std::size_t v = 0; v < problem.mesh.vertices.size(); ++v) {
    const Eigen::Vector3d moved = u.segment<3>(3 * static_cast<Eigen::Index>(v));
    const Eigen::Vector3d& x = problem.mesh.vertices[v];
    EXPECT_LE((moved - Eigen::Vector3d((stretch - 1) * x.x(), (across - 1) * x.y(), 0)).norm(),
              1e-8);
  }
}

TEST(ReferenceStatics, WhatCannotBeReachedIsASolverFailureThatSaysHowFarItCame) {
  ReferenceBody bar(bar_problem());
  bar.solver.options.max_iterations = 1;
  try {
    static_solution(bar.system, bar.tip_load(5.0));
    FAIL() << "no failure";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.error().kind, ErrorKind::kSolver);
    EXPECT_NE(failure.error().message.find("of the load"), std::string::npos);
  }
}

TEST(ReferenceStatics, AMechanismIsRefused) {
  Problem problem = bar_problem();
  problem.fixed = {0};  // rotates about the corner
  ReferenceBody bar(problem);
  try {
    static_solution(bar.system, bar.tip_load(0.1));
    FAIL() << "no failure";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.error().kind, ErrorKind::kSolver);
  }
}

}  // namespace
}  // namespace tremolo
