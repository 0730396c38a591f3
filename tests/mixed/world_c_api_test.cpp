// runtime/tremolo_scene.h: worlds whose bodies, colliders and joints come, go and are moved by
// calls.
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/tremolo_scene.h"
#include "runtime/world/world.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

constexpr double kWorldStep = 0.002, kFall = 9.81, kHalfEdge = 0.05;

// A cube of 0.1 m, of each kind; the cloth is a square of that size.
enum class CubeKind { kReduced, kRigid, kTets, kCloth };
constexpr std::array kKinds = {CubeKind::kReduced, CubeKind::kRigid, CubeKind::kTets,
                               CubeKind::kCloth};
constexpr std::array kSolids = {CubeKind::kReduced, CubeKind::kRigid, CubeKind::kTets};

class WorldCApi : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = testing::fresh_folder();
    TetMesh mesh = box_mesh({2, 2, 2}, {2 * kHalfEdge, 2 * kHalfEdge, 2 * kHalfEdge});
    for (Eigen::Vector3d& x : mesh.vertices) x -= Eigen::Vector3d::Constant(kHalfEdge);
    write_veg(folder_ + "/cube.veg", mesh);
    for (const char* what :
         {"tets cube.veg --young 2e5 --poisson 0.3 --density 1000 --fix none -o cube.tets",
          "cube.veg --young 2e5 --poisson 0.3 --density 1000 --fix none --linear-modes 6 --modes 9 "
          "--order 1 -o cube.tremolo",
          "cube.veg --young 2e5 --poisson 0.3 --density 1000 --fix 'z<-0.049' --linear-modes 6 "
          "--modes 9 --order 1 -o held.tremolo"}) {
      const ProgramResult made = run_program(folder_, kPrecompute + what);
      ASSERT_EQ(made.code, 0) << made.err;
    }
  }

  void SetUp() override {
    const double half[3] = {kHalfEdge, kHalfEdge, kHalfEdge};
    ASSERT_EQ(tremolo_model_load(path("cube.tremolo").c_str(), 0, &model_), TREMOLO_OK);
    ASSERT_EQ(tremolo_collider_box(half, &box_), TREMOLO_OK);
    ASSERT_EQ(tremolo_collider_plane(&plane_), TREMOLO_OK);
    tremolo_placed_collider_init(&floor_, plane_);
    floor_.friction = 0.5;
    floor_.restitution = 0.0;
  }
  void TearDown() override {
    tremolo_set_log(nullptr, nullptr);
    for (tremolo_world* world : worlds_) tremolo_world_destroy(world);
    tremolo_model_release(model_);
    tremolo_collider_destroy(box_);
    tremolo_collider_destroy(plane_);
  }

  static std::string path(const std::string& name) { return folder_ + "/" + name; }

  // A world with a box far away, which moves alone, and with a floor or without.
  tremolo_world* make_world(bool with_floor, std::uint32_t threads = 1) {
    tremolo_scene* scene = nullptr;
    EXPECT_EQ(tremolo_scene_create(kWorldStep, &scene), TREMOLO_OK);
    tremolo_scene_body place = at("far", {50.0, 0.0, 500.0});
    EXPECT_EQ(tremolo_scene_add_rigid(scene, &place, box_, 1.0), TREMOLO_OK);
    if (with_floor) {
      EXPECT_EQ(tremolo_scene_add_collider(scene, &floor_), TREMOLO_OK);
    }
    return of(scene, threads);
  }
  tremolo_world* of(tremolo_scene* scene, std::uint32_t threads = 1) {
    tremolo_world* world = nullptr;
    EXPECT_EQ(tremolo_world_create(scene, threads, &world), TREMOLO_OK) << tremolo_last_error();
    tremolo_scene_destroy(scene);
    return worlds_.emplace_back(world);
  }

  static tremolo_scene_body at(const char* name, const Eigen::Vector3d& position) {
    tremolo_scene_body place;
    tremolo_scene_body_init(&place);
    place.name = name;
    for (int k = 0; k < 3; ++k) place.position[k] = position[k];
    place.friction = 0.5;
    place.restitution = 0.0;
    place.stiffness = 200.0;
    return place;
  }

  // The description of a body of a kind for tremolo_scene_add_* (a scene) or tremolo_world_add_*.
  template <class Reduced, class Rigid, class Tets, class Cloth>
  tremolo_status add(CubeKind kind, tremolo_scene_body place, const Reduced& reduced,
                     const Rigid& rigid, const Tets& tets, const Cloth& cloth) {
    if (kind == CubeKind::kReduced) {
      tremolo_body_options method;
      tremolo_body_options_init(&method);
      method.frame = TREMOLO_FREE;
      method.beta = 0.002;
      return reduced(place, method);
    }
    if (kind == CubeKind::kRigid) return rigid(place);
    if (kind == CubeKind::kTets) {
      tremolo_tets_options options;
      tremolo_tets_options_init(&options);
      const std::string file = path("cube.tets");
      options.file = file.c_str();
      options.method = "midpoint";
      options.beta = 0.002;
      return tets(place, options);
    }
    tremolo_cloth_options sheet;
    tremolo_cloth_options_init(&sheet);
    sheet.columns = sheet.rows = 5;
    sheet.width = sheet.height = 2.0 * kHalfEdge;
    for (int k = 0; k < 3; ++k) sheet.corner[k] = place.position[k] - (k < 2 ? kHalfEdge : 0.0);
    sheet.density = 10.0;
    sheet.drag = 0.0;
    sheet.stiffness[0] = 2000.0;
    sheet.stiffness[1] = 600.0;
    sheet.stiffness[2] = 20.0;
    sheet.damping[0] = sheet.damping[1] = 0.5;
    sheet.thickness = 0.002;
    sheet.friction = 0.5;
    sheet.restitution = 0.0;
    return cloth(place, sheet);
  }
  tremolo_body_id add(tremolo_world* world, CubeKind kind, const tremolo_scene_body& place) {
    tremolo_body_id body = 0;
    const tremolo_status status = add(
        kind, place,
        [&](const auto& p, const auto& m) {
          return tremolo_world_add_reduced(world, &p, model_, &m, box_, &body);
        },
        [&](const auto& p) { return tremolo_world_add_rigid(world, &p, box_, 1.0, &body); },
        [&](const auto& p, const auto& o) { return tremolo_world_add_tets(world, &p, &o, &body); },
        [&](const auto& p, const auto& o) {
          return tremolo_world_add_cloth(world, &p, "implicit-euler", &o, nullptr, 0, &body);
        });
    EXPECT_EQ(status, TREMOLO_OK) << tremolo_last_error();
    return body;
  }
  void add(tremolo_scene* scene, CubeKind kind, const tremolo_scene_body& place) {
    const tremolo_status status = add(
        kind, place,
        [&](const auto& p, const auto& m) {
          return tremolo_scene_add_reduced(scene, &p, model_, &m, box_);
        },
        [&](const auto& p) { return tremolo_scene_add_rigid(scene, &p, box_, 1.0); },
        [&](const auto& p, const auto& o) { return tremolo_scene_add_tets(scene, &p, &o); },
        [&](const auto& p, const auto& o) {
          return tremolo_scene_add_cloth(scene, &p, "implicit-euler", &o, nullptr, 0);
        });
    EXPECT_EQ(status, TREMOLO_OK) << tremolo_last_error();
  }

  static void advance(tremolo_world* world, int steps) {
    ASSERT_EQ(tremolo_world_step(world, steps, nullptr), TREMOLO_OK) << tremolo_last_error();
  }
  static std::vector<double> positions(const tremolo_world* world, tremolo_body_id body) {
    std::vector<double> places(3 * tremolo_world_vertices(world, body));
    EXPECT_EQ(tremolo_world_positions_double(world, body, places.data(), places.size()), TREMOLO_OK)
        << tremolo_last_error();
    return places;
  }
  // The mean over the drawn vertices.
  static Eigen::Vector3d middle(const tremolo_world* world, tremolo_body_id body) {
    const std::vector<double> places = positions(world, body);
    return Eigen::Map<const Eigen::Matrix3Xd>(places.data(), 3,
                                              static_cast<Eigen::Index>(places.size() / 3))
        .rowwise()
        .mean();
  }
  static Eigen::Vector3d momentum(const tremolo_world* world, tremolo_body_id body) {
    Eigen::Vector3d linear;
    EXPECT_EQ(tremolo_world_momentum(world, body, linear.data(), nullptr), TREMOLO_OK);
    return linear;
  }
  // By a fall of one step from rest: momentum is -m g h.
  double mass(CubeKind kind) {
    tremolo_world* world = make_world(false);
    const tremolo_body_id body = add(world, kind, at("one", {0.0, 0.0, 5.0}));
    advance(world, 1);
    return -momentum(world, body).z() / (kFall * kWorldStep);
  }
  static std::vector<std::byte> saved(const tremolo_world* world) {
    std::size_t size = 0;
    EXPECT_EQ(tremolo_world_save(world, nullptr, 0, &size), TREMOLO_OK);
    std::vector<std::byte> bytes(size);
    EXPECT_EQ(tremolo_world_save(world, bytes.data(), size, &size), TREMOLO_OK);
    return bytes;
  }

  static inline std::string folder_;
  tremolo_model* model_ = nullptr;
  tremolo_collider *box_ = nullptr, *plane_ = nullptr;
  tremolo_placed_collider floor_{};
  std::vector<tremolo_world*> worlds_;
};

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
  // A body that was refused leaves its slot: states of worlds without it no longer fit, the motion
  // is the same.
  tremolo_world* other = make_world(true);
  advance(world, 5);
  advance(other, 5);
  EXPECT_TRUE(positions(world, tremolo_world_body(world, 0)) ==
              positions(other, tremolo_world_body(other, 0)));
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

// All that contact pushed between the begin and the end of a contact is the change of momentum and
// the weight; the points of a step add up to its force.
TEST_F(WorldCApi, EventsHaveTheImpulseOfTheContact) {
  for (const CubeKind kind : kKinds) {
    SCOPED_TRACE(static_cast<int>(kind));
    floor_.restitution = 1.0;
    tremolo_world* world = make_world(true);
    tremolo_scene_body place = at("one", {0.0, 0.0, 0.06});
    place.velocity[2] = -1.0;
    place.restitution = 1.0;
    const tremolo_body_id body = add(world, kind, place);
    bool began = false, ended = false;
    double from = 0.0;
    Eigen::Vector3d start, before = momentum(world, body);
    for (int k = 0; k < 400 && !ended; ++k) {
      advance(world, 1);
      Eigen::Vector3d force, sum = Eigen::Vector3d::Zero();
      ASSERT_EQ(tremolo_world_contact(world, body, nullptr, nullptr, force.data(), nullptr),
                TREMOLO_OK);
      std::array<tremolo_contact_point, 200> points;
      std::size_t count = 0;
      ASSERT_EQ(
          tremolo_world_contact_points(world, body, 0, 0, points.data(), points.size(), &count),
          TREMOLO_OK);
      for (std::size_t i = 0; i < count; ++i) {
        sum += Eigen::Map<const Eigen::Vector3d>(points[i].impulse);
        EXPECT_GT(points[i].normal[2], 0.999);
      }
      EXPECT_LT((sum - kWorldStep * force).norm(), 1e-9 * (1e-3 + sum.norm()));
      for (std::size_t i = 0; i < tremolo_world_events(world); ++i) {
        tremolo_event event;
        ASSERT_EQ(tremolo_world_event(world, i, &event), TREMOLO_OK);
        EXPECT_EQ(event.body, body);
        EXPECT_EQ(event.other, 0U);
        EXPECT_EQ(event.collider, 0U);
        if (event.begins != 0) {
          EXPECT_FALSE(began);
          began = true;
          start = before;
          from = event.time - kWorldStep;
          EXPECT_GT(event.normal[2], 0.999);
          EXPECT_LT(std::abs(event.position[2]), 0.01);
        } else {
          ended = true;
          // The last step had no force.
          const Eigen::Vector3d change = before - start;
          const double weight = mass(kind) * kFall * (event.time - kWorldStep - from);
          EXPECT_NEAR(event.push[2], change.z() + weight, 1e-6 * std::abs(event.push[2]));
          EXPECT_GE(event.impulse, event.push[2]);
        }
      }
      before = momentum(world, body);
    }
    EXPECT_TRUE(began);
    if (kind != CubeKind::kCloth) {
      EXPECT_TRUE(ended);
    }
  }
}

// Contacts between two bodies of any kinds are events of both, with their ids.
TEST_F(WorldCApi, EventsNameBothBodies) {
  for (const CubeKind below : kSolids)
    for (const CubeKind above : kKinds) {
      SCOPED_TRACE(std::to_string(static_cast<int>(below)) +
                   std::to_string(static_cast<int>(above)));
      tremolo_world* world = make_world(true);
      const tremolo_body_id support = add(world, below, at("below", {0.0, 0.0, kHalfEdge}));
      const tremolo_body_id body = add(world, above, at("above", {0.0, 0.0, 3.2 * kHalfEdge}));
      advance(world, 80);
      int begins = 0;
      for (std::size_t i = 0; i < tremolo_world_events(world); ++i) {
        tremolo_event event;
        ASSERT_EQ(tremolo_world_event(world, i, &event), TREMOLO_OK);
        if (event.other == 0) continue;
        EXPECT_TRUE((event.body == support && event.other == body) ||
                    (event.body == body && event.other == support));
        if (event.begins == 0) continue;
        ++begins;
        const double up = event.body == body ? 1.0 : -1.0;
        EXPECT_GT(up * event.normal[2], 0.9);
        EXPECT_GT(up * event.push[2], 0.0);
        EXPECT_NEAR(event.position[2], 2.0 * kHalfEdge, 0.01);
      }
      EXPECT_GE(begins, 1);
      // The force on one body is the opposite of that on the other.
      std::array<tremolo_contact_point, 400> there, back;
      std::size_t n = 0, m = 0;
      ASSERT_EQ(
          tremolo_world_contact_points(world, body, support, 0, there.data(), there.size(), &n),
          TREMOLO_OK);
      ASSERT_EQ(tremolo_world_contact_points(world, support, body, 0, back.data(), back.size(), &m),
                TREMOLO_OK);
      EXPECT_EQ(n, m);
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (std::size_t i = 0; i < n; ++i)
        sum += Eigen::Map<Eigen::Vector3d>(there[i].impulse) +
               Eigen::Map<Eigen::Vector3d>(back[i].impulse);
      EXPECT_LT(sum.norm(), 1e-15);
    }
}

// A ray from above hits each kind; its site is there and moves as the body does.
TEST_F(WorldCApi, RaysHitSitesOfEachKind) {
  for (const CubeKind kind : kKinds) {
    SCOPED_TRACE(static_cast<int>(kind));
    tremolo_world* world = make_world(false);
    tremolo_scene_body place = at("one", {0.0, 0.0, 0.5});
    place.velocity[0] = 0.3;
    const tremolo_body_id body = add(world, kind, place);
    advance(world, 3);
    const double down[3] = {0.0, 0.0, -2.0};
    const double from[3] = {0.013, 0.007, 2.0}, beside[3] = {1.0, 0.0, 2.0};
    tremolo_site site;
    double distance = 0.0, point[3], position[3], velocity[3], later[3];
    ASSERT_EQ(tremolo_world_pick(world, from, down, &site, &distance, point), TREMOLO_OK);
    ASSERT_EQ(site.body, body);
    EXPECT_NEAR(site.weights[0] + site.weights[1] + site.weights[2], 1.0, 1e-12);
    const double top = 0.5 + (kind == CubeKind::kCloth ? 0.0 : kHalfEdge);
    EXPECT_NEAR(point[2], top, 2e-3);
    EXPECT_NEAR(distance, 2.0 - point[2], 1e-12);
    ASSERT_EQ(tremolo_world_site(world, &site, position, velocity), TREMOLO_OK);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(position[k], point[k], 1e-9);
    advance(world, 1);
    ASSERT_EQ(tremolo_world_site(world, &site, later, nullptr), TREMOLO_OK);
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR((later[k] - position[k]) / kWorldStep, velocity[k],
                  k == 2 ? 1.1 * kFall * kWorldStep : 2e-3);
    std::uint64_t hand = 0;
    ASSERT_EQ(tremolo_world_grab_site(world, &site, 50.0, 0.1, &hand), TREMOLO_OK)
        << tremolo_last_error();
    ASSERT_EQ(tremolo_world_let_go(world, body, hand), TREMOLO_OK);
    site.triangle = 100000;
    EXPECT_EQ(tremolo_world_site(world, &site, later, nullptr), TREMOLO_USAGE);
    ASSERT_EQ(tremolo_world_pick(world, beside, down, &site, nullptr, nullptr), TREMOLO_OK);
    EXPECT_EQ(site.body, 0U);
    const double none[3] = {0.0, 0.0, 0.0};
    EXPECT_EQ(tremolo_world_pick(world, from, none, &site, nullptr, nullptr), TREMOLO_USAGE);
  }
}

// A body that the filter lets pass falls through the other with the bits of a body alone.
TEST_F(WorldCApi, AFilterLetsBodiesPassThroughEachOther) {
  struct Asked {
    tremolo_world* world = nullptr;
    int count = 0;
    tremolo_status within = TREMOLO_OK;
  };
  for (const CubeKind below : kSolids)
    for (const CubeKind above : kKinds) {
      SCOPED_TRACE(std::to_string(static_cast<int>(below)) +
                   std::to_string(static_cast<int>(above)));
      tremolo_world *world = make_world(true), *alone = make_world(true);
      add(world, below, at("below", {0.0, 0.0, kHalfEdge}));
      const tremolo_body_id body = add(world, above, at("above", {0.0, 0.0, 3.2 * kHalfEdge}));
      const tremolo_body_id same = add(alone, above, at("above", {0.0, 0.0, 3.2 * kHalfEdge}));
      Asked asked{world};
      const tremolo_filter none = [](void* user, tremolo_body_id a,
                                     tremolo_body_id b) -> std::int32_t {
        auto& mine = *static_cast<Asked*>(user);
        ++mine.count;
        EXPECT_NE(a, b);
        mine.within = tremolo_world_step(mine.world, 1, nullptr);
        return 0;
      };
      ASSERT_EQ(tremolo_world_set_filter(world, none, &asked), TREMOLO_OK);
      advance(world, 60);
      advance(alone, 60);
      EXPECT_GT(asked.count, 0);
      EXPECT_EQ(asked.within, TREMOLO_USAGE) << "a callback does not step the world";
      EXPECT_TRUE(positions(world, body) == positions(alone, same));
    }
}

// Threads of the caller's change no bit.
TEST_F(WorldCApi, JobsOfTheCallerChangeNoBit) {
  constexpr std::uint32_t kWorkers = 3;
  const tremolo_run_jobs run = [](void* user, std::size_t count, tremolo_job job, void* data) {
    ++*static_cast<int*>(user);
    std::atomic<std::size_t> next{0};
    const auto work = [&](std::uint32_t worker) {
      for (std::size_t i = next++; i < count; i = next++) job(data, i, worker);
    };
    std::vector<std::thread> threads;
    for (std::uint32_t w = 1; w < kWorkers; ++w) threads.emplace_back(work, w);
    work(0);
    for (std::thread& thread : threads) thread.join();
  };
  int calls = 0;
  std::vector<std::vector<std::byte>> states;
  for (const int own : {0, 2, 1}) {
    tremolo_world* world = make_world(true, own == 2 ? 3 : 1);
    if (own == 1) {
      ASSERT_EQ(tremolo_world_set_jobs(world, kWorkers, run, &calls), TREMOLO_OK);
    }
    for (int k = 0; k < 6; ++k)
      add(world, k % 2 == 0 ? CubeKind::kRigid : CubeKind::kReduced,
          at(("n" + std::to_string(k)).c_str(), {0.3 * (k / 2), 0.0, k % 2 == 0 ? 0.06 : 0.17}));
    advance(world, 100);
    states.push_back(saved(world));
    EXPECT_EQ(tremolo_world_set_jobs(world, 0, run, nullptr), TREMOLO_USAGE);
  }
  EXPECT_GT(calls, 100);
  EXPECT_TRUE(states[0] == states[1]) << "the world's own threads";
  EXPECT_TRUE(states[0] == states[2]);
}

// A load that is the weight lets a body hover; half of a sine gives its integral.
TEST_F(WorldCApi, LoadsInTimeBeginWhenTheyAreGiven) {
  for (const CubeKind kind : {CubeKind::kReduced, CubeKind::kRigid}) {
    SCOPED_TRACE(static_cast<int>(kind));
    tremolo_world* world = make_world(false);
    const tremolo_body_id body = add(world, kind, at("one", {0.0, 0.0, 1.0}));
    const double m = mass(kind);
    tremolo_load load;
    tremolo_load_init(&load);
    load.at = "near:0,0,0.05";
    load.force[2] = m * kFall;
    ASSERT_EQ(tremolo_world_add_load(world, body, &load), TREMOLO_OK) << tremolo_last_error();
    load.force[2] = 0.0;
    load.force[0] = 2.0;
    load.signal = TREMOLO_SINE;
    load.frequency = 5.0;
    load.duration = 0.1;  // half a wave
    ASSERT_EQ(tremolo_world_add_load(world, body, &load), TREMOLO_OK);
    const double times[3] = {0.0, 0.05, 0.1}, values[3] = {0.0, 1.0, 0.0};
    load.force[0] = 0.0;
    load.force[1] = 3.0;
    load.signal = TREMOLO_TABLE;
    load.times = times;
    load.values = values;
    load.count = 3;
    ASSERT_EQ(tremolo_world_add_load(world, body, &load), TREMOLO_OK);
    advance(world, 100);
    const Eigen::Vector3d p = momentum(world, body);
    EXPECT_NEAR(p.x(), 2.0 * 2.0 / (2.0 * M_PI * 5.0), 1e-6);
    EXPECT_NEAR(p.y(), 3.0 * 0.05, 1e-6);
    EXPECT_NEAR(p.z(), 0.0, 1e-6);
    load.count = 1;
    EXPECT_EQ(tremolo_world_add_load(world, body, &load), TREMOLO_USAGE);
    load.signal = 9;
    EXPECT_EQ(tremolo_world_add_load(world, body, &load), TREMOLO_USAGE);
    tremolo_load_init(&load);
    load.at = "vertex:100000";
    EXPECT_EQ(tremolo_world_add_load(world, body, &load), TREMOLO_CONTENT);
  }
}

// A state fits a world in which the same came, went and moved, and no other.
TEST_F(WorldCApi, StatesOfWorldsThatChangedAreRestoredToTheBit) {
  const double turn[4] = {1.0, 0.0, 0.0, 0.0};
  const auto change = [&](tremolo_world* world) {
    advance(world, 3);
    const tremolo_body_id gone = add(world, CubeKind::kTets, at("gone", {1.0, 0.0, 0.3}));
    const tremolo_body_id also = add(world, CubeKind::kRigid, at("also", {2.0, 0.0, 0.3}));
    add(world, CubeKind::kCloth, at("sheet", {0.0, 0.0, 0.13}));
    add(world, CubeKind::kReduced, at("soft", {0.0, 0.0, kHalfEdge}));
    advance(world, 20);
    EXPECT_EQ(tremolo_world_remove(world, gone), TREMOLO_OK);
    EXPECT_EQ(tremolo_world_remove(world, also), TREMOLO_OK);
    tremolo_joint joint;
    tremolo_joint_init(&joint);
    joint.body = "sheet";
    joint.at = "top-left";
    joint.stiffness = 1.0;
    std::uint32_t number = 0;
    EXPECT_EQ(tremolo_world_add_joint(world, &joint, &number), TREMOLO_OK);
    advance(world, 2);
    add(world, CubeKind::kTets, at("cube", {0.5, 0.0, kHalfEdge}));
  };
  double place[3] = {0.0, 0.0, 0.0};
  const auto run = [&](tremolo_world* world, int from) {
    for (int k = from; k < from + 20; ++k) {
      place[0] = 0.001 * k;
      ASSERT_EQ(tremolo_world_move_collider(world, 0, place, turn), TREMOLO_OK);
      advance(world, 1);
    }
  };
  tremolo_world *world = make_world(true), *other = make_world(true);
  change(world);
  run(world, 0);
  const std::vector<std::byte> bytes = saved(world);
  run(world, 20);
  change(other);
  EXPECT_EQ(tremolo_world_restore(other, bytes.data(), bytes.size()), TREMOLO_CONTENT)
      << "its collider was not moved";
  ASSERT_EQ(tremolo_world_move_collider(other, 0, place, turn), TREMOLO_OK);
  ASSERT_EQ(tremolo_world_restore(other, bytes.data(), bytes.size()), TREMOLO_OK)
      << tremolo_last_error();
  run(other, 20);
  EXPECT_TRUE(saved(world) == saved(other));
  ASSERT_EQ(tremolo_world_restore(world, bytes.data(), bytes.size()), TREMOLO_OK);
  run(world, 20);
  EXPECT_TRUE(saved(world) == saved(other));
  tremolo_world* bare = make_world(true);
  EXPECT_EQ(tremolo_world_restore(bare, bytes.data(), bytes.size()), TREMOLO_CONTENT);
}

// A driven body that calls move pushes a ball to its own speed and gives the work.
TEST_F(WorldCApi, ADrivenBodyIsMovedByCalls) {
  tremolo_world* world = make_world(true);
  tremolo_scene_body place = at("paddle", {-0.3, 0.0, kHalfEdge + 0.02});
  tremolo_body_options method;
  tremolo_body_options_init(&method);
  method.frame = TREMOLO_DRIVEN;
  method.beta = 0.002;
  tremolo_body_id paddle = 0;
  tremolo_model* held = nullptr;
  ASSERT_EQ(tremolo_model_load(path("held.tremolo").c_str(), 0, &held), TREMOLO_OK);
  EXPECT_EQ(tremolo_world_add_reduced(world, &place, held, &method, box_, &paddle), TREMOLO_OK)
      << tremolo_last_error();
  tremolo_model_release(held);
  tremolo_scene_body puck_place = at("puck", {0.0, 0.0, kHalfEdge});
  puck_place.friction = 0.0;
  tremolo_body_id puck = 0;
  ASSERT_EQ(tremolo_world_add_rigid(world, &puck_place, box_, 1.0, &puck), TREMOLO_OK);
  const double turn[4] = {1.0, 0.0, 0.0, 0.0};
  double x[3] = {-0.3, 0.0, kHalfEdge + 0.02};
  for (int k = 0; k < 400; ++k) {
    const double t = (k + 1) * kWorldStep;
    x[0] = -0.3 + (t < 0.2 ? 2.5 * t * t : 0.1 + (t - 0.2));  // to 1 m/s
    ASSERT_EQ(tremolo_world_move(world, paddle, x, turn), TREMOLO_OK) << tremolo_last_error();
    advance(world, 1);
  }
  EXPECT_GT(momentum(world, puck).x(), 0.95);
  double pose[3];
  ASSERT_EQ(tremolo_world_pose(world, paddle, pose, nullptr), TREMOLO_OK);
  EXPECT_NEAR(pose[0], x[0], 1e-12);
  EXPECT_EQ(tremolo_world_move(world, puck, x, turn), TREMOLO_USAGE) << "it is free";
  tremolo_energy_account account;
  ASSERT_EQ(tremolo_world_account(world, puck, &account), TREMOLO_OK);
  EXPECT_LT(std::abs(account.remainder), 1e-9);
}

// The surface is rest + basis c in the body's frame.
TEST_F(WorldCApi, BasisRowsPlaceTheSurface) {
  tremolo_world* world = make_world(true);
  tremolo_scene_body place = at("one", {0.0, 0.0, 0.08});
  place.spin[1] = 3.0;
  const tremolo_body_id body = add(world, CubeKind::kReduced, place);
  advance(world, 60);
  const std::size_t s = tremolo_model_surface_vertices(model_), n = tremolo_model_columns(model_);
  std::vector<float> rest(3 * s), basis(3 * s * n);
  std::vector<double> c(n);
  ASSERT_EQ(tremolo_model_rest(model_, rest.data(), rest.size()), TREMOLO_OK);
  ASSERT_EQ(tremolo_model_basis(model_, basis.data(), basis.size()), TREMOLO_OK);
  ASSERT_EQ(tremolo_world_coordinates(world, body, c.data(), c.size()), TREMOLO_OK);
  Eigen::Vector3d x;
  Eigen::Vector4d q;
  ASSERT_EQ(tremolo_world_pose(world, body, x.data(), q.data()), TREMOLO_OK);
  const Eigen::Quaterniond turn(q[0], q[1], q[2], q[3]);
  const std::vector<double> places = positions(world, body);
  double moved = 0.0;
  for (std::size_t i = 0; i < s; ++i) {
    Eigen::Vector3d y = Eigen::Map<Eigen::Vector3f>(rest.data() + 3 * i).cast<double>();
    const Eigen::Vector3d before = y;
    for (std::size_t k = 0; k < n; ++k)
      y += c[k] * Eigen::Map<Eigen::Vector3f>(basis.data() + 3 * (i * n + k)).cast<double>();
    moved = std::max(moved, (y - before).norm());
    EXPECT_LT((x + turn * y - Eigen::Map<const Eigen::Vector3d>(places.data() + 3 * i)).norm(),
              1e-6);
  }
  EXPECT_GT(moved, 1e-4);
}

TEST_F(WorldCApi, TheLogHearsFailuresAndWarnings) {
  std::vector<std::pair<tremolo_log_level, std::string>> heard;
  tremolo_set_log(
      [](void* user, tremolo_log_level level, const char* message) {
        static_cast<decltype(heard)*>(user)->emplace_back(level, message);
      },
      &heard);
  tremolo_world* world = make_world(false);
  const tremolo_body_id body = add(world, CubeKind::kTets, at("one", {0.0, 0.0, 1.0}));
  EXPECT_EQ(tremolo_world_remove(world, 12345), TREMOLO_USAGE);
  ASSERT_EQ(heard.size(), 1U);
  EXPECT_EQ(heard[0].first, TREMOLO_LOG_ERROR);
  EXPECT_EQ(heard[0].second, tremolo_last_error());
  std::uint64_t hand = 0;
  ASSERT_EQ(tremolo_world_grab(world, body, 0, 1e12, 0.0, &hand), TREMOLO_OK);
  ASSERT_EQ(heard.size(), 2U);
  EXPECT_EQ(heard[1].first, TREMOLO_LOG_WARNING);
  EXPECT_NE(heard[1].second.find("as stiff as mass and step allow"), std::string::npos);
}

TEST_F(WorldCApi, TheHeadersVersionIsTheLibrarys) {
  EXPECT_EQ(std::to_string(TREMOLO_VERSION_MAJOR) + "." + std::to_string(TREMOLO_VERSION_MINOR) +
                "." + std::to_string(TREMOLO_VERSION_PATCH),
            tremolo_version());
}

// A floor that is elsewhere at once wakes what slept on it, which falls there.
TEST_F(WorldCApi, WhatSleepsOnAColliderThatJumpsWakes) {
  tremolo_scene* scene = nullptr;
  ASSERT_EQ(tremolo_scene_parse(R"(
step = 0.002
gravity = [0, 0, -9.81]
[[bodies]]
name = "box"
kind = "rigid"
shape = "box"
half-extents = [0.05, 0.05, 0.05]
mass = 1
position = [0, 0, 0.05]
[[colliders]]
name = "floor"
shape = "plane"
[[colliders.motion]]
kind = "keyframes"
interpolation = "linear"
jumps = "teleport"
keys = [[0, 0, 0, 0], [1.5, 0, 0, 0], [1.5, 0, 0, -0.03], [3, 0, 0, -0.03]]
)",
                                path("jump.toml").c_str(), &scene),
            TREMOLO_OK)
      << tremolo_last_error();
  tremolo_world* world = of(scene);
  const tremolo_body_id box = tremolo_world_body(world, 0);
  std::int32_t asleep = 0;
  advance(world, 745);
  ASSERT_EQ(tremolo_world_look(world, box, &asleep, nullptr), TREMOLO_OK);
  EXPECT_EQ(asleep, 1);
  advance(world, 400);
  EXPECT_NEAR(middle(world, box).z(), 0.02, 1e-3);
}

// In C++ an exception of the filter ends the call after the step.
TEST_F(WorldCApi, AFilterThatThrowsIsAnError) {
  WorldScene scene;
  scene.scene.step = kWorldStep;
  for (const double height : {0.06, 0.17}) {
    SceneBody body;
    body.name = height < 0.1 ? "low" : "high";
    body.kind = FrameKind::kFree;
    body.rigid.emplace();
    body.rigid->shape = BoxShape{Eigen::Vector3d::Constant(kHalfEdge)};
    body.rigid->mass = 1.0;
    body.pose.position.z() = height;
    scene.scene.bodies.push_back(body);
  }
  Result<std::unique_ptr<World>> world = World::create(scene);
  ASSERT_TRUE(world) << world.error().message;
  (*world)->set_filter([](WorldBody, WorldBody) -> bool { throw std::runtime_error("no"); });
  std::int64_t done = 0;
  const Status made = (*world)->step(3, &done);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().message, "the filter threw: no");
  EXPECT_EQ(done, 1);
  EXPECT_EQ((*world)->steps(), 1);
  EXPECT_FALSE((*world)->is_stepping());
  (*world)->set_filter({});
  EXPECT_TRUE((*world)->step(3));
}

}  // namespace
}  // namespace tremolo
