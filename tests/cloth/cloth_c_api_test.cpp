// Cloth from C: the same bits as from C++, and what is wrong is said.
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/bodies/cloth/cloth_world.h"
#include "runtime/tremolo_cloth.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

class CApiCloth : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(tremolo_cloth_scene_create("midpoint", 0.01, &scene_), TREMOLO_OK);
    tremolo_cloth_options options;
    tremolo_cloth_options_init(&options);
    options.columns = 9;
    options.rows = 7;
    options.width = 0.8;
    options.height = 0.6;
    options.corner[2] = 1.0;
    options.stiffness[0] = 200.0;
    ASSERT_EQ(tremolo_cloth_scene_add(scene_, &options, &cloth_), TREMOLO_OK);
    ASSERT_EQ(tremolo_cloth_scene_pin(scene_, cloth_, corners_, 2), TREMOLO_OK);
    const double at[] = {0.4, 0.3, 0.7}, still[] = {0.0, 0.0, 0.0};
    ASSERT_EQ(tremolo_cloth_scene_add_ball(scene_, 0.15, 0.0, at, still), TREMOLO_OK);
    const double wind[] = {1.0, 0.5, 0.0};
    ASSERT_EQ(tremolo_cloth_scene_set_wind(scene_, wind), TREMOLO_OK);
    ASSERT_EQ(tremolo_collider_plane(&plane_), TREMOLO_OK);
    tremolo_placed_collider floor;
    tremolo_placed_collider_init(&floor, plane_);
    floor.position[2] = 0.5;
    ASSERT_EQ(tremolo_cloth_scene_add_collider(scene_, &floor), TREMOLO_OK);
  }
  void TearDown() override {
    tremolo_cloth_destroy(world_);
    tremolo_cloth_scene_destroy(scene_);
    tremolo_collider_destroy(plane_);
  }
  // The scene of SetUp().
  static ClothScene same_scene() {
    ClothScene scene;
    scene.integrator = "midpoint";
    scene.options.step = 0.01;
    scene.gravity.times = {0.0};
    scene.gravity.values = {Vector3d(0.0, 0.0, -9.81)};
    scene.wind = {1.0, 0.5, 0.0};
    SceneCloth cloth;
    cloth.grid = {9, 7, 0.8, 0.6, Vector3d(0.0, 0.0, 1.0), Vector3d::UnitX(), Vector3d::UnitY()};
    cloth.structural.stiffness = 200.0;
    cloth.pins.push_back({.particles = {0, 8}, .motion = {}});
    scene.cloths.push_back(cloth);
    SceneBall ball;
    ball.name = "ball";
    ball.radius = 0.15;
    ball.fixed = true;
    ball.position = {0.4, 0.3, 0.7};
    scene.balls.push_back(ball);
    SceneCollider floor;
    floor.name = "floor";
    floor.shape = PlaneShape{};
    floor.pose.position.z() = 0.5;
    scene.colliders.push_back(floor);
    return scene;
  }

  static constexpr size_t corners_[] = {0, 8};
  tremolo_cloth_scene* scene_ = nullptr;
  tremolo_cloth_world* world_ = nullptr;
  tremolo_collider* plane_ = nullptr;
  size_t cloth_ = 99;
};

TEST_F(CApiCloth, FallsOnABallInTheWindAsInCpp) {
  ASSERT_EQ(tremolo_cloth_create(scene_, &world_), TREMOLO_OK) << tremolo_last_error();
  Result<ClothWorld> other = ClothWorld::create(same_scene());
  ASSERT_TRUE(other) << other.error().message;
  ASSERT_EQ(tremolo_cloth_particles(world_, cloth_), 63u);
  ASSERT_EQ(tremolo_cloth_triangles(world_, cloth_), other->triangles(0).size());
  const double up[] = {0.8, 0.6, 1.2};
  for (int step = 0; step < 120; ++step) {
    if (step == 60) {
      ASSERT_EQ(tremolo_cloth_hold(world_, cloth_, 62, up), TREMOLO_OK);
      ASSERT_TRUE(other->hold(0, 62, Vector3d(up)));
    }
    if (step == 100) {
      ASSERT_EQ(tremolo_cloth_let_go(world_, cloth_, 62), TREMOLO_OK);
      ASSERT_TRUE(other->let_go(0, 62));
    }
    ASSERT_EQ(tremolo_cloth_step(world_), TREMOLO_OK) << tremolo_last_error();
    ASSERT_TRUE(other->step());
  }
  Eigen::VectorXd x(189), v(189);
  ASSERT_EQ(tremolo_cloth_positions(world_, cloth_, x.data(), 189), TREMOLO_OK);
  ASSERT_EQ(tremolo_cloth_velocities(world_, cloth_, v.data(), 189), TREMOLO_OK);
  EXPECT_EQ(x, other->positions(0));
  EXPECT_EQ(v, other->velocities(0));
  EXPECT_DOUBLE_EQ(tremolo_cloth_time(world_), 1.2);
  double kinetic = 0.0, elastic = 0.0, gravity = 0.0, place[3], turn[4];
  ASSERT_EQ(tremolo_cloth_energy(world_, &kinetic, &elastic, &gravity), TREMOLO_OK);
  EXPECT_EQ(kinetic, other->energy().kinetic);
  EXPECT_EQ(elastic, other->energy().elastic);
  ASSERT_EQ(tremolo_cloth_ball(world_, 0, place, turn), TREMOLO_OK);
  EXPECT_EQ(place[2], 0.7);
  std::vector<uint32_t> corners(3 * other->triangles(0).size());
  ASSERT_EQ(tremolo_cloth_triangle_corners(world_, cloth_, corners.data(), corners.size()),
            TREMOLO_OK);
  for (const uint32_t corner : corners) EXPECT_LT(corner, 63u);
  ASSERT_EQ(tremolo_cloth_set_state(world_, cloth_, x.data(), v.data(), 189), TREMOLO_OK);
}

TEST_F(CApiCloth, WhatIsWrongIsSaid) {
  EXPECT_EQ(tremolo_cloth_scene_create("midpoint", 0.01, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_cloth_scene_pin(scene_, 7, corners_, 2), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_cloth_step(nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_cloth_particles(nullptr, 0), 0u);
  ASSERT_EQ(tremolo_cloth_create(scene_, &world_), TREMOLO_OK);
  double x[3];
  EXPECT_EQ(tremolo_cloth_positions(world_, cloth_, x, 3), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_cloth_positions(world_, 5, x, 3), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_cloth_ball(world_, 3, x, nullptr), TREMOLO_USAGE);
  EXPECT_NE(tremolo_cloth_hold(world_, cloth_, 1000, x), TREMOLO_OK);
  // Errors that the scene's check finds.
  const double at[] = {0.4, 0.3, 0.7};
  ASSERT_EQ(tremolo_cloth_scene_add_ball(scene_, -1.0, 1.0, at, at), TREMOLO_OK);
  tremolo_cloth_world* none = nullptr;
  EXPECT_EQ(tremolo_cloth_create(scene_, &none), TREMOLO_CONTENT);
  EXPECT_EQ(none, nullptr);
  // An explicit method beyond its limit.
  tremolo_cloth_scene* fast = nullptr;
  ASSERT_EQ(tremolo_cloth_scene_create("rk4", 0.1, &fast), TREMOLO_OK);
  ASSERT_EQ(tremolo_cloth_scene_add(fast, nullptr, nullptr), TREMOLO_OK);
  EXPECT_EQ(tremolo_cloth_create(fast, &none), TREMOLO_USAGE);
  EXPECT_NE(std::string(tremolo_last_error()).find("limit"), std::string::npos);
  tremolo_cloth_scene_destroy(fast);
}

}  // namespace
}  // namespace tremolo
