// Nothing is allocated in a step of an island with bodies of tetrahedra, once it is warm: this
// executable counts its calls of malloc, which operator new and Eigen use, where the C library
// permits it.
#include <atomic>
#include <cstddef>

#include "tests/mixed/mixed_bodies.h"

#if defined(__GLIBC__) && !defined(TREMOLO_SANITIZED)
namespace {
std::atomic<long> mixed_mallocs = 0;
}
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void* malloc(std::size_t size) {
  ++mixed_mallocs;
  return __libc_malloc(size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++mixed_mallocs;
  return __libc_memalign(alignment, size);
}
}

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::MixedKind;
using testing::MixedWorld;

// Two cubes of tetrahedra on each other, on the floor.
// The lower one has a load in time, the upper one a force for some steps.
TEST(MixedAllocation, AStackAtRestAllocatesNothing) {
  const MixedKind kind{.step = 2e-3,
                       .restitution = 0.0,
                       .friction = 0.5,
                       .gravity = {0, 0, -9.81},
                       .method = TetMethod::kImplicitEuler,
                       .beta = 5e-3};
  MixedWorld world(kind.step);
  const TetModelPointer model = testing::tets_cube(5e4, 1);
  const TetHullPointer hull = testing::cube_hull(model);
  for (const double z : {0.0503, 0.1506})
    ASSERT_TRUE(world.add(
        "upper", testing::tets_body(model, kind, {0, 0, z}, Vector3d::Zero(), Vector3d::Zero()),
        testing::contact_of(kind, Vector3d::Ones()), hull));
  PlacedCollider floor;
  floor.shape = PlaneShape{};
  world.set_colliders({&floor, 1});
  MixedGuests& guests = world.guests();
  ASSERT_TRUE(guests.add_load({.guest = 0,
                               .pushes = {{0, {0, 0, -0.5}}, {1, {0, 0, -0.5}}},
                               .signal = {.kind = SignalKind::kSine, .frequency = 5.0}}));
  ASSERT_TRUE(guests.apply_force(1, 3, {0, 0, -1.0}, 110));
  for (int k = 0; k < 100; ++k) ASSERT_TRUE(world.step());
  EXPECT_EQ(world.in_islands(), 2U);
  const long before = mixed_mallocs;
  bool good = true;
  for (int k = 0; k < 20; ++k) good = good && static_cast<bool>(world.step());
  const long after = mixed_mallocs;
  EXPECT_TRUE(good);
  EXPECT_EQ(after - before, 0);
  EXPECT_NE(guests.load_work(0), 0.0);
  EXPECT_FALSE(guests.has_load(1)) << "its 110 steps are over";
}

}  // namespace
}  // namespace tremolo
#endif
