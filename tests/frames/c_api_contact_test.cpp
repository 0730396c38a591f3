// Colliders and hands from C: the same bits as from C++.
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/contact/solve/contact_step.h"
#include "runtime/tremolo.h"
#include "tests/support/c_models.h"
#include "tests/support/frames/frame_models.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

class CApiContact : public ::testing::Test {
 protected:
  void SetUp() override {
    model_ = testing::load_cloud_model();
    ASSERT_NE(model_, nullptr) << tremolo_last_error();
    tremolo_body_options options;
    tremolo_body_options_init(&options);
    options.frame = TREMOLO_FREE;
    ASSERT_EQ(tremolo_body_create(model_, &options, &body_), TREMOLO_OK) << tremolo_last_error();
    ASSERT_EQ(tremolo_collider_plane(&floor_), TREMOLO_OK);
  }

  void TearDown() override {
    tremolo_collider_destroy(floor_);
    tremolo_body_destroy(body_);
    tremolo_model_release(model_);
  }

  // The body's state and its energy balance are those of `other`.
  void expect_same_account(const ContactBody& other) {
    std::vector<double> q(4);
    ASSERT_EQ(tremolo_body_state(body_, q.data(), nullptr, 4), TREMOLO_OK);
    EXPECT_EQ(Eigen::Map<Eigen::VectorXd>(q.data(), 4), other.state().q);
    double stored = -1.0, given = 0.0, restitution = 0.0, friction = 0.0, held = 0.0, error = 1.0;
    ASSERT_EQ(
        tremolo_body_contact_work(body_, &stored, &given, &restitution, &friction, &held, &error),
        TREMOLO_OK);
    EXPECT_EQ(given, other.contact_sums().given);
    EXPECT_EQ(restitution, 0.0 - other.contact_sums().lost);
    EXPECT_EQ(friction, 0.0 - other.contact_sums().friction_loss);
    EXPECT_EQ(held, other.contact_sums().hand);
    EXPECT_EQ(error, other.contact_sums().error);
    // Everything together is where the energy is.
    double kinetic = 0.0, potential = 0.0, load = 1.0, fallen = 0.0, damping = 0.0;
    ASSERT_EQ(tremolo_body_energy(body_, &kinetic, &potential, nullptr), TREMOLO_OK);
    ASSERT_EQ(tremolo_body_work(body_, &load, nullptr, &fallen, &damping), TREMOLO_OK);
    EXPECT_NEAR(load, 0.0, 1e-12 * fallen);
    EXPECT_NEAR(kinetic + potential + stored,
                fallen + damping + given + restitution + friction + held + error,
                1e-8 * std::abs(fallen));
  }

  tremolo_model* model_ = nullptr;
  tremolo_body* body_ = nullptr;
  tremolo_collider* floor_ = nullptr;
};

TEST_F(CApiContact, BodyFallsOnAMovingFloorAndIsHeldAsInCpp) {
  ContactBody other = testing::make_framed(testing::frame_model(4, true, 60.0, 300.0, 0.2, 3),
                                           FrameKind::kFree, {});
  const double gravity[] = {0.0, 0.0, -9.81};
  ASSERT_EQ(tremolo_body_set_contact(body_, nullptr), TREMOLO_OK) << tremolo_last_error();
  ASSERT_EQ(tremolo_body_set_gravity(body_, gravity), TREMOLO_OK);
  ASSERT_TRUE(other.set_contact());
  ASSERT_TRUE(other.set_gravity(Vector3d(gravity)));
  tremolo_placed_collider placed;
  tremolo_placed_collider_init(&placed, floor_);
  EXPECT_EQ(placed.friction, 0.3);
  placed.restitution = 0.4;
  std::vector<PlacedCollider> floor(1);
  floor[0].restitution = 0.4;
  uint64_t hand = 7;
  ASSERT_EQ(tremolo_body_grab(body_, 5, 20.0, 0.5, &hand), TREMOLO_OK) << tremolo_last_error();
  const Result<std::size_t> same = other.grab(5, 20.0, 0.5);
  ASSERT_TRUE(same);
  ASSERT_EQ(hand, *same);
  int32_t most = 0;
  for (int k = 0; k < 400; ++k) {
    placed.position[2] = placed.next_position[2];
    placed.next_position[2] = -0.6 + 0.02 * std::sin(0.03 * (k + 1));
    if (k == 0) placed.position[2] = -0.6;
    floor[0].start.position.z() = placed.position[2];
    floor[0].end.position.z() = placed.next_position[2];
    const double place[] = {0.0, 0.001 * k, 0.1};
    if (k < 200) {
      ASSERT_EQ(tremolo_body_move_hand(body_, hand, place), TREMOLO_OK);
      ASSERT_TRUE(other.move_hand(*same, Vector3d(place)));
    }
    if (k == 200) {
      ASSERT_EQ(tremolo_body_release(body_, hand), TREMOLO_OK);
      ASSERT_TRUE(other.release(*same));
    }
    ASSERT_EQ(tremolo_body_step_among(body_, &placed, 1), TREMOLO_OK) << tremolo_last_error();
    ASSERT_TRUE(other.step(floor).converged);
    Vector3d force;
    ASSERT_EQ(tremolo_body_hand_force(body_, hand, force.data()), TREMOLO_OK);
    ASSERT_EQ(force, other.hand_force(*same));
    double penetration = 0.0, impulse = 0.0, one = 0.0;
    int32_t points = 0;
    ASSERT_EQ(tremolo_body_contact(body_, &penetration, &impulse, &points), TREMOLO_OK);
    ASSERT_EQ(tremolo_body_contact_impulses(body_, &one, 1), TREMOLO_OK);
    ASSERT_EQ(impulse, other.contact_account().impulse);
    ASSERT_EQ(one, impulse);
    most = std::max(most, points);
  }
  EXPECT_GT(most, 0);
  expect_same_account(other);
}

TEST_F(CApiContact, ShapesTellTheirDistances) {
  tremolo_collider* shape = nullptr;
  const double half[] = {1.0, 2.0, 3.0}, place[] = {0.0, 0.0, 4.0};
  double distance = 0.0;
  Vector3d normal;
  ASSERT_EQ(tremolo_collider_box(half, &shape), TREMOLO_OK);
  ASSERT_EQ(tremolo_collider_distance(shape, place, &distance, normal.data()), TREMOLO_OK);
  EXPECT_EQ(distance, 1.0);
  EXPECT_EQ(normal, Vector3d::UnitZ());
  tremolo_collider_destroy(shape);
  ASSERT_EQ(tremolo_collider_sphere(1.5, &shape), TREMOLO_OK);
  ASSERT_EQ(tremolo_collider_distance(shape, place, &distance, nullptr), TREMOLO_OK);
  EXPECT_EQ(distance, 2.5);
  tremolo_collider_destroy(shape);
  ASSERT_EQ(tremolo_collider_capsule(0.5, 2.0, &shape), TREMOLO_OK);
  ASSERT_EQ(tremolo_collider_distance(shape, place, &distance, nullptr), TREMOLO_OK);
  EXPECT_EQ(distance, 1.5);
  tremolo_collider_destroy(shape);
  ASSERT_EQ(tremolo_collider_cylinder(0.5, 2.0, &shape), TREMOLO_OK);
  ASSERT_EQ(tremolo_collider_distance(shape, place, &distance, nullptr), TREMOLO_OK);
  EXPECT_EQ(distance, 2.0);
  tremolo_collider_destroy(shape);
}

TEST_F(CApiContact, WhatIsWrongIsToldAndChangesNothing) {
  tremolo_collider* shape = nullptr;
  EXPECT_EQ(tremolo_collider_sphere(-1.0, &shape), TREMOLO_CONTENT);
  EXPECT_EQ(tremolo_collider_sphere(1.0, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_collider_box(nullptr, &shape), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_collider_load("nowhere.collider", &shape), TREMOLO_SYSTEM);
  EXPECT_EQ(tremolo_collider_load(nullptr, &shape), TREMOLO_USAGE);
  EXPECT_EQ(shape, nullptr);
  uint64_t hand = 0;
  const double place[] = {0.0, 0.0, 0.0}, nowhere[] = {NAN, 0.0, 0.0};
  EXPECT_EQ(tremolo_body_grab(body_, 5, 1.0, 0.0, &hand), TREMOLO_USAGE);
  EXPECT_NE(std::strstr(tremolo_last_error(), "set_contact"), nullptr);
  tremolo_contact_options options;
  tremolo_contact_options_init(&options);
  options.margin = -1.0;
  EXPECT_EQ(tremolo_body_set_contact(body_, &options), TREMOLO_USAGE);
  options.margin = 0.01;
  options.shape = floor_;
  EXPECT_EQ(tremolo_body_set_contact(body_, &options), TREMOLO_CONTENT) << "a plane";
  options.shape = nullptr;
  options.friction = NAN;
  EXPECT_EQ(tremolo_body_set_contact(body_, &options), TREMOLO_USAGE);
  options.friction = 0.3;
  options.restitution = NAN;
  EXPECT_EQ(tremolo_body_set_contact(body_, &options), TREMOLO_USAGE);
  options.restitution = 0.5;
  EXPECT_EQ(tremolo_body_set_contact(body_, &options), TREMOLO_OK);
  EXPECT_EQ(tremolo_body_grab(body_, 5, -1.0, 0.0, &hand), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_grab(body_, 5, 1.0, 0.0, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_grab(body_, 5, 1.0, 0.0, &hand), TREMOLO_OK);
  double stiffness = 0.0, damping = 7.0;
  EXPECT_EQ(tremolo_body_hand_spring(body_, hand, &stiffness, &damping), TREMOLO_OK);
  EXPECT_EQ(stiffness, 1.0);
  EXPECT_EQ(damping, 0.0);
  uint64_t stiff = 0;
  EXPECT_EQ(tremolo_body_grab(body_, 5, 1e15, 0.0, &stiff), TREMOLO_OK);
  EXPECT_EQ(tremolo_body_hand_spring(body_, stiff, &stiffness, nullptr), TREMOLO_OK);
  EXPECT_LT(stiffness, 1e15) << "limited to that of a pin";
  EXPECT_EQ(tremolo_body_release(body_, stiff), TREMOLO_OK);
  EXPECT_EQ(tremolo_body_hand_spring(body_, stiff, &stiffness, &damping), TREMOLO_OK);
  EXPECT_EQ(stiffness, 0.0);
  EXPECT_EQ(tremolo_body_move_hand(body_, hand, nowhere), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_move_hand(body_, hand + 1, place), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_release(body_, hand + 1), TREMOLO_USAGE);
  tremolo_placed_collider placed;
  tremolo_placed_collider_init(&placed, nullptr);
  EXPECT_EQ(tremolo_body_step_among(body_, &placed, 1), TREMOLO_USAGE);
  placed.collider = floor_;
  placed.next_quaternion[1] = 1.0;
  EXPECT_EQ(tremolo_body_step_among(body_, &placed, 1), TREMOLO_USAGE);
  EXPECT_NE(std::strstr(tremolo_last_error(), "quaternion is of length 1.41421"), nullptr);
  tremolo_placed_collider_init(&placed, floor_);
  placed.friction = NAN;
  EXPECT_EQ(tremolo_body_step_among(body_, &placed, 1), TREMOLO_USAGE);
  tremolo_placed_collider_init(&placed, floor_);
  placed.restitution = 1.5;
  EXPECT_EQ(tremolo_body_step_among(body_, &placed, 1), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_step_among(body_, nullptr, 1), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_time(body_), 0.0);
  EXPECT_EQ(tremolo_body_step_among(body_, nullptr, 0), TREMOLO_OK);
  EXPECT_EQ(tremolo_body_contact_impulses(body_, nullptr, 1), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_contact(body_, nullptr, nullptr, nullptr), TREMOLO_OK);
  EXPECT_EQ(
      tremolo_body_contact_work(nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr),
      TREMOLO_USAGE);
}

}  // namespace
}  // namespace tremolo
