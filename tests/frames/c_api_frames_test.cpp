// Bodies whose frame moves, from C: the same bits as from C++.
#include <cmath>
#include <cstddef>
#include <cstring>
#include <vector>

#include <gtest/gtest.h>

#include "formats/basis/basis_writer.h"
#include "runtime/tremolo.h"
#include "tests/support/frames/frame_models.h"
#include "tests/support/frames/rigged_model.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

constexpr double kHere[] = {0.0, 0.0, 0.0}, kUpright[] = {1.0, 0.0, 0.0, 0.0};

class CApiFrames : public ::testing::Test {
 protected:
  void TearDown() override {
    tremolo_body_destroy(body_);
    tremolo_model_release(model_);
  }

  void make(int32_t frame) {
    const bool free = frame == TREMOLO_FREE;
    const testing::StrainModel strain =
        testing::random_strain_model(testing::spread_omega(4, 14.0, 120.0), 0.2, 3);
    const auto bytes =
        encode_basis(testing::basis_of(testing::random_cloud(4, free, 3), strain, free));
    ASSERT_TRUE(bytes);
    ASSERT_EQ(tremolo_model_load_memory(bytes->data(), bytes->size(), 0, &model_), TREMOLO_OK)
        << tremolo_last_error();
    tremolo_body_options options;
    tremolo_body_options_init(&options);
    EXPECT_EQ(options.frame, TREMOLO_FIXED);
    options.frame = frame;
    ASSERT_EQ(tremolo_body_create(model_, &options, &body_), TREMOLO_OK) << tremolo_last_error();
  }

  // The same body in C++.
  static ContactBody same(FrameKind kind) {
    return testing::make_framed(
        testing::frame_model(4, kind == FrameKind::kFree, 14.0, 120.0, 0.2, 3), kind, {});
  }

  void expect_state(const ContactBody& body) {
    std::vector<double> q(4), p(4);
    ASSERT_EQ(tremolo_body_state(body_, q.data(), p.data(), 4), TREMOLO_OK);
    EXPECT_EQ(Eigen::Map<Eigen::VectorXd>(q.data(), 4), body.state().q);
    EXPECT_EQ(Eigen::Map<Eigen::VectorXd>(p.data(), 4), body.state().p);
  }

  tremolo_model* model_ = nullptr;
  tremolo_body* body_ = nullptr;
};

TEST_F(CApiFrames, FreeBodyTumblesAsInCpp) {
  make(TREMOLO_FREE);
  ContactBody other = same(FrameKind::kFree);
  const double place[] = {1.0, 2.0, 3.0}, velocity[] = {0.5, 0.0, 1.0}, spin[] = {1.0, -4.0, 7.0},
               gravity[] = {0.0, 0.0, -9.81}, force[] = {1.0, 2.0, 0.5};
  ASSERT_EQ(tremolo_body_set_pose(body_, place, kUpright), TREMOLO_OK) << tremolo_last_error();
  ASSERT_EQ(tremolo_body_set_motion(body_, velocity, spin), TREMOLO_OK);
  ASSERT_EQ(tremolo_body_set_gravity(body_, gravity), TREMOLO_OK);
  ASSERT_EQ(tremolo_body_apply_force(body_, 5, force, 10), TREMOLO_OK);
  ASSERT_TRUE(other.set_pose({Vector3d(place), Eigen::Quaterniond::Identity()}));
  ASSERT_TRUE(other.set_motion(Vector3d(velocity), Vector3d(spin)));
  ASSERT_TRUE(other.set_gravity(Vector3d(gravity)));
  ASSERT_TRUE(other.apply_force(5, Vector3d(force), 10));
  ASSERT_EQ(tremolo_body_step(body_, 100, nullptr), TREMOLO_OK);
  testing::steps_of(other, 100);
  expect_state(other);
  Vector3d position, linear, angular, moving, turning;
  double quaternion[4];
  ASSERT_EQ(tremolo_body_pose(body_, position.data(), quaternion), TREMOLO_OK);
  ASSERT_EQ(tremolo_body_momentum(body_, linear.data(), angular.data()), TREMOLO_OK);
  ASSERT_EQ(tremolo_body_motion(body_, moving.data(), turning.data()), TREMOLO_OK);
  EXPECT_EQ(position, other.pose().position);
  EXPECT_EQ(quaternion[0], other.pose().rotation.w());
  EXPECT_EQ(quaternion[3], other.pose().rotation.z());
  EXPECT_EQ(linear, other.momentum().linear);
  EXPECT_EQ(angular, other.momentum().angular);
  EXPECT_EQ(moving, other.rigid_state().velocity);
  EXPECT_EQ(turning, other.rigid_state().spin);
  double load = 0.0, support = 1.0, fallen = 0.0, damping = 1.0;
  ASSERT_EQ(tremolo_body_work(body_, &load, &support, &fallen, &damping), TREMOLO_OK);
  EXPECT_NE(load, 0.0);
  EXPECT_EQ(support, 0.0);
  EXPECT_EQ(fallen, other.sums().gravity);
  EXPECT_EQ(damping, 0.0);
}

TEST_F(CApiFrames, DrivenBodyFollowsPosesAsInCpp) {
  make(TREMOLO_DRIVEN);
  ContactBody other = same(FrameKind::kDriven);
  for (int k = 1; k <= 100; ++k) {
    const double place[] = {0.01 * std::sin(0.05 * k), 0.0, 0.02};
    const double half = 0.01 * k, turn[] = {std::cos(half), 0.0, std::sin(half), 0.0};
    const tremolo_frame_motion motion = {{1.0, 0.0, 0.0}, {0.0, 6.0, 0.0}, {0.0, 0.1, 0.0}};
    const bool known = k % 2 == 0;
    ASSERT_EQ(tremolo_body_move_to(body_, place, turn, known ? &motion : nullptr), TREMOLO_OK);
    const Pose pose{Vector3d(place), Eigen::Quaterniond(turn[0], turn[1], turn[2], turn[3])};
    const FrameMotion same = {{1.0, 0.0, 0.0}, {0.0, 6.0, 0.0}, {0.0, 0.1, 0.0}};
    ASSERT_TRUE(known ? other.move_to(pose, same) : other.move_to(pose));
    ASSERT_EQ(tremolo_body_step(body_, 1, nullptr), TREMOLO_OK);
    ASSERT_TRUE(other.step().converged);
  }
  expect_state(other);
}

TEST_F(CApiFrames, BonesCarryABodyAsInCpp) {
  const testing::RiggedBar bar = testing::rigged_bar(4);
  const std::string path = testing::fresh_folder() + "/bar.tremolo";
  ASSERT_TRUE(write_basis(path, bar.data));
  tremolo_model* model = nullptr;
  ASSERT_EQ(tremolo_model_load(path.c_str(), 0, &model), TREMOLO_OK) << tremolo_last_error();
  const std::vector<BoneSegment> bones = testing::bar_bones();
  std::vector<double> segments;
  for (const BoneSegment& bone : bones)
    for (const Vector3d& end : {bone.head, bone.tail})
      segments.insert(segments.end(), end.begin(), end.end());
  tremolo_body* body = nullptr;
  ASSERT_EQ(tremolo_body_create_on_bones(model, nullptr, 3, segments.data(), 0.08, &body),
            TREMOLO_OK)
      << tremolo_last_error();
  ContactBody other = testing::make_rigged(bar.model, testing::bar_skin(bar), {});
  const BoneWeights weights = testing::bar_skin(bar)->drawn;
  tremolo_body* weighed = nullptr;
  ASSERT_EQ(tremolo_body_create_with_weights(model, nullptr, 3, weights.data(), &weighed),
            TREMOLO_OK)
      << tremolo_last_error();
  for (int k = 1; k <= 50; ++k) {
    const double half = 0.01 * k, turn[] = {std::cos(half), 0.0, std::sin(half), 0.0};
    const tremolo_frame_motion motion = {{1.0, 0.0, 0.0}, {0.0, 6.0, 0.0}, {0.0, 0.1, 0.0}};
    for (const std::size_t bone : {std::size_t{1}, std::size_t{2}}) {
      const bool known = bone == 1;
      for (tremolo_body* each : {body, weighed})
        ASSERT_EQ(tremolo_body_move_bone_to(each, bone, kHere, turn, known ? &motion : nullptr),
                  TREMOLO_OK);
      const Pose pose{Vector3d(kHere), Eigen::Quaterniond(turn[0], turn[1], turn[2], turn[3])};
      const FrameMotion same = {{1.0, 0.0, 0.0}, {0.0, 6.0, 0.0}, {0.0, 0.1, 0.0}};
      ASSERT_TRUE(other.move_to(pose, known ? std::optional(same) : std::nullopt, bone));
    }
    for (tremolo_body* each : {body, weighed})
      ASSERT_EQ(tremolo_body_step(each, 1, nullptr), TREMOLO_OK);
    ASSERT_TRUE(other.step().converged);
  }
  Eigen::VectorXd q(4), p(4);
  ASSERT_EQ(tremolo_body_state(body, q.data(), p.data(), 4), TREMOLO_OK);
  EXPECT_GT(q.norm(), 1e-3);
  EXPECT_EQ(q, other.state().q);
  // Vertices inside have the weights of the nearest drawn one instead of their own.
  ASSERT_EQ(tremolo_body_state(weighed, q.data(), p.data(), 4), TREMOLO_OK);
  EXPECT_LE((q - other.state().q).norm(), 0.2 * q.norm());
  EXPECT_EQ(tremolo_body_set_bone(body, 3, kHere, kUpright), TREMOLO_USAGE);
  EXPECT_NE(std::strstr(tremolo_last_error(), "no bone 3"), nullptr);
  EXPECT_EQ(tremolo_body_set_contact(body, nullptr), TREMOLO_OK);
  EXPECT_EQ(tremolo_body_create_on_bones(model, nullptr, 0, segments.data(), 0.1, &body),
            TREMOLO_USAGE);
  const std::vector<double> wrong(weights.size(), 1.0);
  EXPECT_EQ(tremolo_body_create_with_weights(model, nullptr, 3, wrong.data(), &body),
            TREMOLO_CONTENT);
  tremolo_body_destroy(body);
  tremolo_body_destroy(weighed);
  tremolo_model_release(model);
}

TEST_F(CApiFrames, WhatIsWrongIsToldAndChangesNothing) {
  make(TREMOLO_DRIVEN);
  const double nowhere[] = {NAN, 0.0, 0.0}, longer[] = {2.0, 0.0, 0.0, 0.0};
  EXPECT_EQ(tremolo_body_set_pose(body_, nowhere, kUpright), TREMOLO_USAGE);
  EXPECT_NE(std::strstr(tremolo_last_error(), "not finite"), nullptr);
  EXPECT_EQ(tremolo_body_set_pose(body_, kHere, longer), TREMOLO_USAGE);
  EXPECT_NE(std::strstr(tremolo_last_error(), "length 2"), nullptr);
  EXPECT_EQ(tremolo_body_move_to(body_, kHere, longer, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_set_motion(body_, kHere, kHere), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_set_gravity(body_, nowhere), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_set_pose(nullptr, kHere, kUpright), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_set_pose(body_, nullptr, kUpright), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_pose(body_, nullptr, nullptr), TREMOLO_OK);
  EXPECT_EQ(tremolo_body_work(body_, nullptr, nullptr, nullptr, nullptr), TREMOLO_OK);
  EXPECT_EQ(tremolo_body_momentum(nullptr, nullptr, nullptr), TREMOLO_USAGE);
  tremolo_body_options options;
  tremolo_body_options_init(&options);
  tremolo_body* other = nullptr;
  options.frame = 7;
  EXPECT_EQ(tremolo_body_create(model_, &options, &other), TREMOLO_USAGE);
  EXPECT_NE(std::strstr(tremolo_last_error(), "no frame 7"), nullptr);
  options.frame = TREMOLO_FREE;
  EXPECT_EQ(tremolo_body_create(model_, &options, &other), TREMOLO_USAGE);
  // A program that knows the shorter struct gets a fixed body.
  options.size = offsetof(tremolo_body_options, frame);
  ASSERT_EQ(tremolo_body_create(model_, &options, &other), TREMOLO_OK) << tremolo_last_error();
  EXPECT_EQ(tremolo_body_set_pose(other, kHere, kUpright), TREMOLO_USAGE);
  tremolo_body_destroy(other);
  options.size = sizeof(options);
  options.frame = TREMOLO_DRIVEN;
  tremolo_crowd* world = nullptr;
  uint32_t group = 0;
  ASSERT_EQ(tremolo_crowd_create(1, &world), TREMOLO_OK);
  EXPECT_EQ(tremolo_crowd_add_group(world, model_, &options, nullptr, &group), TREMOLO_USAGE);
  tremolo_crowd_destroy(world);
}

}  // namespace
}  // namespace tremolo
