// Animations and how they are recorded.
#include "runtime/io/exchange/animation.h"

#include <limits>

#include <gtest/gtest.h>

#include "runtime/bodies/reduced/rigid/rigid_solid.h"
#include "runtime/io/exchange/morph_targets.h"
#include "runtime/io/exchange/recording.h"
#include "tests/support/frames/rigged_model.h"
#include "tests/support/sample_render.h"
#include "tests/support/wavy_animation.h"

namespace tremolo {
namespace {

using testing::make_framed;
using testing::wavy_animation;

void expect_refused(const Animation& animation, const std::string& word) {
  const Status status = check_animation(animation);
  ASSERT_FALSE(status) << word;
  EXPECT_EQ(status.error().kind, ErrorKind::kUsage);
  EXPECT_NE(status.error().message.find(word), std::string::npos) << status.error().message;
}

TEST(Animation, WhatDoesNotFitIsNamed) {
  const Animation good = wavy_animation(4, 3, 5);
  ASSERT_TRUE(check_animation(good));
  const auto spoilt = [&good](const auto& spoil) {
    Animation bad = good;
    spoil(bad);
    return bad;
  };
  using A = Animation;
  expect_refused(spoilt([](A& a) { a.bodies.clear(); }), "no body");
  expect_refused(spoilt([](A& a) { a.times.clear(); }), "no frame");
  expect_refused(spoilt([](A& a) { a.times[2] = a.times[1]; }), "ascend");
  expect_refused(spoilt([](A& a) { a.rate = 0.0; }), "frames a second");
  expect_refused(spoilt([](A& a) { a.bodies[0].shape = 1; }), "'sheet': it has no shape");
  expect_refused(spoilt([](A& a) { a.bodies[0].q.pop_back(); }), "all coordinates");
  expect_refused(spoilt([](A& a) { a.bodies[0].poses.pop_back(); }), "a pose");
  expect_refused(spoilt([](A& a) { a.bodies[0].poses[1].rotation.w() = 2.0; }), "length one");
  expect_refused(spoilt([](A& a) { a.bodies[0].name.clear(); }), "name");
  expect_refused(spoilt([](A& a) { a.bodies.push_back(a.bodies[0]); }), "name of its own");
  expect_refused(spoilt([](A& a) { a.shapes[0].surface.triangles[3][1] = 16; }), "corner 16");
  expect_refused(spoilt([](A& a) { a.shapes[0].surface.uvs.pop_back(); }), "texture");
  expect_refused(spoilt([](A& a) { a.shapes[0].surface.material_of[0] = 2; }), "no name");
  expect_refused(spoilt([](A& a) { a.shapes[0].modes.conservativeResize(45, 3); }), "rows");
  expect_refused(spoilt([](A& a) { a.bodies[0].q[4] = std::numeric_limits<double>::quiet_NaN(); }),
                 "finite");
}

TEST(Animation, WhatIsCutOffIsMeasured) {
  Animation animation = wavy_animation(5, 3, 4);
  // The last coordinate moves one vertex by 3 cm and all others by less.
  animation.shapes[0].modes.col(2).setZero();
  animation.shapes[0].modes(31, 2) = 1.0;
  animation.bodies[0].q = {1, 2, 0.01, 3, 4, -0.03, 5, 6, 0.02, 7, 8, 0.0};
  const Result<double> lost = keep_coordinates(animation, 2);
  ASSERT_TRUE(lost);
  EXPECT_NEAR(*lost, 0.03, 1e-15);  // the sheet is 1 m wide
  EXPECT_EQ(animation.shapes[0].modes.cols(), 2);
  EXPECT_EQ(animation.bodies[0].q, (std::vector<double>{1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_TRUE(check_animation(animation));
  EXPECT_EQ(*keep_coordinates(animation, 9), 0.0);
  EXPECT_FALSE(keep_coordinates(animation, 0));
}

TEST(Recording, ABodyOnBonesIsWhereTheBodySaysItIs) {
  const testing::RiggedBar bar = testing::rigged_bar(5);
  const std::vector<BoneSegment> segments = {{{0, 0.05, 0.06}, {0.3, 0.05, 0.06}},
                                             {{0.3, 0.05, 0.06}, {0.6, 0.05, 0.06}}};
  const auto skin = skin_near_bones(*bar.model, segments, 0.2);
  ASSERT_TRUE(skin) << skin.error().message;
  Result<Body> body = Body::create(bar.model, "ep4", {}, *skin);
  ASSERT_TRUE(body) << body.error().message;
  ASSERT_TRUE(body->set_pose({{0.1, 0.0, 0.05}, turn_by({0.0, 0.4, 0.1})}, 1));
  ASSERT_TRUE(body->set_state(Eigen::VectorXd::Constant(5, 0.01), Eigen::VectorXd::Zero(5)));
  Recording recording;
  const auto track = recording.add(*body, "bar");
  ASSERT_TRUE(track);
  ASSERT_TRUE(recording.begin_frame(0.0));
  ASSERT_TRUE(recording.record(*track, *body));
  const Result<Animation> animation = recording.animation();
  ASSERT_TRUE(animation) << animation.error().message;
  std::vector<double> exact(3 * bar.model->drawn().rest.size()), ours(exact.size());
  ASSERT_TRUE(body->surface_positions(std::span<double>(exact)));
  world_positions(*animation, animation->bodies[0], 0, ours);
  for (std::size_t i = 0; i < exact.size(); ++i) EXPECT_NEAR(ours[i], exact[i], 1e-15);
}

TEST(Recording, AFreeBodyIsWhereTheBodySaysItIsAndSharesItsShape) {
  const Model::Pointer model = testing::frame_model(4, true, 20.0, 400.0, 0.2, 5);
  IntegratorOptions options;
  options.step = 1e-3;
  ContactBody one = make_framed(model, FrameKind::kFree, options);
  ContactBody two = make_framed(model, FrameKind::kFree, options);
  ASSERT_TRUE(one.set_motion({1, 2, 3}, {4, 5, 6}));
  Recording recording;
  const std::size_t a = *recording.add(one, "one"), b = *recording.add(two, "two");
  for (int frame = 0; frame < 3; ++frame) {
    ASSERT_TRUE(recording.begin_frame(one.time()));
    ASSERT_TRUE(recording.record(a, one));
    ASSERT_TRUE(recording.record(b, two));
    testing::steps_of(one, 10);
  }
  const Result<Animation> animation = recording.animation();
  ASSERT_TRUE(animation) << animation.error().message;
  EXPECT_EQ(animation->shapes.size(), 1U);
  EXPECT_EQ(animation->times, (std::vector<double>{0.0, 0.01, 0.02}));
  std::vector<double> ours(3 * model->drawn().rest.size()), exact(ours.size()), moved(ours.size());
  world_positions(*animation, animation->bodies[1], 2, ours);
  ASSERT_TRUE(two.surface_positions(std::span<double>(exact)));
  for (std::size_t i = 0; i < exact.size(); ++i) EXPECT_NEAR(ours[i], exact[i], 1e-15);
  // The displacement is the difference between the rest shape at the pose and the position.
  world_positions(*animation, animation->bodies[0], 2, ours);
  world_displacements(*animation, animation->bodies[0], 2, moved);
  const Pose& pose = animation->bodies[0].poses[2];
  for (std::size_t v = 0; v < model->drawn().rest.size(); ++v)
    for (int k = 0; k < 3; ++k) {
      const std::size_t at = 3 * v + static_cast<std::size_t>(k);
      EXPECT_NEAR(moved[at], ours[at] - (pose * model->drawn().rest[v])[k], 1e-14);
    }
}

TEST(Recording, AFrameWithoutATrackIsNoFrame) {
  const Model::Pointer model = testing::frame_model(3, false, 20.0, 400.0, 0.2, 5);
  Recording recording;
  EXPECT_FALSE(recording.animation());
  ASSERT_TRUE(recording.add(model, "a"));
  ASSERT_TRUE(recording.add(model, "b"));
  EXPECT_FALSE(recording.add(model, "a"));
  EXPECT_FALSE(recording.add(model, ""));
  const std::vector<double> q(3, 0.0);
  const Pose pose;
  const auto record = [&](std::size_t track) { return recording.record(track, q, {&pose, 1}); };
  EXPECT_FALSE(record(0)) << "there is no frame";
  ASSERT_TRUE(recording.begin_frame(0.5));
  EXPECT_TRUE(record(0));
  EXPECT_FALSE(record(0)) << "twice";
  EXPECT_FALSE(record(2)) << "no such track";
  EXPECT_FALSE(recording.begin_frame(0.6)) << "b is missing";
  EXPECT_FALSE(recording.animation()) << "b is missing";
  EXPECT_FALSE(recording.record(1, std::span(q).first(2), {&pose, 1}));
  EXPECT_FALSE(recording.record(1, q, {}));
  EXPECT_TRUE(record(1));
  EXPECT_FALSE(recording.begin_frame(0.5)) << "not later";
  EXPECT_TRUE(recording.animation());
}

// In frames without it a body has the values of the nearest frame with it.
TEST(Recording, ABodyThatComesOrGoesIsShownInItsOwnFramesAlone) {
  const Model::Pointer model = testing::frame_model(3, false, 20.0, 400.0, 0.2, 5);
  Recording recording;
  ASSERT_TRUE(recording.add(model, "whole"));
  ASSERT_TRUE(recording.add(model, "goes"));
  const auto record = [&](std::size_t track, double value) {
    const std::vector<double> q(3, value);
    const Pose pose{Eigen::Vector3d::Constant(value)};
    return recording.record(track, q, {&pose, 1});
  };
  for (int frame = 0; frame < 5; ++frame) {
    ASSERT_TRUE(recording.begin_frame(frame));
    ASSERT_TRUE(record(0, frame));
    if (frame < 2) {
      ASSERT_TRUE(record(1, 10.0 + frame));
    }
    if (frame == 2) {
      EXPECT_FALSE(recording.animation()) << "a track is missing";
      ASSERT_TRUE(recording.end(1));
      EXPECT_FALSE(record(1, 0.0)) << "it is over";
      ASSERT_TRUE(recording.animation());
      ASSERT_TRUE(recording.add(model, "comes"));
      ASSERT_TRUE(recording.add(model, "never"));
    }
    if (frame >= 3) {
      ASSERT_TRUE(record(2, 20.0 + frame));
      EXPECT_FALSE(record(2, 0.0)) << "twice";
    }
  }
  EXPECT_FALSE(recording.end(9));
  const Result<Animation> animation = recording.animation();
  ASSERT_TRUE(animation) << animation.error().message;
  ASSERT_EQ(animation->bodies.size(), 3U);
  const auto numbers = [&](std::size_t body) {
    std::vector<double> first;
    for (std::size_t frame = 0; frame < 5; ++frame) {
      first.push_back(coordinates_at(*animation, animation->bodies[body], frame)[1]);
      EXPECT_EQ(poses_at(animation->bodies[body], frame)[0].position.y(), first.back());
    }
    return first;
  };
  EXPECT_EQ(numbers(0), (std::vector<double>{0, 1, 2, 3, 4}));
  EXPECT_EQ(numbers(1), (std::vector<double>{10, 11, 11, 11, 11}));
  EXPECT_EQ(numbers(2), (std::vector<double>{23, 23, 23, 23, 24}));
  EXPECT_TRUE(animation->bodies[0].shown.empty());
  EXPECT_EQ(animation->bodies[1].shown, (std::vector<std::uint8_t>{1, 1, 0, 0, 0}));
  EXPECT_EQ(animation->bodies[2].shown, (std::vector<std::uint8_t>{0, 0, 0, 1, 1}));
  ASSERT_TRUE(recording.begin_frame(5.0));
  EXPECT_FALSE(recording.begin_frame(6.0)) << "a body that came is missing";
}

TEST(Recording, ARenderSurfaceKeepsItsSeamTogether) {
  BasisData data = testing::sample_basis(
      testing::random_strain_model(testing::spread_omega(4, 5.0, 900.0), 0.3, 71));
  data.render = testing::tube(4);
  const Result<Model::Pointer> model = Model::from_data(data);
  ASSERT_TRUE(model) << model.error().message;
  const AnimatedShape shape = animated_shape(**model, "tube");
  EXPECT_EQ(shape.surface.uvs.size(), shape.surface.vertices.size());
  ASSERT_EQ(shape.smooth_groups.size(), shape.surface.vertices.size());
  EXPECT_EQ(shape.smooth_groups[0], shape.smooth_groups[testing::kTubeSides]);
}

TEST(Recording, ARigidBoxHasSharpEdges) {
  RigidSolid solid;
  solid.shape = BoxShape{{0.1, 0.2, 0.3}};
  const Result<Model::Pointer> box = make_rigid_model(solid);
  ASSERT_TRUE(box) << box.error().message;
  const AnimatedShape shape = animated_shape(**box, "box");
  EXPECT_EQ(shape.modes.rows(), static_cast<Eigen::Index>(3 * shape.surface.vertices.size()));
  for (const Eigen::Vector3d& normal : smooth_normals(shape, shape.surface.vertices))
    EXPECT_NEAR(normal.cwiseAbs().maxCoeff(), 1.0, 1e-12) << normal.transpose();
}

TEST(Recording, RigidBallsAreRoundAndThoseOfOneSizeShareTheirSurface) {
  Recording recording;
  const std::vector<double> radii = {0.1, 0.1, 0.2};
  for (std::size_t k = 0; k < radii.size(); ++k) {
    RigidSolid solid;
    solid.shape = SphereShape{radii[k]};
    const Result<Model::Pointer> ball = make_rigid_model(solid);
    ASSERT_TRUE(ball) << ball.error().message;
    ASSERT_TRUE(recording.add(*ball, "ball-" + std::to_string(k)));
  }
  ASSERT_TRUE(recording.begin_frame(0.0));
  for (std::size_t k = 0; k < radii.size(); ++k)
    ASSERT_TRUE(recording.record(k, {}, std::vector<Pose>(1)));
  const Result<Animation> animation = recording.animation();
  ASSERT_TRUE(animation) << animation.error().message;
  ASSERT_EQ(animation->shapes.size(), 2U);
  EXPECT_EQ(animation->bodies[0].shape, animation->bodies[1].shape);
  for (std::size_t k = 0; k < radii.size(); ++k) {
    const RenderSurface& surface = animation->shape_of(animation->bodies[k]).surface;
    for (const Triangle& t : surface.triangles) {
      const Eigen::Vector3d middle =
          (surface.vertices[t[0]] + surface.vertices[t[1]] + surface.vertices[t[2]]) / 3.0;
      EXPECT_NEAR(middle.norm(), radii[k], 0.003 * radii[k]);
    }
  }
}

// Six times the volume.
double six_volumes(const RenderSurface& surface) {
  double sum = 0.0;
  for (const Triangle& t : surface.triangles)
    sum += surface.vertices[t[0]].dot(surface.vertices[t[1]].cross(surface.vertices[t[2]]));
  return sum;
}

TEST(ColliderShape, SolidsAreTheCollidersOwnTurnedOutwards) {
  const double pi = std::numbers::pi;
  const std::pair<Collider, double> solids[] = {
      {SphereShape{0.3}, 4.0 / 3.0 * pi * 0.027},
      {CapsuleShape{0.3, 0.5}, 4.0 / 3.0 * pi * 0.027 + pi * 0.09},
      {CapsuleShape{0.3, 0.0}, 4.0 / 3.0 * pi * 0.027},
      {CylinderShape{0.2, 0.7}, pi * 0.04 * 1.4},
      {BoxShape{{0.1, 0.2, 0.3}}, 8.0 * 0.006}};
  for (const auto& [collider, volume] : solids) {
    const auto shape = collider_shape(collider, "solid", 1.0);
    ASSERT_TRUE(shape);
    EXPECT_NEAR(six_volumes(shape->surface) / 6.0, volume, 0.005 * volume) << shape_name(collider);
    for (const Eigen::Vector3d& x : shape->surface.vertices)
      EXPECT_NEAR(signed_distance(collider, x).distance, 0.0, 1e-15) << shape_name(collider);
  }
}

TEST(ColliderShape, APlaneIsASquareAndAGridNothing) {
  const auto plane = collider_shape(PlaneShape{}, "floor", 2.5);
  ASSERT_TRUE(plane);
  EXPECT_EQ(largest_extent(*plane), 5.0);
  const Triangle t = plane->surface.triangles[0];
  const auto at = [&](int k) { return plane->surface.vertices[t[k]]; };
  EXPECT_GT((at(1) - at(0)).cross(at(2) - at(0)).z(), 0.0) << "seen from above";
  EXPECT_FALSE(collider_shape(GridShape{}, "bell", 1.0));
}

}  // namespace
}  // namespace tremolo
