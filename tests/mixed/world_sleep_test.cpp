// Bodies of all kinds that come to rest in contact sleep, and what wakes them.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "tests/mixed/world_c_api.h"

namespace tremolo {
namespace {

class WorldSleep : public WorldCApi {
 protected:
  // One on the other on the floor; the upper one is of the kind.
  struct Stack {
    tremolo_world* world;
    tremolo_body_id low, high;
  };
  // Flush edges of tetrahedra on tetrahedra take many corrections.
  static constexpr double kAside = 0.013;
  Stack stack(CubeKind below, CubeKind above) {
    Stack made{make_world(true), 0, 0};
    made.low = add(made.world, below, at("low", {0.0, 0.0, kHalfEdge}));
    made.high = above == CubeKind::kCloth
                    ? add_patch(made.world)
                    : add(made.world, above, at("high", {kAside, 0.008, 3.0 * kHalfEdge}));
    return made;
  }
  // A cloth that lies on the cube below it with all its particles: edges that hang swing for long.
  static tremolo_body_id add_patch(tremolo_world* world) {
    tremolo_cloth_options sheet;
    tremolo_cloth_options_init(&sheet);
    sheet.columns = sheet.rows = 4;
    sheet.width = sheet.height = 0.06;
    for (int k = 0; k < 2; ++k) sheet.corner[k] = -0.03 + kAside;
    sheet.corner[2] = 2.0 * kHalfEdge + 0.001;
    sheet.density = 10.0;
    sheet.drag = 0.0;
    sheet.stiffness[0] = sheet.stiffness[1] = 600.0;
    sheet.damping[0] = sheet.damping[1] = 0.5;
    sheet.thickness = 0.002;
    sheet.friction = 0.5;
    sheet.restitution = 0.0;
    const tremolo_scene_body place = at("high", {0.0, 0.0, 0.0});
    tremolo_body_id body = 0;
    EXPECT_EQ(tremolo_world_add_cloth(world, &place, "implicit-euler", &sheet, nullptr, 0, &body),
              TREMOLO_OK)
        << tremolo_last_error();
    return body;
  }
  static constexpr double kPatchMass = 10.0 * 0.06 * 0.06;
  static bool asleep(tremolo_world* world, tremolo_body_id body) {
    std::int32_t answer = 0;
    EXPECT_EQ(tremolo_world_look(world, body, &answer, nullptr), TREMOLO_OK);
    return answer != 0;
  }
  // The steps until both sleep; -1: they do not in 4 s.
  static int settle(const Stack& s) {
    for (int k = 0; k < 2000; ++k) {
      advance(s.world, 1);
      if (asleep(s.world, s.low) && asleep(s.world, s.high)) return k;
    }
    return -1;
  }
  static tremolo_energy_account account(tremolo_world* world, tremolo_body_id body) {
    tremolo_energy_account a{};
    EXPECT_EQ(tremolo_world_account(world, body, &a), TREMOLO_OK);
    return a;
  }
  static double force_on(tremolo_world* world, tremolo_body_id body) {
    Eigen::Vector3d force;
    EXPECT_EQ(tremolo_world_contact(world, body, nullptr, nullptr, force.data(), nullptr),
              TREMOLO_OK);
    return force.z();
  }
};

// Those that a step of this world of one pair has one of another kind than reduced or rigid.
bool has_guest(CubeKind below, CubeKind above) {
  const auto guest = [](CubeKind kind) {
    return kind == CubeKind::kSoft || kind == CubeKind::kCloth;
  };
  return guest(below) || guest(above);
}

TEST_F(WorldSleep, AStackOfTwoKindsFallsAsleepAndStaysToTheBit) {
  for (const CubeKind below : kSolids)
    for (const CubeKind above : kKinds) {
      if (!has_guest(below, above)) continue;
      SCOPED_TRACE(std::to_string(static_cast<int>(below)) +
                   std::to_string(static_cast<int>(above)));
      const Stack s = stack(below, above);
      const int steps = settle(s);
      ASSERT_GE(steps, 250) << "half a second of rest";
      EXPECT_EQ(momentum(s.world, s.low).norm() + momentum(s.world, s.high).norm(), 0.0);
      // The upper body still presses with its weight, up to the rest of its motion.
      const double weight = kFall * (above == CubeKind::kCloth ? kPatchMass : mass(above));
      EXPECT_NEAR(force_on(s.world, s.high), weight, 0.03 * weight);
      const auto low = positions(s.world, s.low), high = positions(s.world, s.high);
      const tremolo_energy_account before = account(s.world, s.high);
      advance(s.world, 500);
      EXPECT_TRUE(positions(s.world, s.low) == low && positions(s.world, s.high) == high);
      EXPECT_EQ(account(s.world, s.high).restitution, before.restitution);
      EXPECT_EQ(tremolo_world_events(s.world), 0U);
    }
}

// Ten bodies of four kinds on each other come to rest, sleep, and stand as they are for a minute.
TEST_F(WorldSleep, AStackOfTenOfFourKindsRestsForAMinute) {
  for (const char* what :
       {"tets cube.veg --young 3e6 --poisson 0.3 --density 1000 --fix none -o hard.tets",
        "cube.veg --young 3e6 --poisson 0.3 --density 1000 --fix none --linear-modes 6 --modes 9 "
        "--order 1 -o hard.tremolo"}) {
    const ProgramResult made = run_program(folder_, kPrecompute + what);
    ASSERT_EQ(made.code, 0) << made.err;
  }
  const std::map<char, std::string> kinds = {
      {'p', "kind = \"rigid\"\nshape = \"box\"\nhalf-extents = [0.06, 0.06, 0.02]\nmass = 0.3\n"},
      {'t', "kind = \"tets\"\nmodel = \"hard.tets\"\nintegrator = \"midpoint\"\nbeta = 0.002\n"},
      {'r',
       "kind = \"free\"\nmodel = \"hard.tremolo\"\nbeta = 0.002\nshape = \"box\"\n"
       "half-extents = [0.05, 0.05, 0.05]\n"},
      {'c',
       "kind = \"cloth\"\ncolumns = 4\nrows = 4\nwidth = 0.09\nheight = 0.09\nthickness = 0.002\n"
       "density = 10\ndrag = 0\nstructural = [600, 0.5]\nshear = [600, 0.5]\n"}};
  std::string text =
      "cloths-pass = true\nstep = 0.002\ngravity = [0, 0, -9.81]\n"
      "[[colliders]]\nname = \"floor\"\nshape = \"plane\"\nfriction = 0.5\nrestitution = 0\n";
  double top = 0.0;
  int number = 0;
  for (const char kind : std::string("ptcprcptcp")) {
    text += "[[bodies]]\nname = \"" + std::to_string(number++) + "\"\n" + kinds.at(kind);
    text += "friction = 0.5\nrestitution = 0\n";
    const double height = kind == 'c' ? 0.002 : kind == 'p' ? 0.04 : 2.0 * kHalfEdge;
    const std::string middle = std::to_string(top + 0.5 * height);
    text +=
        kind == 'c' ? "corner = [-0.045, -0.045, " : "contact-stiffness = 200\nposition = [0, 0, ";
    text += middle + "]\n";
    top += height;
  }
  tremolo_scene* scene = nullptr;
  ASSERT_EQ(tremolo_scene_parse(text.c_str(), path("ten.toml").c_str(), &scene), TREMOLO_OK)
      << tremolo_last_error();
  tremolo_world* world = of(scene);
  const std::size_t bodies = tremolo_world_bodies(world);
  ASSERT_EQ(bodies, 10U);
  const auto rest = [&] {
    for (std::size_t i = 0; i < bodies; ++i)
      if (!asleep(world, tremolo_world_body(world, i))) return false;
    return true;
  };
  int steps = 0;
  for (; steps < 1500 && !rest(); ++steps) advance(world, 1);
  ASSERT_TRUE(rest());
  std::vector<std::vector<double>> places;
  for (std::size_t i = 0; i < bodies; ++i)
    places.push_back(positions(world, tremolo_world_body(world, i)));
  advance(world, static_cast<int>(60.0 / kWorldStep) - steps);
  double highest = 0.0;
  for (std::size_t i = 0; i < bodies; ++i) {
    SCOPED_TRACE(i);
    const tremolo_body_id body = tremolo_world_body(world, i);
    EXPECT_TRUE(asleep(world, body));
    EXPECT_TRUE(positions(world, body) == places[i]);
    EXPECT_LT(middle(world, body).head<2>().norm(), 1e-4) << "nothing has slid";
    highest = std::max(highest, middle(world, body).z());
  }
  EXPECT_GT(highest, top - 0.02 - 0.005) << "nothing has fallen";
}

// Contact takes the motion that sleep ends, as restitution. Of tetrahedra what has no other cause
// counts as given by the method, so that their balance shows nothing.
TEST_F(WorldSleep, SleepIsPartOfTheEnergyBalance) {
  for (const CubeKind above : {CubeKind::kRigid, CubeKind::kCloth}) {
    SCOPED_TRACE(static_cast<int>(above));
    const Stack s = stack(CubeKind::kSoft, above);
    double kinetic = 0.0, taken = 0.0;
    for (int k = 0; k < 2000 && !asleep(s.world, s.high); ++k) {
      kinetic = account(s.world, s.high).kinetic;
      taken = account(s.world, s.high).restitution;
      advance(s.world, 1);
    }
    ASSERT_TRUE(asleep(s.world, s.high));
    const tremolo_energy_account a = account(s.world, s.high);
    EXPECT_EQ(a.kinetic, 0.0);
    EXPECT_LT(std::abs(a.remainder), 1e-9 * (std::abs(a.gravity) + std::abs(a.contact)));
    EXPECT_LE(a.restitution, taken);
    EXPECT_GT(a.restitution, taken - 2.0 * kinetic - 1e-15);
  }
}

// What moves the upper body wakes it.
TEST_F(WorldSleep, WhatWakesASleeper) {
  using Change = std::function<void(const Stack&)>;
  const std::vector<std::pair<const char*, Change>> changes = {
      {"a hand",
       [](const Stack& s) {
         std::uint64_t hand = 0;
         ASSERT_EQ(tremolo_world_grab(s.world, s.high, 0, 1e3, 1.0, &hand), TREMOLO_OK);
       }},
      {"a force",
       [](const Stack& s) {
         const double force[3] = {0.0, 0.0, 0.1};
         ASSERT_EQ(tremolo_world_apply_force(s.world, s.high, 0, force, 3), TREMOLO_OK);
       }},
      {"something that falls on it", [this](const Stack& s) {
         const double z = middle(s.world, s.high).z() + 2.0 * kHalfEdge + 0.02;
         add(s.world, CubeKind::kRigid, at("third", {0.01, 0.0, z}));
         advance(s.world, 60);
       }}};
  for (const CubeKind above : {CubeKind::kSoft, CubeKind::kCloth, CubeKind::kRigid}) {
    const Stack s = stack(above == CubeKind::kRigid ? CubeKind::kSoft : CubeKind::kReduced, above);
    ASSERT_GE(settle(s), 0);
    const std::vector<std::byte> bytes = saved(s.world);
    for (const auto& [name, change] : changes) {
      SCOPED_TRACE(name + std::to_string(static_cast<int>(above)));
      ASSERT_EQ(tremolo_world_restore(s.world, bytes.data(), bytes.size()), TREMOLO_OK)
          << tremolo_last_error();
      ASSERT_TRUE(asleep(s.world, s.high));
      change(s);
      advance(s.world, 1);
      EXPECT_FALSE(asleep(s.world, s.high));
    }
  }
}

TEST_F(WorldSleep, AFloorThatMovesWakesWhatLiesOnIt) {
  const Stack s = stack(CubeKind::kSoft, CubeKind::kCloth);
  ASSERT_GE(settle(s), 0);
  const double place[3] = {1e-5, 0.0, 0.0}, turn[4] = {1.0, 0.0, 0.0, 0.0};
  ASSERT_EQ(tremolo_world_move_collider(s.world, 0, place, turn), TREMOLO_OK);
  advance(s.world, 1);
  EXPECT_FALSE(asleep(s.world, s.high) || asleep(s.world, s.low));
}

// What slept on something that is taken away falls.
TEST_F(WorldSleep, ASleeperWithoutItsSupportFalls) {
  for (const bool whole : {true, false}) {
    SCOPED_TRACE(whole);
    const Stack s = stack(CubeKind::kSoft, CubeKind::kCloth);
    ASSERT_GE(settle(s), 0);
    if (whole) {
      ASSERT_EQ(tremolo_world_remove_collider(s.world, 0), TREMOLO_OK);
    } else {
      ASSERT_EQ(tremolo_world_remove(s.world, s.low), TREMOLO_OK);
    }
    advance(s.world, 20);
    EXPECT_FALSE(asleep(s.world, s.high));
    EXPECT_LT(momentum(s.world, s.high).z(), -0.8 * 20 * kWorldStep * kFall * kPatchMass);
  }
}

// A world that is saved asleep goes on with the same bits.
TEST_F(WorldSleep, ASavedSleeperGoesOnWithTheSameBits) {
  const Stack s = stack(CubeKind::kSoft, CubeKind::kCloth);
  ASSERT_GE(settle(s), 0);
  const std::vector<std::byte> bytes = saved(s.world);
  const auto go_on = [&] {
    const double force[3] = {0.0, 0.0, 0.1};
    advance(s.world, 5);
    EXPECT_TRUE(asleep(s.world, s.high));
    EXPECT_EQ(tremolo_world_apply_force(s.world, s.high, 0, force, 3), TREMOLO_OK);
    advance(s.world, 20);
    return saved(s.world);
  };
  const std::vector<std::byte> first = go_on();
  ASSERT_EQ(tremolo_world_restore(s.world, bytes.data(), bytes.size()), TREMOLO_OK)
      << tremolo_last_error();
  EXPECT_TRUE(asleep(s.world, s.high) && asleep(s.world, s.low));
  EXPECT_TRUE(go_on() == first);
}

// Where the world's `sleep` is false nothing sleeps; wind and pins that move keep a cloth awake.
TEST_F(WorldSleep, WhatDoesNotSleep) {
  const auto run = [&](const std::string& world, const std::string& cloth) {
    tremolo_scene* scene = nullptr;
    const std::string text = world + R"(
step = 0.004
gravity = [0, 0, -9.81]
[[bodies]]
name = "sheet"
kind = "cloth"
columns = 5
rows = 5
width = 0.2
height = 0.2
corner = [-0.1, -0.1, 0.001]
thickness = 0.002
drag = 0.1
)" + cloth + R"(
[[bodies]]
name = "box"
kind = "rigid"
shape = "box"
half-extents = [0.05, 0.05, 0.05]
mass = 0.1
position = [0, 0, 0.052]
[[colliders]]
name = "floor"
shape = "plane"
)";
    EXPECT_EQ(tremolo_scene_parse(text.c_str(), path("sheet.toml").c_str(), &scene), TREMOLO_OK)
        << tremolo_last_error();
    tremolo_world* made = of(scene);
    advance(made, 800);
    // A rigid body comes first, then cloths.
    return asleep(made, tremolo_world_body(made, 0)) && asleep(made, tremolo_world_body(made, 1));
  };
  EXPECT_TRUE(run("", ""));
  EXPECT_FALSE(run("sleep = false", ""));
  EXPECT_FALSE(run("wind = [0.1, 0, 0]", ""));
  EXPECT_TRUE(run("", "[[bodies.pins]]\nat = \"left\"\n"));
  EXPECT_FALSE(run("", "[[bodies.pins]]\nat = \"left\"\nuntil = 10\n"));
}

}  // namespace
}  // namespace tremolo
