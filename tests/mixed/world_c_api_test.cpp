// runtime/tremolo_scene.h: worlds whose bodies, colliders and joints come, go and are moved by
// calls.
#include "tests/mixed/world_c_api.h"

#include <cmath>

namespace tremolo {
namespace {

// A body that comes later falls and lands with the bits of one that was there from the start.
TEST_F(WorldCApi, ABodyThatComesLaterMovesAsOneOfTheScene) {
  for (const CubeKind kind : kKinds) {
    SCOPED_TRACE(static_cast<int>(kind));
    const tremolo_scene_body place = at("one", {0.0, 0.0, 0.07});
    tremolo_scene* scene = nullptr;
    ASSERT_EQ(tremolo_scene_create(kWorldStep, &scene), TREMOLO_OK);
    add(scene, kind, place);
    ASSERT_EQ(tremolo_scene_add_collider(scene, &floor_), TREMOLO_OK);
    tremolo_world* from_start = of(scene);
    tremolo_world* later = make_world(true);
    advance(later, 37);
    const tremolo_body_id body = add(later, kind, place);
    advance(from_start, 60);
    advance(later, 60);
    EXPECT_TRUE(positions(from_start, tremolo_world_body(from_start, 0)) == positions(later, body));
    std::int64_t contacts = 0;
    ASSERT_EQ(tremolo_world_contact(later, body, &contacts, nullptr, nullptr, nullptr), TREMOLO_OK);
    EXPECT_GT(contacts, 0);
  }
}

// A body that stood on one that is removed falls freely, also if it slept: h = g t^2/2.
TEST_F(WorldCApi, WhatStoodOnABodyThatIsRemovedFalls) {
  for (const CubeKind below : kSolids)
    for (const CubeKind above : kKinds) {
      SCOPED_TRACE(std::to_string(static_cast<int>(below)) +
                   std::to_string(static_cast<int>(above)));
      tremolo_world* world = make_world(true);
      const tremolo_body_id support = add(world, below, at("below", {0.0, 0.0, kHalfEdge}));
      const double height = above == CubeKind::kCloth ? 2.0 * kHalfEdge + 0.001 : 3.0 * kHalfEdge;
      // Flush edges of tetrahedra on tetrahedra take many corrections.
      const tremolo_body_id body = add(world, above, at("above", {0.013, 0.008, height}));
      const bool both_rigid = below == CubeKind::kRigid && above == CubeKind::kRigid;
      advance(world, both_rigid ? 900 : 300);
      EXPECT_LT(std::abs(middle(world, body).z() - height), 0.01) << "it lies on the other one";
      std::int32_t asleep = 0;
      ASSERT_EQ(tremolo_world_look(world, body, &asleep, nullptr), TREMOLO_OK);
      if (both_rigid) {
        EXPECT_EQ(asleep, 1);
      }
      const double before = middle(world, body).z(), speed = momentum(world, body).norm();
      ASSERT_EQ(tremolo_world_remove(world, support), TREMOLO_OK);
      constexpr int kSteps = 40;
      advance(world, kSteps);
      const double t = kSteps * kWorldStep, fallen = before - middle(world, body).z();
      EXPECT_NEAR(fallen, 0.5 * kFall * t * t, 0.04 * 0.5 * kFall * t * t + speed * t);
      EXPECT_EQ(tremolo_world_bodies(world), 2U);
    }
}

TEST_F(WorldCApi, IdsOfBodiesThatWereRemovedAreRefused) {
  for (const CubeKind kind : kKinds) {
    SCOPED_TRACE(static_cast<int>(kind));
    tremolo_world* world = make_world(true);
    const tremolo_body_id first = add(world, kind, at("one", {0.0, 0.0, 0.3}));
    EXPECT_EQ(tremolo_world_bodies(world), 2U);
    int own = 5;
    ASSERT_EQ(tremolo_world_set_user_data(world, first, &own), TREMOLO_OK);
    EXPECT_EQ(tremolo_world_user_data(world, first), &own);
    advance(world, 2);
    std::uint64_t hand = 0;
    ASSERT_EQ(tremolo_world_grab(world, first, 0, 10.0, 0.0, &hand), TREMOLO_OK)
        << tremolo_last_error();
    ASSERT_EQ(tremolo_world_remove(world, first), TREMOLO_OK);
    EXPECT_EQ(tremolo_world_remove(world, first), TREMOLO_USAGE);
    EXPECT_NE(std::string(tremolo_last_error()).find("has been removed"), std::string::npos);
    double x[3];
    tremolo_energy_account account;
    EXPECT_EQ(tremolo_world_vertices(world, first), 0U);
    EXPECT_EQ(tremolo_world_name(world, first), nullptr);
    EXPECT_EQ(tremolo_world_user_data(world, first), nullptr);
    EXPECT_EQ(tremolo_world_account(world, first, &account), TREMOLO_USAGE);
    EXPECT_EQ(tremolo_world_momentum(world, first, x, nullptr), TREMOLO_USAGE);
    EXPECT_EQ(tremolo_world_hand_force(world, first, hand, x), TREMOLO_USAGE);
    EXPECT_EQ(tremolo_world_pose(world, first, x, nullptr), TREMOLO_USAGE);
    EXPECT_EQ(tremolo_world_account(world, 0, &account), TREMOLO_USAGE);
    advance(world, 3);
    // Its name and its place are free; the next one is another body.
    const tremolo_body_id second = add(world, kind, at("one", {0.0, 0.0, 0.3}));
    EXPECT_NE(first, second);
    EXPECT_EQ(tremolo_world_user_data(world, second), nullptr);
    EXPECT_EQ(tremolo_world_account(world, first, &account), TREMOLO_USAGE);
    const double before = middle(world, second).z();
    advance(world, 20);
    const double t = 20.0 * kWorldStep;
    EXPECT_NEAR(before - middle(world, second).z(), 0.5 * kFall * t * t, 0.06 * kFall * t * t)
        << "the hand of the first does not hold the second";
  }
}

TEST_F(WorldCApi, WrongBodiesAreRefusedAndChangeNothing) {
  tremolo_world* world = make_world(true);
  const std::vector<std::byte> before = saved(world);
  tremolo_body_id body = 7;
  tremolo_scene_body place = at("far", {0.0, 0.0, 1.0});
  EXPECT_EQ(tremolo_world_add_rigid(world, &place, box_, 1.0, &body), TREMOLO_CONTENT);
  EXPECT_EQ(std::string(tremolo_last_error()), "two bodies are called 'far'");
  place = at("deep", {0.0, 0.0, 0.0});
  EXPECT_EQ(tremolo_world_add_rigid(world, &place, box_, 1.0, &body), TREMOLO_CONTENT);
  EXPECT_NE(std::string(tremolo_last_error()).find("body 'deep': it begins"), std::string::npos);
  place = at("other", {50.0, 0.0, 500.01});
  EXPECT_EQ(tremolo_world_add_rigid(world, &place, box_, 1.0, &body), TREMOLO_CONTENT);
  EXPECT_NE(std::string(tremolo_last_error()).find("inside body 'far'"), std::string::npos);
  place = at("light", {0.0, 0.0, 1.0});
  EXPECT_EQ(tremolo_world_add_rigid(world, &place, box_, -1.0, &body), TREMOLO_CONTENT);
  tremolo_tets_options options;
  tremolo_tets_options_init(&options);
  options.file = "/there/is/none.tets";
  EXPECT_EQ(tremolo_world_add_tets(world, &place, &options, &body), TREMOLO_SYSTEM);
  EXPECT_EQ(body, 7U);
  EXPECT_EQ(tremolo_world_bodies(world), 1U);
  EXPECT_TRUE(saved(world) == before);
  tremolo_world* other = make_world(true);
  advance(world, 5);
  advance(other, 5);
  EXPECT_TRUE(saved(world) == saved(other));
}

// A floor that begins to glide drags what lies on it with mu g until both have one speed.
TEST_F(WorldCApi, AColliderThatIsMovedByCallsDragsWhatLiesOnIt) {
  for (const CubeKind kind : kSolids) {
    SCOPED_TRACE(static_cast<int>(kind));
    tremolo_world* world = make_world(true);
    const tremolo_body_id body = add(world, kind, at("one", {0.0, 0.0, kHalfEdge}));
    advance(world, 400);
    const double m = mass(kind), start = momentum(world, body).x() / m;
    const double turn[4] = {1.0, 0.0, 0.0, 0.0};
    double place[3] = {0.0, 0.0, 0.0};
    const auto glide = [&](int steps, double speed) {
      for (int k = 0; k < steps; ++k) {
        place[0] += speed * kWorldStep;
        ASSERT_EQ(tremolo_world_move_collider(world, 0, place, turn), TREMOLO_OK);
        advance(world, 1);
      }
    };
    glide(60, 2.0);
    // The first steps hold by elastic friction.
    const double after = momentum(world, body).x() / m;
    EXPECT_NEAR(after - start, 0.5 * kFall * 60.0 * kWorldStep,
                0.03 * 0.5 * kFall * 60.0 * kWorldStep);
    glide(300, 2.0);
    EXPECT_NEAR(momentum(world, body).x() / m, 2.0, 0.02);
    // The floor stops at its last pose, and the body with it.
    advance(world, 500);
    EXPECT_NEAR(momentum(world, body).x() / m, 0.0, 0.01);
    ASSERT_EQ(tremolo_world_remove_collider(world, 0), TREMOLO_OK);
    EXPECT_EQ(tremolo_world_move_collider(world, 0, place, turn), TREMOLO_USAGE);
    EXPECT_EQ(std::string(tremolo_last_error()), "collider 0 has been removed");
    const double before = middle(world, body).z();
    advance(world, 20);
    EXPECT_NEAR(before - middle(world, body).z(), 0.5 * kFall * std::pow(20.0 * kWorldStep, 2),
                1e-3);
  }
}

// A collider that comes later is one of the scene; one around a body is refused.
TEST_F(WorldCApi, ACollidersComesLaterUnderABodyOfEachKind) {
  for (const CubeKind kind : kKinds) {
    SCOPED_TRACE(static_cast<int>(kind));
    tremolo_world* world = make_world(false);
    const tremolo_body_id body = add(world, kind, at("one", {0.0, 0.0, 0.1}));
    advance(world, 3);
    std::uint32_t number = 9;
    tremolo_placed_collider high = floor_;
    high.position[2] = 0.2;
    EXPECT_EQ(tremolo_world_add_collider(world, &high, &number), TREMOLO_CONTENT);
    EXPECT_EQ(tremolo_world_colliders(world), 0U);
    ASSERT_EQ(tremolo_world_add_collider(world, &floor_, &number), TREMOLO_OK)
        << tremolo_last_error();
    EXPECT_EQ(number, 0U);
    advance(world, 600);
    const double rest = kind == CubeKind::kCloth ? 0.0 : kHalfEdge;
    EXPECT_NEAR(middle(world, body).z(), rest, 0.004);
    Eigen::Vector3d force;
    ASSERT_EQ(tremolo_world_contact(world, body, nullptr, nullptr, force.data(), nullptr),
              TREMOLO_OK);
    EXPECT_NEAR(force.z(), mass(kind) * kFall, 0.02 * mass(kind) * kFall);
  }
}

// A body on a spring to a point of the world hangs at rest with m g/k, and falls without it.
TEST_F(WorldCApi, JointsByCallsCarryAndLetGo) {
  for (const CubeKind kind : kKinds) {
    SCOPED_TRACE(static_cast<int>(kind));
    tremolo_world* world = make_world(false);
    const tremolo_body_id body = add(world, kind, at("one", {0.0, 0.0, 1.0}));
    advance(world, 2);
    tremolo_joint joint;
    tremolo_joint_init(&joint);
    joint.body = "one";
    joint.at = kind == CubeKind::kCloth ? "top-left" : "near:0,0,0.05";
    const double weight = mass(kind) * kFall;
    joint.stiffness = weight / 0.01;
    joint.damping = 0.5 * std::sqrt(joint.stiffness * weight / kFall);
    std::uint32_t number = 9;
    ASSERT_EQ(tremolo_world_add_joint(world, &joint, &number), TREMOLO_OK) << tremolo_last_error();
    EXPECT_EQ(number, 0U);
    advance(world, 2000);
    Eigen::Vector3d force;
    double energy = 0.0, mean = 0.0;
    std::int32_t holds = 0;
    constexpr int kMean = 2000;  // the sheet swings
    for (int k = 0; k < kMean; ++k) {
      advance(world, 1);
      ASSERT_EQ(tremolo_world_joint(world, 0, force.data(), &energy, &holds), TREMOLO_OK);
      EXPECT_EQ(holds, 1);
      mean += force.z() / kMean;
    }
    EXPECT_NEAR(mean, weight, 0.03 * weight);
    if (kind != CubeKind::kCloth) {
      EXPECT_NEAR(energy, 0.5 * weight * 0.01, 0.03 * 0.5 * weight * 0.01);
    }
    const double before = middle(world, body).z();
    ASSERT_EQ(tremolo_world_remove_joint(world, 0), TREMOLO_OK);
    ASSERT_EQ(tremolo_world_joint(world, 0, force.data(), &energy, &holds), TREMOLO_OK);
    EXPECT_EQ(holds, 0);
    advance(world, 50);
    EXPECT_NEAR(before - middle(world, body).z(), 0.5 * kFall * 0.01, 0.15 * kFall * 0.01);
    joint.to = "nobody";
    EXPECT_EQ(tremolo_world_add_joint(world, &joint, &number), TREMOLO_CONTENT);
    EXPECT_EQ(tremolo_world_remove_joint(world, 1), TREMOLO_USAGE);
  }
}

// Joints are numbered over all kinds of bodies: one on a guest may follow those on others.
TEST_F(WorldCApi, AJointOnAGuestFollowsThoseOnOtherBodies) {
  for (const CubeKind kind : {CubeKind::kSoft, CubeKind::kCloth}) {
    SCOPED_TRACE(static_cast<int>(kind));
    tremolo_world* world = make_world(true);
    add(world, kind, at("one", {0.0, 0.0, 1.0}));
    tremolo_joint joint;
    tremolo_joint_init(&joint);
    joint.body = "far";
    joint.at = "0";
    std::uint32_t number = 9;
    for (std::uint32_t k = 0; k < 5; ++k) {
      ASSERT_EQ(tremolo_world_add_joint(world, &joint, &number), TREMOLO_OK)
          << tremolo_last_error();
      EXPECT_EQ(number, k);
    }
    joint.body = "one";
    joint.at = kind == CubeKind::kCloth ? "top-left" : "near:0,0,0.05";
    ASSERT_EQ(tremolo_world_add_joint(world, &joint, &number), TREMOLO_OK) << tremolo_last_error();
    EXPECT_EQ(number, 5U);
    advance(world, 20);
    Eigen::Vector3d force;
    ASSERT_EQ(tremolo_world_joint(world, 5, force.data(), nullptr, nullptr), TREMOLO_OK);
    EXPECT_GT(force.z(), 0.0);
    ASSERT_EQ(tremolo_world_remove_joint(world, 5), TREMOLO_OK);
    std::int32_t holds = 1;
    ASSERT_EQ(tremolo_world_joint(world, 5, force.data(), nullptr, &holds), TREMOLO_OK);
    EXPECT_EQ(holds, 0);
    ASSERT_EQ(tremolo_world_joint(world, 4, force.data(), nullptr, &holds), TREMOLO_OK);
    EXPECT_EQ(holds, 1);
  }
}

}  // namespace
}  // namespace tremolo
