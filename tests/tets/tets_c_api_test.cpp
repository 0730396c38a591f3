// Bodies of tetrahedra from C: the same bits as from C++, and what is wrong is said.
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/bodies/tets/scene/tet_scene.h"
#include "runtime/tremolo_tets.h"
#include "tests/support/meshes/small_tets.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

class CApiTets : public ::testing::Test {
 protected:
  // Two free bars, one of them rotated and spinning, above a plane with friction.
  void SetUp() override {
    TetsData data = testing::small_tets();
    data.held.clear();
    file_ = folder_.file("bar.tets");
    ASSERT_TRUE(write_tets(file_, data));
    ASSERT_EQ(tremolo_tets_scene_create(0.01, &scene_), TREMOLO_OK);
    tremolo_tets_options_init(&options_);
    options_.file = file_.c_str();
    options_.beta = 0.002;
    options_.position[2] = 0.01;
    size_t body = 9;
    ASSERT_EQ(tremolo_tets_scene_add(scene_, &options_, &body), TREMOLO_OK);
    EXPECT_EQ(body, 0U);
    options_.degree = TREMOLO_TETS_LINEAR;
    options_.method = "implicit-euler";
    options_.position[2] = 0.25;
    options_.quaternion[0] = 0.8;
    options_.quaternion[1] = 0.6;
    options_.spin[1] = 2.0;
    ASSERT_EQ(tremolo_tets_scene_add(scene_, &options_, &body), TREMOLO_OK);
    EXPECT_EQ(body, 1U);
    ASSERT_EQ(tremolo_collider_plane(&plane_), TREMOLO_OK);
    tremolo_placed_collider floor;
    tremolo_placed_collider_init(&floor, plane_);
    floor.position[2] = -0.02;
    ASSERT_EQ(tremolo_tets_scene_add_collider(scene_, &floor), TREMOLO_OK);
  }
  void TearDown() override {
    tremolo_tets_destroy(world_);
    tremolo_tets_scene_destroy(scene_);
    tremolo_collider_destroy(plane_);
  }
  // The scene of SetUp().
  TetBodiesScene same_scene() const {
    TetBodiesScene scene;
    TetSceneBody body;
    body.name = "low";
    body.model = file_;
    body.pose.position.z() = 0.01;
    body.options.step = 0.01;
    body.options.gravity = {0.0, 0.0, -9.81};
    body.options.beta = 0.002;
    body.options.unsolved = UnsolvedStep::kTakeContact;  // as tremolo_tets_options_init
    body.options.degree.kind = DegreeKind::kAdaptive;
    scene.bodies.push_back(body);
    body.name = "high";
    body.pose = {{0.0, 0.0, 0.25}, Eigen::Quaterniond(0.8, 0.6, 0.0, 0.0)};
    body.spin.y() = 2.0;
    body.options.degree.kind = DegreeKind::kLinear;
    body.options.method = TetMethod::kImplicitEuler;
    scene.bodies.push_back(body);
    SceneCollider floor;
    floor.name = "floor";
    floor.shape = PlaneShape{};
    floor.pose.position.z() = -0.02;
    scene.colliders.push_back(floor);
    return scene;
  }

  testing::TemporaryFolder folder_;
  std::string file_;
  tremolo_tets_options options_{};
  tremolo_tets_scene* scene_ = nullptr;
  tremolo_tets_world* world_ = nullptr;
  tremolo_collider* plane_ = nullptr;
};

TEST_F(CApiTets, BodiesFallOnAPlaneAsInCpp) {
  ASSERT_EQ(tremolo_tets_create(scene_, &world_), TREMOLO_OK) << tremolo_last_error();
  Result<TetsBodies> other = make_tets_bodies(same_scene());
  ASSERT_TRUE(other) << other.error().message;
  ASSERT_EQ(tremolo_tets_bodies(world_), 2U);
  std::vector<TetStepReport> reports(2);
  bool touched = false;
  for (int step = 0; step < 40; ++step) {
    ASSERT_EQ(tremolo_tets_step(world_), TREMOLO_OK) << tremolo_last_error();
    ASSERT_TRUE(other->group->step(reports));
    touched = touched || other->group->contact(0).look().touching > 0;
  }
  EXPECT_TRUE(touched);
  EXPECT_NEAR(tremolo_tets_time(world_), 0.4, 1e-12);
  for (size_t i = 0; i < 2; ++i) {
    const TetBody& body = other->group->body(i);
    const Eigen::Index size = body.positions().size();
    ASSERT_EQ(3 * tremolo_tets_points(world_, i), static_cast<size_t>(size));
    Eigen::VectorXd x(size), v(size);
    ASSERT_EQ(tremolo_tets_positions(world_, i, x.data(), static_cast<size_t>(size)), TREMOLO_OK);
    ASSERT_EQ(tremolo_tets_velocities(world_, i, v.data(), static_cast<size_t>(size)), TREMOLO_OK);
    EXPECT_EQ(x, body.positions());
    EXPECT_EQ(v, body.velocities());
    int32_t asleep = 7;
    double share = -1.0;
    ASSERT_EQ(tremolo_tets_look(world_, i, &asleep, &share), TREMOLO_OK);
    EXPECT_EQ(asleep, other->group->asleep(i) ? 1 : 0);
    EXPECT_EQ(share, body.system().quadratic_share());
  }
  double kinetic = 0.0, elastic = 0.0, gravity = 0.0;
  ASSERT_EQ(tremolo_tets_energy(world_, &kinetic, &elastic, &gravity, nullptr), TREMOLO_OK);
  EXPECT_EQ(kinetic,
            other->group->body(0).kinetic_energy() + other->group->body(1).kinetic_energy());
  EXPECT_EQ(gravity,
            other->group->body(0).gravity_energy() + other->group->body(1).gravity_energy());
}

TEST_F(CApiTets, AStateThatIsSetIsTheStateThatIsThere) {
  ASSERT_EQ(tremolo_tets_create(scene_, &world_), TREMOLO_OK) << tremolo_last_error();
  const size_t length = 3 * tremolo_tets_points(world_, 0);
  std::vector<double> x(length), v(length, 0.25), there(length);
  ASSERT_EQ(tremolo_tets_positions(world_, 0, x.data(), length), TREMOLO_OK);
  for (size_t k = 2; k < length; k += 3) x[k] += 1.0;
  ASSERT_EQ(tremolo_tets_set_state(world_, 0, x.data(), v.data(), length), TREMOLO_OK);
  ASSERT_EQ(tremolo_tets_positions(world_, 0, there.data(), length), TREMOLO_OK);
  for (size_t k = 0; k < length; ++k) EXPECT_NEAR(there[k], x[k], 1e-15);
  ASSERT_EQ(tremolo_tets_velocities(world_, 0, there.data(), length), TREMOLO_OK);
  for (size_t k = 0; k < length; ++k) EXPECT_NEAR(there[k], 0.25, 1e-15);
}

TEST_F(CApiTets, TheDrawnSurfaceIsThatOfCpp) {
  ASSERT_EQ(tremolo_tets_create(scene_, &world_), TREMOLO_OK) << tremolo_last_error();
  ASSERT_EQ(tremolo_tets_step(world_), TREMOLO_OK);
  Result<TetsBodies> other = make_tets_bodies(same_scene());
  ASSERT_TRUE(other);
  std::vector<TetStepReport> reports(2);
  ASSERT_TRUE(other->group->step(reports));
  const TetSurface& surface = *other->kind(1).surface;
  const size_t vertices = tremolo_tets_vertices(world_, 1);
  ASSERT_EQ(vertices, surface.vertices());
  std::vector<Eigen::Vector3d> x(vertices);
  std::vector<Eigen::Vector3f> n(vertices);
  surface.place(other->group->body(1).positions(), x, n);
  std::vector<float> positions(3 * vertices), normals(3 * vertices);
  ASSERT_EQ(tremolo_tets_surface(world_, 1, positions.data(), normals.data(), 3 * vertices),
            TREMOLO_OK);
  ASSERT_EQ(tremolo_tets_surface(world_, 1, nullptr, normals.data(), 3 * vertices), TREMOLO_OK);
  for (size_t i = 0; i < vertices; ++i)
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const size_t at = 3 * i + static_cast<size_t>(axis);
      EXPECT_EQ(positions[at], static_cast<float>(x[i][axis]));
      EXPECT_EQ(normals[at], n[i][axis]);
    }
  std::vector<uint32_t> corners(3 * tremolo_tets_triangles(world_, 1));
  ASSERT_EQ(tremolo_tets_triangle_corners(world_, 1, corners.data(), corners.size()), TREMOLO_OK);
  EXPECT_EQ(corners, (std::vector<uint32_t>{0, 1, 2, 1, 3, 2}));
}

TEST_F(CApiTets, AHandPullsAsInCpp) {
  ASSERT_EQ(tremolo_tets_create(scene_, &world_), TREMOLO_OK) << tremolo_last_error();
  Result<TetsBodies> other = make_tets_bodies(same_scene());
  ASSERT_TRUE(other);
  std::vector<TetStepReport> reports(2);
  TetBody& body = other->group->body(1);
  TetHand hand = hand_at(body.model(), other->kind(1).surface->rest(), 2);
  ASSERT_TRUE(suit_springs(body, hand));
  double stiffness = 0.0, damping = 0.0;
  ASSERT_EQ(tremolo_tets_suitable(world_, 1, 2, &stiffness, &damping), TREMOLO_OK);
  EXPECT_EQ(stiffness, hand.stiffness);
  EXPECT_EQ(damping, hand.damping);
  // A free body: m (2 pi 2)^2, half the critical damping.
  EXPECT_NEAR(stiffness, body.model().mass() * 157.91367, 1e-4);
  EXPECT_NEAR(damping, body.model().mass() * 12.56637, 1e-5);
  const double velocity[3] = {0.1, 0.0, 0.4};
  double point[3] = {0.1, 0.0, 0.3};
  for (int step = 0; step < 20; ++step) {
    if (step < 15) {
      for (int k = 0; k < 3; ++k) point[k] += 0.01 * velocity[k];
      ASSERT_EQ(tremolo_tets_pull(world_, 1, 2, stiffness, damping, point, velocity), TREMOLO_OK);
      hand.point = Eigen::Vector3d(point);
      hand.velocity = Eigen::Vector3d(velocity);
      ASSERT_TRUE(other->group->set_hand(1, hand));
    } else {
      ASSERT_EQ(tremolo_tets_let_go(world_, 1), TREMOLO_OK);
      ASSERT_TRUE(other->group->set_hand(1, std::nullopt));
    }
    ASSERT_EQ(tremolo_tets_step(world_), TREMOLO_OK) << tremolo_last_error();
    ASSERT_TRUE(other->group->step(reports));
    Eigen::VectorXd x(body.positions().size());
    ASSERT_EQ(tremolo_tets_positions(world_, 1, x.data(), static_cast<size_t>(x.size())),
              TREMOLO_OK);
    EXPECT_EQ(x, body.positions()) << step;
  }
  // Without the hand it would have fallen for 0.2 s.
  EXPECT_GT(body.momentum().z(), -0.6 * 9.81 * 0.2 * body.model().mass());
  EXPECT_EQ(tremolo_tets_pull(world_, 1, 4, 1.0, 0.0, point, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_tets_pull(world_, 2, 0, 1.0, 0.0, point, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_tets_pull(world_, 1, 0, -1.0, 0.0, point, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_tets_pull(world_, 1, 0, 1.0, 0.0, nullptr, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_tets_suitable(world_, 1, 4, &stiffness, &damping), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_tets_let_go(world_, 2), TREMOLO_USAGE);
}

TEST_F(CApiTets, WhatIsWrongIsSaid) {
  EXPECT_EQ(tremolo_tets_scene_create(0.01, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_tets_step(nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_tets_bodies(nullptr), 0U);
  EXPECT_EQ(tremolo_tets_time(nullptr), 0.0);
  EXPECT_EQ(tremolo_tets_scene_set_threads(scene_, 0), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_tets_scene_set_sleep(scene_, -1.0, 0.5), TREMOLO_CONTENT);
  const auto refused = [this](const auto& change, const char* words) {
    tremolo_tets_options options = options_;
    change(options);
    EXPECT_EQ(tremolo_tets_scene_add(scene_, &options, nullptr), TREMOLO_USAGE) << words;
    EXPECT_NE(std::string(tremolo_last_error()).find(words), std::string::npos)
        << tremolo_last_error();
  };
  refused([](auto& o) { o.size = 2; }, "tremolo_tets_options_init");
  refused([](auto& o) { o.file = nullptr; }, "file");
  refused([](auto& o) { o.degree = 4; }, "degree 4");
  refused([](auto& o) { o.method = "leapfrog"; }, "leapfrog");
  refused([](auto& o) { o.quaternion[2] = 0.5; }, "quaternion");
  refused([](auto& o) { o.velocity[1] = 1.0 / 0.0; }, "finite");
  refused([](auto& o) { o.friction = -1.0; }, "friction");
  ASSERT_EQ(tremolo_tets_create(scene_, &world_), TREMOLO_OK);
  double x[3];
  EXPECT_EQ(tremolo_tets_positions(world_, 0, x, 3), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_tets_positions(world_, 2, x, 3), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_tets_set_state(world_, 0, x, nullptr, 3), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_tets_points(world_, 2), 0U);
  // Errors that are found when the world is made.
  options_.file = "gone.tets";
  ASSERT_EQ(tremolo_tets_scene_add(scene_, &options_, nullptr), TREMOLO_OK);
  tremolo_tets_world* none = nullptr;
  EXPECT_EQ(tremolo_tets_create(scene_, &none), TREMOLO_SYSTEM);
  EXPECT_NE(std::string(tremolo_last_error()).find("gone.tets"), std::string::npos);
  EXPECT_EQ(none, nullptr);
  tremolo_tets_scene* fast = nullptr;
  ASSERT_EQ(tremolo_tets_scene_create(-1.0, &fast), TREMOLO_OK);
  options_.file = file_.c_str();
  ASSERT_EQ(tremolo_tets_scene_add(fast, &options_, nullptr), TREMOLO_OK);
  EXPECT_EQ(tremolo_tets_create(fast, &none), TREMOLO_CONTENT);
  tremolo_tets_scene_destroy(fast);
}

}  // namespace
}  // namespace tremolo
