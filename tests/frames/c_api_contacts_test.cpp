// Bodies in contact and in joints, from C: the same bits as from C++.
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/contact/islands/body_group.h"
#include "runtime/tremolo.h"
#include "tests/support/c_models.h"
#include "tests/support/frames/frame_models.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kBodies = 3;
constexpr double kBallRadius = 0.5;
const Vector3d kAt[kBodies] = {{0.0, 0.0, 2.0}, {0.3, 0.2, 4.0}, {3.0, 0.0, 2.5}};

class CApiContacts : public ::testing::Test {
 protected:
  void SetUp() override {
    model_ = testing::load_cloud_model();
    ASSERT_NE(model_, nullptr) << tremolo_last_error();
    ASSERT_EQ(tremolo_collider_plane(&floor_), TREMOLO_OK);
    ASSERT_EQ(tremolo_collider_sphere(kBallRadius, &ball_), TREMOLO_OK);
    ASSERT_EQ(tremolo_contacts_create(1, &contacts_), TREMOLO_OK);
    for (tremolo_body*& body : bodies_) ASSERT_EQ(create(&body), TREMOLO_OK);
  }
  void TearDown() override {
    tremolo_contacts_destroy(contacts_);
    for (tremolo_body* body : bodies_) tremolo_body_destroy(body);
    tremolo_collider_destroy(ball_);
    tremolo_collider_destroy(floor_);
    tremolo_model_release(model_);
  }
  tremolo_status create(tremolo_body** body, double step = 0.0) {
    tremolo_body_options options;
    tremolo_body_options_init(&options);
    options.frame = TREMOLO_FREE;
    if (step > 0.0) options.step = step;
    return tremolo_body_create(model_, &options, body);
  }
  tremolo_contact_options touching() const {
    tremolo_contact_options options;
    tremolo_contact_options_init(&options);
    options.shape = ball_;
    options.friction = 0.2;
    options.restitution = 0.4;
    return options;
  }

  // Body i falls as a ball from its position, and `other` does so in C++.
  void place(std::size_t i, const tremolo_contact_options& options, ContactBody& other) {
    const double gravity[] = {0.0, 0.0, -9.81};
    const double upright[] = {1.0, 0.0, 0.0, 0.0};
    ASSERT_EQ(tremolo_body_set_contact(bodies_[i], &options), TREMOLO_OK) << tremolo_last_error();
    ASSERT_EQ(tremolo_body_set_pose(bodies_[i], kAt[i].data(), upright), TREMOLO_OK);
    ASSERT_EQ(tremolo_body_set_gravity(bodies_[i], gravity), TREMOLO_OK);
    uint32_t number = 99;
    ASSERT_EQ(tremolo_contacts_add(contacts_, bodies_[i], &number), TREMOLO_OK);
    EXPECT_EQ(number, i);
    ASSERT_TRUE(other.set_contact(
        {.shape = SphereShape{kBallRadius}, .friction = 0.2, .restitution = 0.4}));
    ASSERT_TRUE(other.set_pose({kAt[i], Eigen::Quaterniond::Identity()}));
    ASSERT_TRUE(other.set_gravity(Vector3d(gravity)));
  }
  void expect_same_touches(const BodyGroup& group) {
    uint32_t who[6] = {};
    double impulses[3] = {};
    size_t touches = 99;
    ASSERT_EQ(tremolo_contacts_touches(contacts_, who, impulses, 3, &touches), TREMOLO_OK);
    ASSERT_EQ(touches, group.touches().size());
    for (size_t i = 0; i < touches; ++i) {
      EXPECT_EQ(who[2 * i], group.touches()[i].a);
      EXPECT_EQ(who[2 * i + 1], group.touches()[i].b);
      EXPECT_EQ(impulses[i], group.touches()[i].impulse);
    }
  }
  void expect_same_states(const std::vector<ContactBody>& others) {
    for (std::size_t i = 0; i < kBodies; ++i) {
      double q[4], position[3], turn[4];
      ASSERT_EQ(tremolo_body_state(bodies_[i], q, nullptr, 4), TREMOLO_OK);
      ASSERT_EQ(tremolo_body_pose(bodies_[i], position, turn), TREMOLO_OK);
      EXPECT_EQ(std::memcmp(q, others[i].state().q.data(), sizeof(q)), 0);
      EXPECT_EQ(Vector3d(position), others[i].pose().position);
    }
  }

  tremolo_model* model_ = nullptr;
  tremolo_collider *floor_ = nullptr, *ball_ = nullptr;
  tremolo_contacts* contacts_ = nullptr;
  std::array<tremolo_body*, kBodies> bodies_{};
};

TEST_F(CApiContacts, BodiesFallOnAFloorAndOnEachOtherAndHangTogetherAsInCpp) {
  const Model::Pointer model = testing::frame_model(4, true, 60.0, 300.0, 0.2, 3);
  std::vector<ContactBody> others;
  std::vector<ContactBody*> stepped;
  for (std::size_t i = 0; i < kBodies; ++i)
    others.push_back(testing::make_framed(model, FrameKind::kFree, {}));
  const tremolo_contact_options options = touching();
  for (std::size_t i = 0; i < kBodies; ++i) {
    place(i, options, others[i]);
    stepped.push_back(&others[i]);
  }
  tremolo_joint_options wanted;
  tremolo_joint_options_init(&wanted);
  wanted.vertex = 2;
  wanted.to_vertex = 1;
  wanted.stiffness = 40.0;
  wanted.damping = 0.5;
  wanted.length = 1.0;
  wanted.touch = 1;
  uint64_t joint = 99;
  ASSERT_EQ(tremolo_contacts_join(contacts_, 2, 0, &wanted, &joint), TREMOLO_OK)
      << tremolo_last_error();
  BodyGroup group;
  const std::size_t own =
      group.join(2, 0,
                 *make_joint(others[2], 2, others[0], 1,
                             {.stiffness = 40.0, .damping = 0.5, .length = 1.0, .touch = true}));

  // Its own group is stepped by one thread.
  ASSERT_EQ(tremolo_contacts_set_threads(contacts_, 2), TREMOLO_OK) << tremolo_last_error();

  tremolo_placed_collider placed;
  tremolo_placed_collider_init(&placed, floor_);
  const PlacedCollider floor[] = {{.shape = PlaneShape{}, .start = {}, .end = {}}};
  std::vector<StepReport> reports(kBodies);
  std::size_t most_touches = 0;
  for (int step = 0; step < 400; ++step) {
    size_t failed = 99;
    ASSERT_EQ(tremolo_contacts_step(contacts_, &placed, 1, nullptr, 0, &failed), TREMOLO_OK)
        << tremolo_last_error();
    EXPECT_EQ(failed, 0u);
    group.step(stepped, floor, reports);
    expect_same_touches(group);
    most_touches = std::max(most_touches, group.touches().size());
  }
  EXPECT_GT(most_touches, 0u);
  expect_same_states(others);
  double force[3] = {}, energy = -1.0, damped = -1.0;
  ASSERT_EQ(tremolo_contacts_joint(contacts_, joint, force, &energy, &damped), TREMOLO_OK);
  EXPECT_EQ(Vector3d(force), group.joint(own)->force);
  EXPECT_EQ(energy, group.joint(own)->energy);
  EXPECT_GT(damped, 0.0);
  EXPECT_EQ(tremolo_contacts_separate(contacts_, joint), TREMOLO_OK);
  EXPECT_EQ(tremolo_contacts_separate(contacts_, joint), TREMOLO_USAGE);
  int32_t asleep = 99;
  EXPECT_EQ(tremolo_contacts_asleep(contacts_, 0, &asleep), TREMOLO_OK);
  EXPECT_EQ(asleep, group.asleep(0) ? 1 : 0);
  EXPECT_EQ(tremolo_contacts_wake(contacts_, 0), TREMOLO_OK);
}

TEST_F(CApiContacts, WhatDoesNotGoTogetherIsRefusedAndNothingChanges) {
  EXPECT_EQ(tremolo_contacts_add(contacts_, bodies_[0], nullptr), TREMOLO_USAGE);
  EXPECT_NE(std::string(tremolo_last_error()).find("tremolo_body_set_contact"), std::string::npos);
  const tremolo_contact_options options = touching();
  ASSERT_EQ(tremolo_body_set_contact(bodies_[0], &options), TREMOLO_OK);
  ASSERT_EQ(tremolo_contacts_add(contacts_, bodies_[0], nullptr), TREMOLO_OK);
  EXPECT_EQ(tremolo_contacts_add(contacts_, bodies_[0], nullptr), TREMOLO_USAGE);
  tremolo_body* fast = nullptr;
  ASSERT_EQ(create(&fast, 1e-3), TREMOLO_OK);
  ASSERT_EQ(tremolo_body_set_contact(fast, nullptr), TREMOLO_OK);
  EXPECT_EQ(tremolo_contacts_add(contacts_, fast, nullptr), TREMOLO_USAGE);
  EXPECT_NE(std::string(tremolo_last_error()).find("share one"), std::string::npos);
  tremolo_body_destroy(fast);
  tremolo_joint_options joint;
  tremolo_joint_options_init(&joint);
  uint64_t number = 0;
  EXPECT_EQ(tremolo_contacts_join(contacts_, 0, 1, &joint, &number), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_contacts_join(contacts_, 0, 0, &joint, &number), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_contacts_join(contacts_, 0, 0, nullptr, &number), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_contacts_asleep(contacts_, 1, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_contacts_wake(contacts_, 7), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_contacts_step(contacts_, nullptr, 1, nullptr, 0, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_contacts_step(nullptr, nullptr, 0, nullptr, 0, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_contacts_create(1, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_contacts_joint(contacts_, 5, nullptr, nullptr, nullptr), TREMOLO_USAGE);
}

}  // namespace
}  // namespace tremolo
