// runtime/tremolo_scene.h: calls that are refused change nothing; callbacks that break the rules
// cost an error, not the world; hands in worlds without contact.
#include <atomic>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <thread>
#include <utility>

#include "tests/mixed/world_c_api.h"

namespace tremolo {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

// A suite of its own: each source file has its own class of the fixture.
class WorldCApiRefusals : public WorldCApi {
 protected:
  // The status of adding a body, which may be refused.
  tremolo_status try_add(tremolo_world* world, CubeKind kind, const tremolo_scene_body& place) {
    tremolo_body_id body = 0;
    return add(
        kind, place,
        [&](const auto& p, const auto& m) {
          return tremolo_world_add_reduced(world, &p, model_, &m, box_, &body);
        },
        [&](const auto& p) { return tremolo_world_add_rigid(world, &p, box_, 1.0, &body); },
        [&](const auto& p, const auto& o) { return tremolo_world_add_tets(world, &p, &o, &body); },
        [&](const auto& p, const auto& o) {
          return tremolo_world_add_cloth(world, &p, "implicit-euler", &o, nullptr, 0, &body);
        });
  }
  static tremolo_status try_join(tremolo_world* world, const char* to, const char* at,
                                 const double* point = nullptr) {
    tremolo_joint joint;
    tremolo_joint_init(&joint);
    joint.body = "far";
    joint.at = at;
    joint.to = to;
    joint.point = point;
    if (to != nullptr) joint.to_at = "999999";
    std::uint32_t number = 0;
    return tremolo_world_add_joint(world, &joint, &number);
  }
  // A collider around the body "far".
  tremolo_status try_surround(tremolo_world* world) {
    tremolo_placed_collider around;
    tremolo_placed_collider_init(&around, box_);
    around.position[0] = 50.02;
    around.position[2] = 500.01;
    std::uint32_t number = 0;
    return tremolo_world_add_collider(world, &around, &number);
  }
  // A world with one body alone.
  tremolo_world* world_of_one(CubeKind kind) {
    tremolo_scene* scene = nullptr;
    EXPECT_EQ(tremolo_scene_create(kWorldStep, &scene), TREMOLO_OK);
    add(scene, kind, at("one", {0.0, 0.0, 1.0}));
    return of(scene);
  }
  static tremolo_body_id first(const tremolo_world* world) { return tremolo_world_body(world, 0); }
  static bool error_has(const std::string& words) {
    return std::string(tremolo_last_error()).find(words) != std::string::npos;
  }
};

TEST_F(WorldCApiRefusals, AChangeThatIsRefusedLeavesTheWorldAsItWas) {
  for (const bool with_floor : {false, true})
    for (const bool with_guest : {false, true})
      for (const bool with_gap : {false, true}) {
        SCOPED_TRACE(::testing::Message() << with_floor << with_guest << with_gap);
        std::array<tremolo_world*, 2> worlds{};
        for (tremolo_world*& world : worlds) {
          world = make_world(with_floor);
          if (with_guest) add(world, CubeKind::kSoft, at("guest", {9.0, 0.0, 5.0}));
          // Numbers of bodies that were removed are used again.
          std::vector<tremolo_body_id> gone;
          if (with_gap) gone.push_back(add(world, CubeKind::kRigid, at("gap", {7.0, 0.0, 5.0})));
          if (with_gap && with_guest)
            gone.push_back(add(world, CubeKind::kSoft, at("other gap", {5.0, 0.0, 5.0})));
          for (const tremolo_body_id body : gone)
            ASSERT_EQ(tremolo_world_remove(world, body), TREMOLO_OK);
          advance(world, 1);
        }
        tremolo_world* world = worlds[0];
        const std::vector<std::byte> before = saved(world);
        const auto unchanged = [&](const char* what) {
          EXPECT_TRUE(saved(world) == before) << what;
          EXPECT_EQ(tremolo_world_restore(world, before.data(), before.size()), TREMOLO_OK)
              << what << ": " << tremolo_last_error();
        };
        for (const CubeKind kind : kKinds) {
          EXPECT_EQ(try_add(world, kind, at("deep", {50.03, 0.02, 500.01})), TREMOLO_CONTENT)
              << static_cast<int>(kind);
          unchanged("inside a body");
          if (!with_floor) continue;
          EXPECT_EQ(try_add(world, kind, at("deep", {0.0, 0.0, -0.2})), TREMOLO_CONTENT);
          unchanged("inside the floor");
        }
        EXPECT_EQ(try_join(world, nullptr, "999999"), TREMOLO_CONTENT);
        unchanged("a joint to the world");
        if (with_guest) {
          EXPECT_EQ(try_join(world, "guest", "0"), TREMOLO_CONTENT);
          unchanged("a joint to a guest");
        }
        EXPECT_EQ(try_surround(world), TREMOLO_CONTENT) << tremolo_last_error();
        unchanged("a collider");
        // What is added afterwards has the numbers that it would have had.
        for (tremolo_world* one : worlds) {
          for (const CubeKind kind : kKinds)
            add(one, kind,
                at(std::to_string(static_cast<int>(kind)).c_str(),
                   {2.0 + 0.5 * static_cast<double>(kind), 3.0, 0.06}));
          advance(one, 40);
        }
        EXPECT_TRUE(saved(worlds[0]) == saved(worlds[1]));
      }
}

// The contact points of a mesh are not those of a mesh whose body was removed.
TEST_F(WorldCApiRefusals, TetrahedraAfterARemovedBodyOfAnotherMeshHaveTheirOwnPoints) {
  TetMesh mesh = box_mesh({4, 4, 3}, {2 * kHalfEdge, 2 * kHalfEdge, 2 * kHalfEdge});
  write_veg(folder_ + "/fine.veg", mesh);
  const ProgramResult made = run_program(
      folder_, kPrecompute +
                   "tets fine.veg --young 2e5 --poisson 0.3 --density 1000 --fix none -o "
                   "fine.tets");
  ASSERT_EQ(made.code, 0) << made.err;
  const auto add_tets = [this](tremolo_world* world, const char* file) {
    tremolo_tets_options options;
    tremolo_tets_options_init(&options);
    const std::string name = path(file);
    options.file = name.c_str();
    options.method = "midpoint";
    const tremolo_scene_body place = at("block", {0.0, 0.0, 0.06});
    tremolo_body_id body = 0;
    EXPECT_EQ(tremolo_world_add_tets(world, &place, &options, &body), TREMOLO_OK)
        << tremolo_last_error();
    return body;
  };
  tremolo_world* other = make_world(true);
  advance(other, 2);
  const tremolo_body_id same = add_tets(other, "fine.tets");
  advance(other, 40);
  // The memory of the model that is removed is that of the next one in some of them.
  for (int k = 0; k < 8; ++k) {
    tremolo_world* world = make_world(true);
    const tremolo_body_id coarse = add_tets(world, "cube.tets");
    advance(world, 1);
    ASSERT_EQ(tremolo_world_remove(world, coarse), TREMOLO_OK);
    advance(world, 1);
    const tremolo_body_id body = add_tets(world, "fine.tets");
    ASSERT_NE(body, 0U);
    advance(world, 40);
    EXPECT_TRUE(positions(world, body) == positions(other, same));
  }
}

TEST_F(WorldCApiRefusals, ValuesThatAreNotFiniteAreRefusedForEachKind) {
  tremolo_world* world = make_world(true);
  for (const CubeKind kind : kKinds) {
    SCOPED_TRACE(static_cast<int>(kind));
    const tremolo_body_id body = add(
        world, kind,
        at(std::to_string(static_cast<int>(kind)).c_str(), {static_cast<double>(kind), 0.0, 2.0}));
    const std::vector<std::byte> before = saved(world);
    for (const double value : {kNan, kInfinite, -kInfinite}) {
      tremolo_scene_body place = at("new", {0.0, 0.0, 9.0});
      place.velocity[1] = value;
      EXPECT_EQ(try_add(world, kind, place), TREMOLO_USAGE);
      EXPECT_TRUE(error_has("body 'new': its velocity is not finite")) << tremolo_last_error();
      place = at("new", {0.0, 0.0, 9.0});
      place.spin[2] = value;
      EXPECT_EQ(try_add(world, kind, place), TREMOLO_USAGE);
      std::uint64_t hand = 0;
      EXPECT_EQ(tremolo_world_grab(world, body, 0, value, 1.0, &hand), TREMOLO_USAGE);
      EXPECT_EQ(tremolo_world_grab(world, body, 0, 1.0, value, &hand), TREMOLO_USAGE);
      const tremolo_site site{body, 0, 0, {1.0, 0.0, 0.0}};
      EXPECT_EQ(tremolo_world_grab_site(world, &site, value, 1.0, &hand), TREMOLO_USAGE);
      EXPECT_EQ(tremolo_world_grab_site(world, &site, 1.0, value, &hand), TREMOLO_USAGE);
    }
    EXPECT_TRUE(saved(world) == before);
  }
  const std::vector<std::byte> before = saved(world);
  for (const double value : {kNan, kInfinite, -kInfinite}) {
    const double point[3] = {50.0, value, 500.0};
    EXPECT_EQ(try_join(world, nullptr, "0", point), TREMOLO_USAGE);
    EXPECT_TRUE(error_has("body 'far': its point is not finite")) << tremolo_last_error();
  }
  EXPECT_TRUE(saved(world) == before);
}

// The square of a force is its energy: where that overflows, the step could not be solved.
TEST_F(WorldCApiRefusals, AForceThatOverflowsIsRefusedForEachKind) {
  for (const CubeKind kind : kKinds) {
    SCOPED_TRACE(static_cast<int>(kind));
    tremolo_world* world = world_of_one(kind);
    const std::vector<std::byte> before = saved(world);
    for (const double value : {1e308, -1e160}) {
      const double force[3] = {0.0, value, 0.0};
      EXPECT_EQ(tremolo_world_apply_force(world, first(world), 0, force, 1), TREMOLO_USAGE);
      EXPECT_TRUE(error_has("overflow")) << tremolo_last_error();
      tremolo_load load;
      tremolo_load_init(&load);
      load.at = "0";
      load.force[1] = value;
      EXPECT_EQ(tremolo_world_add_load(world, first(world), &load), TREMOLO_USAGE);
      EXPECT_TRUE(error_has("overflow")) << tremolo_last_error();
    }
    EXPECT_TRUE(saved(world) == before);
    advance(world, 2);
  }
  // Small masses overflow before the force does.
  for (const CubeKind kind : {CubeKind::kSoft, CubeKind::kCloth}) {
    tremolo_world* world = world_of_one(kind);
    const double force[3] = {0.0, 1e153, 0.0};
    EXPECT_EQ(tremolo_world_apply_force(world, first(world), 0, force, 1), TREMOLO_USAGE);
    EXPECT_TRUE(error_has("overflow")) << tremolo_last_error();
  }
}

// Finite numbers whose squares or products, as in energies and momenta, are not.
TEST_F(WorldCApiRefusals, ValuesThatOverflowAreRefusedForEachKind) {
  const auto refused = [this](tremolo_world* world, const std::vector<std::byte>& before,
                              tremolo_status status, const char* words) {
    EXPECT_TRUE(status == TREMOLO_USAGE || status == TREMOLO_CONTENT) << status;
    EXPECT_TRUE(error_has("overflow") && error_has(words)) << words << ": " << tremolo_last_error();
    EXPECT_TRUE(saved(world) == before) << words;
  };
  for (const CubeKind kind : kKinds) {
    SCOPED_TRACE(static_cast<int>(kind));
    tremolo_world* world = make_world(true);
    const tremolo_body_id body = add(world, kind, at("there", {0.0, 0.0, 2.0}));
    const std::vector<std::byte> before = saved(world);
    for (const double value : {1e308, -1e155}) {
      tremolo_scene_body place = at("new", {0.0, 0.0, 9.0});
      place.velocity[1] = value;
      refused(world, before, try_add(world, kind, place), "body 'new': its velocity");
      place = at("new", {0.0, 0.0, 9.0});
      place.spin[2] = value;
      refused(world, before, try_add(world, kind, place), "body 'new': its spin");
      place = at("new", {0.0, 0.0, 9.0});
      place.position[0] = value;
      refused(world, before, try_add(world, kind, place), "body 'new': its position");
      if (value < 0.0) continue;
      place = at("new", {0.0, 0.0, 9.0});
      place.stiffness = value;
      refused(world, before, try_add(world, kind, place), "contact-stiffness");
      place = at("new", {0.0, 0.0, 9.0});
      place.modulus = value;
      refused(world, before, try_add(world, kind, place), "contact-modulus");
      tremolo_load load;
      tremolo_load_init(&load);
      load.at = "0";
      load.force[1] = 1.0;
      load.signal = TREMOLO_SINE;
      load.frequency = value;
      refused(world, before, tremolo_world_add_load(world, body, &load), "frequency");
    }
    // A hand that is stiffer than a pin is one.
    std::uint64_t hand = 0;
    EXPECT_EQ(tremolo_world_grab(world, body, 0, 1e308, 1e308, &hand), TREMOLO_OK)
        << tremolo_last_error();
    advance(world, 2);
  }
}

TEST_F(WorldCApiRefusals, OptionsThatOverflowAreRefused) {
  tremolo_world* world = make_world(true);
  const std::vector<std::byte> before = saved(world);
  const auto refused = [&](tremolo_status status, const char* words) {
    EXPECT_TRUE(status == TREMOLO_USAGE || status == TREMOLO_CONTENT) << words << status;
    EXPECT_TRUE(error_has("overflow") && error_has("'new'") && error_has(words))
        << words << ": " << tremolo_last_error();
    EXPECT_TRUE(saved(world) == before) << words;
  };
  const tremolo_scene_body place = at("new", {0.0, 0.0, 9.0});
  tremolo_body_id body = 0;
  for (const double value : {1e308, 1e155}) {
    refused(tremolo_world_add_rigid(world, &place, box_, value, &body), "mass");
    for (double tremolo_body_options::*damping :
         {&tremolo_body_options::alpha, &tremolo_body_options::beta}) {
      tremolo_body_options method;
      tremolo_body_options_init(&method);
      method.frame = TREMOLO_FREE;
      method.*damping = value;
      refused(tremolo_world_add_reduced(world, &place, model_, &method, box_, &body), "damping");
    }
    for (const auto& [field, word] : {std::pair{&tremolo_tets_options::alpha, "alpha"},
                                      std::pair{&tremolo_tets_options::beta, "beta"},
                                      std::pair{&tremolo_tets_options::drag, "drag"}}) {
      tremolo_tets_options options;
      tremolo_tets_options_init(&options);
      const std::string file = path("cube.tets");
      options.file = file.c_str();
      options.*field = value;
      refused(tremolo_world_add_tets(world, &place, &options, &body), word);
    }
    for (const char* word : {"width", "height", "corner", "density", "structural: stiffness",
                             "bend: damping", "drag", "thickness"}) {
      tremolo_cloth_options sheet;
      tremolo_cloth_options_init(&sheet);
      sheet.columns = sheet.rows = 5;
      const std::string what = word;
      if (what == "width") sheet.width = value;
      if (what == "height") sheet.height = value;
      if (what == "corner") sheet.corner[1] = value;
      if (what == "density") sheet.density = value;
      if (what == "structural: stiffness") sheet.stiffness[0] = value;
      if (what == "bend: damping") sheet.damping[2] = value;
      if (what == "drag") sheet.drag = value;
      if (what == "thickness") sheet.thickness = value;
      refused(tremolo_world_add_cloth(world, &place, nullptr, &sheet, nullptr, 0, &body), word);
    }
  }
  // Products: kinetic energy, inertia.
  tremolo_scene_body fast = place;
  fast.velocity[0] = 1e120;
  refused(tremolo_world_add_rigid(world, &fast, box_, 1e100, &body), "kinetic energy");
  tremolo_scene_body far = place;
  far.position[0] = 1e120;
  refused(tremolo_world_add_rigid(world, &far, box_, 1e100, &body), "inertia");
  // Joints and colliders.
  for (const auto& field : {&tremolo_joint::length, &tremolo_joint::gap}) {
    tremolo_joint joint;
    tremolo_joint_init(&joint);
    joint.body = "far";
    joint.at = "0";
    const double point[3] = {50.0, 0.0, 500.0};
    if (field == &tremolo_joint::length) joint.point = point;
    joint.*field = 1e308;
    joint.weld = field == &tremolo_joint::gap;
    std::uint32_t number = 0;
    EXPECT_EQ(tremolo_world_add_joint(world, &joint, &number), TREMOLO_USAGE);
    EXPECT_TRUE(error_has("overflow") && error_has("'far'")) << tremolo_last_error();
  }
  const double point[3] = {50.0, 1e308, 500.0}, turn[4] = {1.0, 0.0, 0.0, 0.0};
  EXPECT_EQ(try_join(world, nullptr, "0", point), TREMOLO_CONTENT);
  EXPECT_TRUE(error_has("overflow") && error_has("point")) << tremolo_last_error();
  tremolo_placed_collider collider = floor_;
  collider.position[2] = -1e308;
  std::uint32_t number = 0;
  EXPECT_EQ(tremolo_world_add_collider(world, &collider, &number), TREMOLO_CONTENT);
  EXPECT_TRUE(error_has("overflow") && error_has("collider 2")) << tremolo_last_error();
  EXPECT_EQ(tremolo_world_move_collider(world, 0, point, turn), TREMOLO_USAGE);
  EXPECT_TRUE(error_has("overflow") && error_has("collider 1")) << tremolo_last_error();
  EXPECT_TRUE(saved(world) == before);
  advance(world, 2);
  // The world itself.
  for (const double step : {1e308, 1e-200}) {
    tremolo_scene* scene = nullptr;
    ASSERT_EQ(tremolo_scene_create(step, &scene), TREMOLO_OK);
    add(scene, CubeKind::kRigid, at("one", {0.0, 0.0, 1.0}));
    tremolo_world* made = nullptr;
    EXPECT_EQ(tremolo_world_create(scene, 1, &made), TREMOLO_CONTENT) << step;
    tremolo_scene_destroy(scene);
  }
  for (const bool wind : {false, true}) {
    tremolo_scene* scene = nullptr;
    ASSERT_EQ(tremolo_scene_create(kWorldStep, &scene), TREMOLO_OK);
    add(scene, CubeKind::kCloth, at("one", {0.0, 0.0, 1.0}));
    const double value[3] = {0.0, 1e200, 0.0};
    EXPECT_EQ(wind ? tremolo_scene_set_wind(scene, value) : tremolo_scene_set_gravity(scene, value),
              TREMOLO_OK);
    tremolo_world* made = nullptr;
    EXPECT_EQ(tremolo_world_create(scene, 1, &made), TREMOLO_CONTENT);
    EXPECT_TRUE(error_has("overflow") && error_has(wind ? "wind" : "gravity"))
        << tremolo_last_error();
    tremolo_scene_destroy(scene);
  }
}

// A body that nothing can touch is held by a hand, whose force is all that its weight lacks.
TEST_F(WorldCApiRefusals, AHandHoldsABodyOfEachKindInAWorldWithoutContact) {
  for (const CubeKind kind : kKinds) {
    SCOPED_TRACE(static_cast<int>(kind));
    const double weight = mass(kind) * kFall;
    tremolo_world* world = world_of_one(kind);
    const tremolo_body_id body = first(world);
    advance(world, 3);
    const std::vector<std::byte> before = saved(world);
    std::uint64_t hand = 0;
    EXPECT_NE(tremolo_world_grab(world, body, 999999, 300.0, 3.0, &hand), TREMOLO_OK);
    EXPECT_TRUE(saved(world) == before) << "a hand that is refused changes nothing";
    ASSERT_EQ(tremolo_world_grab(world, body, 0, 300.0, 3.0, &hand), TREMOLO_OK)
        << tremolo_last_error();
    Eigen::Vector3d p = momentum(world, body);
    for (int k = 0; k < 50; ++k) {
      advance(world, 1);
      Eigen::Vector3d force;
      ASSERT_EQ(tremolo_world_hand_force(world, body, hand, force.data()), TREMOLO_OK);
      const Eigen::Vector3d next = momentum(world, body);
      const Eigen::Vector3d all = force - weight * Eigen::Vector3d::UnitZ();
      EXPECT_LT((next - p - kWorldStep * all).norm(), 1e-7 * kWorldStep * weight) << k;
      p = next;
    }
    EXPECT_GT(p.norm(), 0.0);
    // States go both ways, between worlds with and without the hand.
    const std::vector<std::byte> held = saved(world);
    tremolo_world* other = world_of_one(kind);
    for (tremolo_world* one : {other, world}) {
      ASSERT_EQ(tremolo_world_restore(one, held.data(), held.size()), TREMOLO_OK)
          << tremolo_last_error();
      advance(one, 20);
    }
    EXPECT_TRUE(saved(other) == saved(world));
    tremolo_world* never = world_of_one(kind);
    for (tremolo_world* one : {world, never}) {
      ASSERT_EQ(tremolo_world_restore(one, before.data(), before.size()), TREMOLO_OK)
          << tremolo_last_error();
      EXPECT_TRUE(saved(one) == before);
      advance(one, 20);
    }
    EXPECT_TRUE(saved(never) == saved(world));
    // A state of another world is refused and changes nothing, the hand included.
    tremolo_world* further = make_world(false);
    const std::vector<std::byte> foreign = saved(further), here = saved(other);
    EXPECT_EQ(tremolo_world_restore(other, foreign.data(), foreign.size()), TREMOLO_CONTENT);
    EXPECT_TRUE(saved(other) == here);
    std::vector<std::byte> cut = before;
    cut.resize(cut.size() / 2);
    EXPECT_EQ(tremolo_world_restore(other, cut.data(), cut.size()), TREMOLO_CONTENT);
    EXPECT_TRUE(saved(other) == here);
    EXPECT_EQ(tremolo_world_let_go(other, body, hand), TREMOLO_OK);
    advance(other, 1);
  }
}

// Contact and hands need a method that has an equation for them.
TEST_F(WorldCApiRefusals, AHandOnABodyWhoseMethodTakesNoneIsRefusedInWords) {
  tremolo_scene* scene = nullptr;
  ASSERT_EQ(tremolo_scene_create(kWorldStep, &scene), TREMOLO_OK);
  const tremolo_scene_body place = at("one", {0.0, 0.0, 1.0});
  tremolo_body_options method;
  tremolo_body_options_init(&method);
  method.integrator = "newmark";
  method.frame = TREMOLO_DRIVEN;
  tremolo_model* held = nullptr;
  ASSERT_EQ(tremolo_model_load(path("held.tremolo").c_str(), 0, &held), TREMOLO_OK);
  ASSERT_EQ(tremolo_scene_add_reduced(scene, &place, held, &method, nullptr), TREMOLO_OK)
      << tremolo_last_error();
  tremolo_model_release(held);
  tremolo_world* world = of(scene);
  const std::vector<std::byte> before = saved(world);
  std::uint64_t hand = 0;
  EXPECT_EQ(tremolo_world_grab(world, first(world), 0, 300.0, 3.0, &hand), TREMOLO_USAGE);
  EXPECT_TRUE(error_has("body 'one': no hand can hold it")) << tremolo_last_error();
  EXPECT_TRUE(error_has("avf, ep2 and ep4")) << tremolo_last_error();
  EXPECT_TRUE(saved(world) == before);
}

TEST_F(WorldCApiRefusals, ALogThatThrowsCostsItsMessageAlone) {
  tremolo_world* world = make_world(false);
  const tremolo_body_id body = add(world, CubeKind::kReduced, at("one", {0.0, 0.0, 1.0}));
  int calls = 0;
  tremolo_set_log(
      [](void* user, tremolo_log_level, const char*) {
        ++*static_cast<int*>(user);
        throw std::runtime_error("from the log");
      },
      &calls);
  EXPECT_EQ(tremolo_world_remove(world, 12345), TREMOLO_USAGE);
  EXPECT_TRUE(error_has("does not exist")) << tremolo_last_error();
  // A warning of a call that succeeds.
  std::uint64_t hand = 0;
  EXPECT_EQ(tremolo_world_grab(world, body, 0, 1e12, 0.0, &hand), TREMOLO_OK);
  EXPECT_EQ(calls, 2);
  // A step that fails.
  const double force[3] = {1e120, 0.0, 0.0};
  ASSERT_EQ(tremolo_world_apply_force(world, body, 0, force, 1), TREMOLO_OK);
  EXPECT_NE(tremolo_world_step(world, 1, nullptr), TREMOLO_OK);
  EXPECT_EQ(calls, 3);
  EXPECT_TRUE(error_has("one: ")) << tremolo_last_error();
}

// A way of the caller's to run jobs, and what the error says about it.
struct Rule {
  const char* words;
  tremolo_run_jobs run;
};

TEST_F(WorldCApiRefusals, JobsThatBreakARuleAreAnErrorOfACompleteStep) {
  const Rule rules[] = {
      {"run returned without 4 of 4 jobs", [](void*, std::size_t, tremolo_job, void*) {}},
      {"worker 7, and there are 2",
       [](void*, std::size_t count, tremolo_job job, void* data) {
         for (std::size_t i = 0; i < count; ++i) job(data, i, 7);
       }},
      {"index 4, and there are 4 jobs",
       [](void*, std::size_t count, tremolo_job job, void* data) {
         for (std::size_t i = 0; i < count + 3; ++i) job(data, i, 0);
       }},
      {"again with index 0",
       [](void*, std::size_t count, tremolo_job job, void* data) {
         for (std::size_t i = 0; i < count; ++i)
           for (int twice = 0; twice < 2; ++twice) job(data, i, 1);
       }},
      {"run threw an exception, and must not: from the jobs",
       [](void*, std::size_t count, tremolo_job job, void* data) {
         for (std::size_t i = 0; i < count; ++i) {
           if (i == 1) throw std::runtime_error("from the jobs");
           job(data, i, 0);
         }
       }},
  };
  tremolo_world* undisturbed = make_world(true);
  const auto fill = [this](tremolo_world* world) {
    for (int k = 0; k < 3; ++k)
      add(world, CubeKind::kRigid, at(std::to_string(k).c_str(), {0.3 * k, 0.0, 0.0501}));
  };
  fill(undisturbed);
  advance(undisturbed, 5);
  for (const Rule& rule : rules) {
    SCOPED_TRACE(rule.words);
    tremolo_world* world = make_world(true);
    fill(world);
    ASSERT_EQ(tremolo_world_set_jobs(world, 2, rule.run, nullptr), TREMOLO_OK);
    std::int64_t done = -1;
    EXPECT_EQ(tremolo_world_step(world, 5, &done), TREMOLO_USAGE);
    EXPECT_TRUE(error_has("set_jobs: ") && error_has(rule.words)) << tremolo_last_error();
    EXPECT_EQ(done, 1);
    // The world goes on as if nothing had been.
    ASSERT_EQ(tremolo_world_set_jobs(world, 0, nullptr, nullptr), TREMOLO_OK);
    advance(world, 4);
    EXPECT_TRUE(saved(world) == saved(undisturbed));
  }
  EXPECT_EQ(tremolo_world_set_jobs(undisturbed, 4000000000U, rules[0].run, nullptr), TREMOLO_USAGE);
}

// Two threads with one worker: its memory is of one island at a time.
TEST_F(WorldCApiRefusals, JobsOfThreadsThatShareAWorkerChangeNoBit) {
  std::array<tremolo_world*, 2> worlds{};
  for (tremolo_world*& world : worlds) {
    world = make_world(true);
    for (int k = 0; k < 16; ++k)
      add(world, CubeKind::kReduced,
          at(std::to_string(k).c_str(), {0.3 * (k / 2), 0.0, k % 2 == 0 ? 0.06 : 0.17}));
  }
  const tremolo_run_jobs run = [](void* user, std::size_t count, tremolo_job job, void* data) {
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
      for (std::size_t i = next++; i < count; i = next++) job(data, i, 0);
    };
    std::thread other(work);
    work();
    other.join();
    ++*static_cast<int*>(user);
  };
  int calls = 0;
  ASSERT_EQ(tremolo_world_set_jobs(worlds[0], 1, run, &calls), TREMOLO_OK);
  for (int k = 0; k < 60; ++k) {
    const tremolo_status status = tremolo_world_step(worlds[0], 1, nullptr);
    EXPECT_TRUE(status == TREMOLO_OK || status == TREMOLO_USAGE) << tremolo_last_error();
  }
  EXPECT_GT(calls, 60);
  advance(worlds[1], 60);
  EXPECT_TRUE(saved(worlds[0]) == saved(worlds[1]));
}

}  // namespace
}  // namespace tremolo
