// runtime/tremolo_scene.h: events, rays, filters, jobs, loads and states of worlds from C.
#include <atomic>
#include <cmath>
#include <stdexcept>
#include <thread>
#include <utility>

#include "runtime/world/world.h"
#include "tests/mixed/world_c_api.h"

namespace tremolo {
namespace {

// A suite of its own: each source file has its own class of the fixture.
class WorldCApiLook : public WorldCApi {};

// All that contact pushed between the begin and the end of a contact is the change of momentum and
// the weight; the points of a step add up to its force.
TEST_F(WorldCApiLook, EventsHaveTheImpulseOfTheContact) {
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
    Eigen::Vector3d start = Eigen::Vector3d::Zero(), before = momentum(world, body);
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
TEST_F(WorldCApiLook, EventsNameBothBodies) {
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

// Also of a point that has left by the end of the step.
TEST_F(WorldCApiLook, PointsOfTwoBodiesAddUpToTheirImpulse) {
  for (const CubeKind below : kKinds)
    for (const CubeKind above : kKinds) {
      if (below == CubeKind::kCloth && above == CubeKind::kCloth) continue;  // they do not meet
      SCOPED_TRACE(std::to_string(static_cast<int>(below)) +
                   std::to_string(static_cast<int>(above)));
      tremolo_world* world = make_world(false);
      const tremolo_body_id other = add(world, below, at("below", {0.0, 0.0, 1.0}));
      tremolo_scene_body place = at("above", {0.0, 0.0, 1.0 + 2.2 * kHalfEdge});
      place.velocity[2] = -1.0;
      const tremolo_body_id body = add(world, above, place);
      const Eigen::Vector3d start = momentum(world, body);
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      constexpr int kSteps = 60;
      for (int k = 0; k < kSteps; ++k) {
        advance(world, 1);
        std::array<tremolo_contact_point, 400> points;
        std::size_t count = 0;
        ASSERT_EQ(tremolo_world_contact_points(world, body, other, 0, points.data(), points.size(),
                                               &count),
                  TREMOLO_OK);
        for (std::size_t i = 0; i < count; ++i)
          sum += Eigen::Map<const Eigen::Vector3d>(points[i].impulse);
      }
      Eigen::Vector3d change = momentum(world, body) - start;
      change.z() += mass(above) * kFall * kSteps * kWorldStep;
      EXPECT_GT(sum.z(), 0.02 * mass(above));
      EXPECT_LT((sum - change).norm(), 1e-6 * sum.norm());
    }
}

// A ray from above hits each kind; its site is there and moves as the body does.
TEST_F(WorldCApiLook, RaysHitSitesOfEachKind) {
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
TEST_F(WorldCApiLook, AFilterLetsBodiesPassThroughEachOther) {
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
TEST_F(WorldCApiLook, JobsOfTheCallerChangeNoBit) {
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
TEST_F(WorldCApiLook, LoadsInTimeBeginWhenTheyAreGiven) {
  for (const CubeKind kind : kKinds) {
    SCOPED_TRACE(static_cast<int>(kind));
    tremolo_world* world = make_world(false);
    const tremolo_body_id body = add(world, kind, at("one", {0.0, 0.0, 1.0}));
    const double m = mass(kind);
    tremolo_load load;
    tremolo_load_init(&load);
    // A place on a cloth is in the world.
    load.at = kind == CubeKind::kCloth ? "x>-9" : "near:0,0,0.05";
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
TEST_F(WorldCApiLook, StatesOfWorldsThatChangedAreRestoredToTheBit) {
  const double turn[4] = {1.0, 0.0, 0.0, 0.0};
  const auto change = [&](tremolo_world* world) {
    advance(world, 3);
    const tremolo_body_id gone = add(world, CubeKind::kSoft, at("gone", {1.0, 0.0, 0.3}));
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
    const tremolo_body_id cube = add(world, CubeKind::kSoft, at("cube", {0.5, 0.0, kHalfEdge}));
    tremolo_load load;
    tremolo_load_init(&load);
    load.at = "z>99%";
    load.force[0] = 0.5;
    load.signal = TREMOLO_SINE;
    load.frequency = 9.0;
    EXPECT_EQ(tremolo_world_add_load(world, cube, &load), TREMOLO_OK) << tremolo_last_error();
    tremolo_body_id sheet = 0;
    EXPECT_EQ(tremolo_world_find(world, "sheet", &sheet), TREMOLO_OK);
    load.at = "right";
    load.signal = TREMOLO_PULSE;
    load.duration = 0.06;
    EXPECT_EQ(tremolo_world_add_load(world, sheet, &load), TREMOLO_OK) << tremolo_last_error();
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
  // A force that still acts when the world is saved.
  tremolo_body_id pushed = 0;
  ASSERT_EQ(tremolo_world_find(world, "cube", &pushed), TREMOLO_OK);
  const double force[3] = {0.0, 0.3, 0.0};
  ASSERT_EQ(tremolo_world_apply_force(world, pushed, 0, force, 30), TREMOLO_OK);
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
TEST_F(WorldCApiLook, ADrivenBodyIsMovedByCalls) {
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
TEST_F(WorldCApiLook, BasisRowsPlaceTheSurface) {
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

TEST_F(WorldCApiLook, TheLogHearsFailuresAndWarnings) {
  std::vector<std::pair<tremolo_log_level, std::string>> heard;
  tremolo_set_log(
      [](void* user, tremolo_log_level level, const char* message) {
        static_cast<decltype(heard)*>(user)->emplace_back(level, message);
      },
      &heard);
  tremolo_world* world = make_world(false);
  const tremolo_body_id body = add(world, CubeKind::kSoft, at("one", {0.0, 0.0, 1.0}));
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

TEST_F(WorldCApiLook, TheHeadersVersionIsTheLibrarys) {
  EXPECT_EQ(std::to_string(TREMOLO_VERSION_MAJOR) + "." + std::to_string(TREMOLO_VERSION_MINOR) +
                "." + std::to_string(TREMOLO_VERSION_PATCH),
            tremolo_version());
}

// A floor that is elsewhere at once wakes what slept on it, which falls there.
TEST_F(WorldCApiLook, WhatSleepsOnAColliderThatJumpsWakes) {
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
TEST_F(WorldCApiLook, AFilterThatThrowsIsAnError) {
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
