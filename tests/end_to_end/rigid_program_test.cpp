// Scenes of rigid bodies as a user meets them: at rest, joined, hard, and of unequal masses.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/programs.h"

namespace tremolo {
namespace {

class RigidProgram : public ::testing::Test {
 protected:
  void SetUp() override { folder_ = fresh_folder(); }

  nlohmann::json run(const std::string& scene) {
    std::ofstream(folder_ + "/scene.toml") << scene;
    const ProgramResult result = run_program(folder_, kTremolo + "run scene.toml --json");
    EXPECT_EQ(result.code, 0) << result.err;
    return nlohmann::json::parse(result.out);
  }

  std::string folder_;
};

std::string box(const std::string& name, double mass, const std::string& position) {
  return fmt::format(
      "[[bodies]]\nname = \"{}\"\nkind = \"rigid\"\nshape = \"box\"\n"
      "half-extents = [0.05, 0.05, 0.05]\nmass = {}\nposition = {}\n",
      name, mass, position);
}

constexpr const char* kFloor = "[[colliders]]\nname = \"floor\"\nshape = \"plane\"\n";

// Only rounding moves here, about which no balance says anything.
TEST_F(RigidProgram, BodiesJoinedAtRestStayThere) {
  const std::string bodies = "duration = 0.3\nstep = 0.003\n" + box("a", 1.0, "[0, 0, 0.3]") +
                             box("b", 1.0, "[0.4, 0, 0.3]");
  for (const std::string spring : {"", "stiffness = 1000\n"}) {
    const nlohmann::json report =
        run(bodies + "[[joints]]\nbody = \"a\"\nat = \"near:0.05,0.05,0.05\"\nto = \"b\"\n" +
            "to-at = \"near:-0.05,0.05,0.05\"\nlength = 0.3\n" + spring);
    for (const nlohmann::json& body : report["bodies"]) {
      EXPECT_LT(body["energy_max"], 1e-18);
      EXPECT_EQ(body["energy_balance_error"], 0.0);
    }
  }
}

// A ball hangs at rest. Its energy is that of a millionth of a metre, and rounding at the string,
// which grows with the weight and the string's length, is more than a millionth of that.
TEST_F(RigidProgram, RoundingAtAStringIsNoErrorOfTheBalance) {
  for (const char* step : {"0.003", "0.001", "0.0003"})
    for (const char* duration : {"0.1", "10"}) {
      const nlohmann::json report =
          run(fmt::format("step = {}\nduration = {}\n", step, duration) +
              "gravity = [0, 0, -9.81]\n[[bodies]]\nname = \"ball\"\nkind = \"rigid\"\n"
              "shape = \"sphere\"\nradius = 0.05\nmass = 1\n[[joints]]\nbody = \"ball\"\n"
              "at = \"near:0,0,0.05\"\nto = \"world\"\npoint = [0, 0, 20.05]\nlength = 20\n");
      EXPECT_EQ(report["exit_code"], 0);
      EXPECT_LT(report["bodies"][0]["energy_max"], 1e-6);
    }
}

// The force at the end of the motion without contact, a thousand times the weight, is no measure of
// the step's accuracy.
TEST_F(RigidProgram, HardBodiesBalanceTheirEnergyAtLongSteps) {
  for (const double modulus : {1e6, 1e8, 1e10})
    for (const double height : {0.05, 0.08}) {
      SCOPED_TRACE(fmt::format("{:g} Pa from {} m", modulus, height));
      const nlohmann::json report =
          run("duration = 0.6\nstep = 0.0166666667\ngravity = [0, 0, -9.81]\n" +
              box("a", 0.5, fmt::format("[0, 0, {}]", height)) +
              fmt::format("contact-modulus = {:g}\n", modulus) + kFloor);
      EXPECT_LT(report["energy_balance_error"], 1e-6);
    }
}

// Where a step is taken in parts the force of a joint is the mean over them, by which the momentum
// of the step is known.
TEST_F(RigidProgram, ASphereOnASpringThatHitsTheFloorKeepsItsMomentum) {
  for (const double step : {0.006, 0.003}) {
    const nlohmann::json report =
        run(fmt::format("duration = 0.5\nstep = {}\n", step) +
            "gravity = [0, 0, -9.81]\n[[bodies]]\nname = \"ball\"\nkind = \"rigid\"\nshape = "
            "\"sphere\"\nradius = 0.05\nmass = 0.5\nposition = [0, 0, 0.3]\n[[joints]]\nbody = "
            "\"ball\"\nat = \"near:0,0,0.05\"\nto = \"world\"\nstiffness = 10\ndamping = 0.1\n" +
            kFloor);
    EXPECT_GT(report["bodies"][0]["contacts"].get<int>(), 0);
    EXPECT_LT(report["momentum_error"].get<double>(), 1e-12) << step;
  }
}

TEST_F(RigidProgram, AHeavyBodyThatSinksIntoALightOneIsReported) {
  const auto stack = [](double mass) {
    return "duration = 0.3\nstep = 0.003\ngravity = [0, 0, -9.81]\n" +
           box("low", 1.0, "[0, 0, 0.05]") + box("high", mass, "[0, 0, 0.15]") + kFloor;
  };
  EXPECT_TRUE(run(stack(1.0))["warnings"].empty());
  const nlohmann::json warnings = run(stack(5e3))["warnings"];
  ASSERT_EQ(warnings.size(), 1U);
  for (const char* words : {"contact-modulus", "5e+03 times the mass"})
    EXPECT_NE(warnings[0].get<std::string>().find(words), std::string::npos) << warnings[0];
}

// A plate 4 mm thick, fixed or free, stops a box at any speed: it leaves with half its speed.
// Two meshes without a `shape` pass through each other, in a scene with a floor too.
TEST_F(RigidProgram, BodiesWithoutAShapeThatMeetAreNamed) {
  std::ofstream obj(folder_ + "/tetrahedron.obj");
  obj << "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
  obj.close();
  const auto mesh = [](const char* name, const char* place) {
    return fmt::format(
        "[[bodies]]\nname = \"{}\"\nkind = \"rigid\"\nmesh = \"tetrahedron.obj\"\n{}", name, place);
  };
  const std::string meet = "duration = 0.3\n" + mesh("a", "velocity = [1, 0, 0]\n") +
                           mesh("b", "position = [0.2, 0, 0]\n");
  const std::string floor =
      "[[colliders]]\nname = \"far\"\nshape = \"plane\"\nposition = [0, 0, -9]\n";
  for (const std::string& scene : {meet, meet + floor}) {
    const nlohmann::json warnings = run(scene)["warnings"];
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_NE(warnings[0].get<std::string>().find("'a' and 'b'"), std::string::npos);
  }
  const std::string shape = "shape = \"sphere\"\nradius = 0.004\n";
  EXPECT_EQ(run(meet + shape)["warnings"].size(), 0U);
}

TEST_F(RigidProgram, ThinPlatesStopWhatHitsThem) {
  for (const double speed : {1.0, 10.0, 50.0})
    for (const double step : {1.0 / 60.0, 0.003, 0.0005})
      for (const bool free : {false, true}) {
        SCOPED_TRACE(fmt::format("{} m/s, {} s, free {}", speed, step, free));
        const std::string plate =
            "name = \"plate\"\nshape = \"box\"\nhalf-extents = [0.3, 0.3, 0.002]\n";
        const nlohmann::json report =
            run(fmt::format("duration = {}\nstep = {}\n", std::max(0.1, 6.0 * step), step) +
                box("a", 0.2, "[0, 0, 0.07]") + fmt::format("velocity = [0, 0, {}]\n", -speed) +
                (free ? "[[bodies]]\nkind = \"rigid\"\nmass = 40\n" : "[[colliders]]\n") + plate);
        const nlohmann::json& body = report["bodies"][0];
        const double left = body["linear_momentum_final"][2], came = 0.2 * speed;
        // Of a plate of 40 kg: (m_b e - m_a)/(m_a + m_b) of the momentum is given back.
        const double wanted = free ? came * (40.0 * 0.5 - 0.2) / 40.2 : 0.5 * came;
        EXPECT_NEAR(left, wanted, 0.02 * came);
        EXPECT_EQ(body["passed_through"], 0);
        EXPECT_LT(report["energy_balance_error"], 1e-8);
        EXPECT_LT(report["momentum_error"], 1e-10);
      }
}

// Trays and shelves: a thin free plate between the floor and a load ten times as heavy, laid on it
// or dropped.
// The net is held by its rim, so that the ball's weight, not its own, presses on its particles. The
// cloth that meets balls in a scene of its own has another law of contact, without a layer.
TEST_F(RigidProgram, ANetThatIsHeldStopsABallAsTheNetOfAClothSceneDoes) {
  const std::string net =
      "columns = 21\nrows = 21\nwidth = 0.6\nheight = 0.6\ncorner = [-0.3, -0.3, 0]\n"
      "structural = 5000.0\nshear = 1500.0\nrestitution = 1.0\n"
      "pins = [\"top\", \"bottom\", \"left\", \"right\"]\n";
  const std::string ball =
      "radius = 0.05\nmass = 0.5\nposition = [0.003, 0.002, 0.061]\nvelocity = [0, 0, -5.0]\n"
      "restitution = 1.0\n";
  const nlohmann::json alone =
      run("duration = 0.1\nstep = 0.001\nintegrator = \"energy\"\n[[cloths]]\n" + net +
          "[[balls]]\n" + ball);
  const double leaves = alone["balls"][0]["velocity"][2];
  EXPECT_GT(leaves, 4.5);
  for (const double step : {0.004, 0.002, 0.001}) {
    SCOPED_TRACE(step);
    const nlohmann::json report =
        run(fmt::format("duration = 0.1\nstep = {}\n", step) +
            "[[bodies]]\nname = \"net\"\nkind = \"cloth\"\nintegrator = \"energy\"\n" + net +
            "[[bodies]]\nname = \"ball\"\nkind = \"rigid\"\nshape = \"sphere\"\n" + ball);
    EXPECT_TRUE(report["warnings"].empty()) << report["warnings"];
    for (const nlohmann::json& body : report["bodies"])
      if (body["kind"] == "cloth")
        EXPECT_LT(body["penetration_max"], 1e-3);
      else
        EXPECT_NEAR(std::sqrt(2.0 * body["energy_final"].get<double>() / 0.5), leaves,
                    0.02 * leaves);
  }
}

TEST_F(RigidProgram, ATrayOnTheFloorCarriesWhatIsPutOrFallsOnIt) {
  for (const double gap : {0.0, 0.2})
    for (const double step : {0.003, 0.0015}) {
      SCOPED_TRACE(fmt::format("from {} m, {} s", gap, step));
      const nlohmann::json report =
          run(fmt::format("duration = 1.5\nstep = {}\ngravity = [0, 0, -9.81]\n", step) +
              "[[bodies]]\nname = \"tray\"\nkind = \"rigid\"\nshape = \"box\"\nhalf-extents = "
              "[0.2, 0.15, 0.002]\nmass = 1\nposition = [0, 0, 0.002]\n" +
              box("load", 10.0, fmt::format("[0, 0, {}]", 0.054 + gap)) + kFloor);
      const nlohmann::json& load = report["bodies"][1];
      EXPECT_NEAR(load["position_final"][2], 0.053, 0.005);
      EXPECT_LT(report["energy_balance_error"], 1e-7);
    }
}

}  // namespace
}  // namespace tremolo
