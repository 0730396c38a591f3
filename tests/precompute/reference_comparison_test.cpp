// A reduced model compared with the unreduced body: a basis that fills the space reproduces it.
#include <cmath>

#include <gtest/gtest.h>

#include "precompute/reference/comparison.h"
#include "precompute/reference/full/step_equation.h"
#include "precompute/reference/time_integration.h"
#include "precompute/report.h"
#include "tests/support/computed_basis.h"
#include "tests/support/reference_body.h"

namespace tremolo {
namespace {

using testing::ReferenceBody;

const Material kReferenceMaterial{2e5, 0.3, 1000.0};

// A block of 24 free dofs, or free altogether, and the basis of its mesh.
struct ReducedBlock {
  testing::ComputedBasis made;

  ReducedBlock(bool free_body, int modes) {
    PrecomputeRequest request =
        testing::basis_request(kReferenceMaterial, free_body ? "none" : "x<0.01");
    request.basis.linear_modes = modes;
    request.basis.modes = modes;
    made = testing::compute_basis(testing::box_mesh({2, 1, 1}, {0.3, 0.1, 0.12}), request);
    PrecomputeResult& result = made.result;
    collect_rows(spread(made.loaded, result.rows), result.data);
    result.data.provenance = provenance_json(made.request, made.loaded.problem, result);
  }
  Problem problem() const {
    const Problem& loaded = made.loaded.problem;
    Problem same;
    same.mesh = loaded.mesh;
    same.report = loaded.report;
    same.materials = loaded.materials;
    same.fixed = loaded.fixed;
    same.free_body = loaded.free_body;
    same.mesh_hash = loaded.mesh_hash;
    return same;
  }
  ReducedBody reduced(const FullOrder& body, std::optional<int> modes = {}) const {
    return make_reduced_body(body, made.result.data, made.loaded.problem.mesh_hash, modes, "file");
  }
};

// The force if the body were linear.
Vector force_at_rest(const FullOrder& body, const Vector& u) {
  return multiply(body, body.stiffness, u);
}

Vector mass_times(const FullOrder& body, const Vector& u) {
  return multiply(body, body.mass, u);
}

class CompleteBasis : public ::testing::TestWithParam<bool> {};

TEST_P(CompleteBasis, ReproducesStaticsAndMotion) {
  const ReducedBlock block(GetParam(), GetParam() ? 30 : 24);
  ReferenceBody full(block.problem());
  full.solver.options.tolerance = 1e-12;
  const ReducedBody reduced = block.reduced(full.body);
  const SecondOrderSystem small = make_system(reduced.model, full.solver.options);
  const Vector load = full.tip_load(GetParam() ? 300.0 : 60.0);
  const Vector reduced_load = reduced.basis.transpose() * load;
  const auto expect_alike = [&](const Vector& u, const Vector& q) {
    const Moment moment = compare(full.body, reduced, u, mass_times(full.body, u), q, {0, 11});
    EXPECT_GT(moment.norm, 0);
    EXPECT_LE(moment.projection, 1e-9 * moment.norm);
    EXPECT_LE(moment.difference, 1e-7 * moment.norm);
    EXPECT_LE(moment.tip_difference, 1e-7 * moment.tip);
    EXPECT_NEAR(moment.mac, 1.0, 1e-12);
  };
  const StaticSolution bent = static_solution(full.system, load);
  const StaticSolution also_bent = static_solution(small, reduced_load);
  // Far enough for the cubic terms to count.
  EXPECT_GT((force_at_rest(full.body, bent.u) - load).norm(), 0.05 * load.norm());
  EXPECT_NEAR(bent.energy, also_bent.energy, 1e-9 * bent.energy);
  expect_alike(bent.u, also_bent.u);

  for (TimeScheme scheme : {TimeScheme::kMidpoint, TimeScheme::kAveragedField}) {
    const TimeSettings settings{scheme, 2e-3, 1.0, 1e-4};
    Motion motion = start_motion(full.system, Vector::Zero(load.size()), Vector::Zero(load.size()));
    Motion other = start_motion(small, Vector::Zero(small.size), Vector::Zero(small.size));
    for (int k = 0; k < 60; ++k) {
      advance(
          full.system, settings, [&](double, double) { return load; }, motion);
      advance(
          small, settings, [&](double, double) { return reduced_load; }, other);
    }
    expect_alike(motion.u, other.u);
    EXPECT_NEAR(other.total(), motion.total(), 1e-7 * motion.total());
  }
  EXPECT_NEAR(unseen_load(reduced, load, linear_response(full.solver, load)), 0.0, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Bodies, CompleteBasis, ::testing::Values(false, true),
                         [](const auto& body) { return body.param ? "Free" : "Held"; });

TEST(ReferenceComparison, AShorterBasisIsWorseButNeverBetterThanItsProjection) {
  const ReducedBlock block(false, 24);
  ReferenceBody full(block.problem());
  const Vector load = full.tip_load(8.0);
  const Vector u = static_solution(full.system, load).u;
  const ReducedBody whole = block.reduced(full.body);
  const Vector response = linear_response(full.solver, load);
  double unseen = 1.0, projection = 1.0;
  for (int r : {2, 6, 12, 20}) {
    const ReducedBody reduced = block.reduced(full.body, r);
    EXPECT_EQ(reduced.model.size(), r);
    EXPECT_EQ(reduced.basis, whole.basis.leftCols(r));
    EXPECT_EQ(reduced.model.quartic, first_coordinates(whole.model, r).quartic);
    const SecondOrderSystem small = make_system(reduced.model, {});
    const Vector q = static_solution(small, reduced.basis.transpose() * load).u;
    const Moment moment = compare(full.body, reduced, u, mass_times(full.body, u), q, {});
    EXPECT_GE(moment.difference, moment.projection);
    EXPECT_LE(moment.projection / moment.norm, projection);
    projection = moment.projection / moment.norm;
    const double now = unseen_load(reduced, load, response);
    EXPECT_GE(now, 0.0);
    EXPECT_LE(now, unseen);
    unseen = now;
    const ComparisonSummary summary = summarise({moment, Moment{}});
    EXPECT_DOUBLE_EQ(summary.error_of_largest, moment.difference / moment.norm);
    EXPECT_DOUBLE_EQ(summary.mac_least, moment.mac);
  }
  EXPECT_LT(unseen, 0.5);
}

TEST(ReferenceComparison, WhatIsNotMeasuredIsNoNumber) {
  const ComparisonSummary nothing = summarise({Moment{}, Moment{}});
  EXPECT_TRUE(std::isnan(nothing.error_of_largest));
  EXPECT_TRUE(std::isnan(nothing.mac_least));
  Moment moved;
  moved.norm = 1.0;
  moved.mac = 0.5;
  const ComparisonSummary unwatched = summarise({moved});
  EXPECT_TRUE(std::isnan(unwatched.tip_error_of_largest));
  EXPECT_EQ(unwatched.mac_least, 0.5);
  EXPECT_EQ(unwatched.error_of_largest, 0.0);
}

void expect_refused(const FullOrder& body, const BasisData& data, const std::string& hash,
                    const std::string& words) {
  try {
    make_reduced_body(body, data, hash, {}, "out.tremolo");
    FAIL() << "no failure";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.error().kind, ErrorKind::kContent);
    EXPECT_NE(failure.error().message.find(words), std::string::npos) << failure.error().message;
  }
}

TEST(ReferenceComparison, AnotherMeshMaterialOrFixIsRefused) {
  const ReducedBlock block(false, 6);
  const ReferenceBody full(block.problem());
  expect_refused(full.body, block.made.result.data, "0123456789abcdef", "made of another mesh");
  BasisData nameless = block.made.result.data;
  nameless.provenance = "{}";
  expect_refused(full.body, nameless, block.problem().mesh_hash, "hash unknown");
  Problem harder = block.problem();
  harder.materials.materials.front().material.young *= 2;
  const ReferenceBody hard(harder);
  expect_refused(hard.body, block.made.result.data, harder.mesh_hash, "other materials");
  Problem little = block.problem();
  little.materials.materials.front().material.young *= 1.0 + 1e-5;
  expect_refused(ReferenceBody(little).body, block.made.result.data, little.mesh_hash,
                 "other materials");
  Problem heavier = block.problem();
  heavier.materials.materials.front().material.density *= 2;
  const ReferenceBody heavy(heavier);
  expect_refused(heavy.body, block.made.result.data, heavier.mesh_hash, "other materials");
  Problem held = block.problem();
  held.fixed.push_back(11);
  const ReferenceBody stiff(held);
  expect_refused(stiff.body, block.made.result.data, held.mesh_hash, "held here");
  // The other way round its rows are zeros, which would fit any body.
  Problem looser = block.problem();
  looser.fixed.pop_back();
  expect_refused(ReferenceBody(looser).body, block.made.result.data, looser.mesh_hash,
                 "moves here");
  Problem loose = block.problem();
  loose.fixed.clear();
  loose.free_body = true;
  expect_refused(ReferenceBody(loose).body, block.made.result.data, loose.mesh_hash, "moves here");
  const ReducedBlock floating(true, 6);
  expect_refused(full.body, floating.made.result.data, block.problem().mesh_hash, "held here");
}

}  // namespace
}  // namespace tremolo
