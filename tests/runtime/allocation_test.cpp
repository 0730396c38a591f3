// Nothing is allocated in a step. Every request for memory is counted: operator new and Eigen both
// end in malloc, which this executable replaces (or, under a sanitizer, hooks).
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdlib>

#include <gtest/gtest.h>

#include "runtime/bodies/reduced/integrators/solve/newton.h"
#include "runtime/body.h"
#include "runtime/contact/collider.h"
#include "runtime/crowd.h"
#include "tests/support/distance_fields.h"
#include "tests/support/dynamics.h"
#include "tests/support/linear_model.h"

namespace {
std::atomic<long> allocations = 0;  // of all threads
}

#if defined(TREMOLO_SANITIZED)
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*)(const volatile void*,
                                                                  std::size_t),
                                                         void (*)(const volatile void*));
namespace {
const int hooks = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t) { ++allocations; }, [](const volatile void*) {});
}
#elif defined(__GLIBC__)
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* pointer, std::size_t size) {
  ++allocations;
  return __libc_realloc(pointer, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++allocations;
  return __libc_memalign(alignment, size);
}
}
#endif

namespace tremolo {
namespace {

// Deep enough into the nonlinear range for several corrections a step.
Body shaken_body(std::string_view integrator, Eigen::Index r) {
  const testing::StrainModel strain =
      testing::random_strain_model(testing::spread_omega(r, 5.0, 900.0), 0.02, 61);
  IntegratorOptions options{
      .step = testing::is_explicit(integrator) ? 2e-4 : 3e-3, .alpha = 0.3, .beta = 1e-6};
  Result<Body> body = Body::create(testing::make_model(strain), integrator, options);
  EXPECT_TRUE(body);
  EXPECT_TRUE(
      body->set_state(testing::random_vector(r, 0.02, 1), testing::random_vector(r, 1.0, 2)));
  EXPECT_TRUE(body->add_load({.kind = SignalKind::kSine}, 5, {0.1, 0.2, 0.3}));
  EXPECT_TRUE(body->apply_force(5, {1.0, 0.0, 0.0}, 3));
  return std::move(*body);
}

long allocations_of_steps(Body& body, int count) {
  const long before = allocations;
  bool converged = true;
  for (int k = 0; k < count; ++k) converged = body.step().converged && converged;
  const long after = allocations;
  EXPECT_TRUE(converged);
  return after - before;
}

TEST(Allocation, IsSeenByTheCounter) {
  const long before = allocations;
  const Eigen::VectorXd vector = Eigen::VectorXd::Zero(100);
  const std::vector<double> other(static_cast<std::size_t>(vector.size()), vector[3]);
  EXPECT_GE(allocations - before, 2) << other.size();
}

TEST(Allocation, NoStepOfAnyMethodAllocates) {
  for (const Eigen::Index r : {1, 2, 15, 20})
    for (const std::string_view name : integrator_names()) {
      Body body = shaken_body(name, r);
      // From the very first step on: everything is made when the body is.
      EXPECT_EQ(allocations_of_steps(body, 20), 0) << name << ", r = " << r;
    }
}

TEST(Allocation, NoStepOfALargeLinearModelAllocates) {
  for (const double alpha : {0.0, 0.3}) {
    Result<Body> body = Body::create(testing::linear_model(testing::spread_omega(600, 5.0, 9e4)),
                                     "ep4", {.step = 1.0 / 44100.0, .alpha = alpha});
    ASSERT_TRUE(body);
    ASSERT_TRUE(body->add_load({.kind = SignalKind::kSine}, 5, {0.1, 0.2, 0.3}));
    ASSERT_TRUE(body->apply_force(5, {1.0, 0.0, 0.0}, 3));
    EXPECT_EQ(allocations_of_steps(*body, 20), 0) << alpha;
  }
}

TEST(Allocation, NoStepAllocatesWhereTheJacobianIsIndefinite) {
  for (const Eigen::Index n : {3, 20, 60, 100}) {
    NewtonWorkspace workspace(n);
    const Eigen::MatrixXd random = testing::random_vector(n * n, 1.0, 4).reshaped(n, n);
    workspace.jacobian = random + random.transpose();
    workspace.residual = testing::random_vector(n, 1.0, 5);
    const long before = allocations;
    solve_correction(workspace);
    EXPECT_EQ(allocations - before, 0) << n;
    workspace.jacobian.diagonal().array() += 4.0 * static_cast<double>(n);
    const long again = allocations;
    solve_correction(workspace);
    EXPECT_EQ(allocations - again, 0) << n;
  }
}

TEST(Allocation, NoStepOfACrowdAllocatesNorDoItsSurfaces) {
  const Model::Pointer model = testing::make_model(
      testing::random_strain_model(testing::spread_omega(9, 5.0, 900.0), 0.02, 61));
  Crowd world = std::move(*Crowd::create(2));
  for (const std::string_view method : {"imexv-linear", "ep4"}) {
    GroupOptions options{.integrator = method, .options = {.alpha = 6.0}};
    options.sleep = {.energy = 1e-2, .time = 0.05};
    options.precision = LanePrecision::kFloat;
    const GroupId group = *world.add_group(model, options);
    for (unsigned b = 0; b < 40; ++b) {
      const BodyId body = *world.add_body(group);
      ASSERT_TRUE(world.set_shown(body, true));
      ASSERT_TRUE(world.set_state(body, testing::random_vector(9, 0.02, b),
                                  testing::random_vector(9, 1.0, 99 + b)));
      ASSERT_TRUE(world.apply_force(body, 5, {1.0, 0.0, 0.0}, 3));
    }
  }
  // One that leaves the numbers, and all the others fall asleep.
  const Eigen::VectorXd huge = Eigen::VectorXd::Constant(9, 1e200);
  ASSERT_TRUE(world.set_state(7, huge, huge));
  std::size_t failed = 0, fell_asleep = 0;
  const long before = allocations;
  for (int k = 0; k < 600; ++k) {
    const CrowdReport& report = world.step();
    failed += report.failed.size();
    fell_asleep += report.fell_asleep;
    world.update_surfaces();
  }
  EXPECT_EQ(allocations - before, 0);
  EXPECT_EQ(failed, 1u);
  EXPECT_EQ(fell_asleep, 79u);
}

TEST(Allocation, ReadingTheSurfaceAndEnergyAllocatesNothingAfterTheFirstTime) {
  Body body = shaken_body("imexv-thesis", 15);
  std::vector<float> positions(15), normals(15);
  std::vector<double> exact(15);
  // The model's rows in float are made at the first call, the scratch for normals too.
  ASSERT_TRUE(body.surface(positions, normals));
  const long before = allocations;
  const bool written = static_cast<bool>(body.surface(positions)) &&
                       static_cast<bool>(body.surface(positions, normals)) &&
                       static_cast<bool>(body.surface_positions(exact));
  const double energy = body.energy().total();
  const long after = allocations;
  EXPECT_TRUE(written);
  EXPECT_GT(energy, 0.0);
  EXPECT_EQ(after - before, 0);
}

TEST(Allocation, CollidersAreAskedWithoutMemory) {
  const Collider colliders[] = {
      PlaneShape{},
      SphereShape{},
      CapsuleShape{},
      BoxShape{},
      CylinderShape{},
      GridShape{std::make_shared<const DistanceGrid>(
          testing::grid_of(testing::cube_of_nodes(1.5, 8), testing::sphere_formula(1.0)))}};
  double sum = 0.0;
  const long before = allocations;
  for (const Collider& collider : colliders)
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector3d x(0.1 * i, 0.05 * i, 2.0 - 0.08 * i);
      sum += signed_distance(collider, x).normal.sum() + bounds(collider).low.x() +
             first_hit(collider, x, -x).value_or(0.0);
    }
  const long after = allocations;
  EXPECT_EQ(after - before, 0);
  EXPECT_FALSE(std::isnan(sum));
}

}  // namespace
}  // namespace tremolo
