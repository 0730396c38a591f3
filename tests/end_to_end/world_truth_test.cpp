// Bodies whose support moves, and bodies that fly, against the whole mesh moved through the world
// by `tremolo-precompute reference`, which has neither a moving frame nor an integral over a mode.
// A basis with as many columns as the mesh has unknowns is exact: the remaining error is that of
// the steps, and must fall by four when they are halved.
#include <map>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "runtime/body.h"
#include "tests/support/frames/given_motion.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

using testing::GivenMotion;

// run.csv of a reference.
struct WorldTable {
  std::map<std::string, std::size_t> column;
  std::vector<std::vector<double>> rows;
  std::vector<VertexId> probes;

  explicit WorldTable(const std::string& csv) {
    std::istringstream stream(csv);
    std::string line, word;
    std::getline(stream, line);
    for (std::istringstream names(line); std::getline(names, word, ',');) {
      if (word.front() == 'u' && word.back() == 'x') probes.push_back(std::stoi(word.substr(1)));
      column.emplace(word, column.size());
    }
    while (std::getline(stream, line)) {
      rows.emplace_back();
      for (std::istringstream values(line); std::getline(values, word, ',');)
        rows.back().push_back(std::stod(word));
    }
  }
  Eigen::Vector3d vector(std::size_t row, const std::string& first) const {
    return Eigen::Vector3d::Map(rows[row].data() + column.at(first));
  }
  Eigen::Quaterniond turn(std::size_t row) const {
    const double* q = rows[row].data() + column.at("qw");
    return {q[0], q[1], q[2], q[3]};
  }
};

// The largest differences over all rows.
struct WorldDifference {
  double peak = 0;  // largest |u| of the probes in the reference, m
  double displacement = 0, place = 0, turn = 0, linear = 0, angular = 0;
};

void look(const Body& body, const WorldTable& table, std::size_t row, WorldDifference& worst) {
  const auto keep = [](double& largest, double value) { largest = std::max(largest, value); };
  for (VertexId v : table.probes) {
    const Eigen::Vector3d u = table.vector(row, "u" + std::to_string(v) + "x");
    keep(worst.peak, u.norm());
    keep(worst.displacement, (*body.displacement(v) - u).norm());
  }
  const Pose pose = body.pose();
  keep(worst.place, (pose.position - table.vector(row, "x")).norm());
  keep(worst.turn, turn_of(pose.rotation.conjugate() * table.turn(row)).norm());
  keep(worst.linear, (body.momentum().linear - table.vector(row, "px")).norm());
  keep(worst.angular, (body.momentum().angular - table.vector(row, "lx")).norm());
}

// move(body, time): before each step. The table's rows lie `every` steps apart.
template <class Move>
WorldDifference follow(Body& body, const WorldTable& table, int every, const Move& move) {
  WorldDifference worst;
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    for (int i = 0; row > 0 && i < every; ++i) {
      move(body, body.time());
      EXPECT_TRUE(body.step().converged);
    }
    EXPECT_NEAR(body.time(), table.rows[row][0], 1e-9);
    look(body, table, row, worst);
  }
  return worst;
}

constexpr double kInterval = 0.006;  // s, between rows
constexpr double kLong = 0.3;        // s

struct Damping {
  double alpha = 0, beta = 0;
};

class WorldTruth : public ::testing::Test {
 protected:
  void SetUp() override { folder_ = fresh_folder(); }
  void mesh(const std::array<int, 3>& cells, const Eigen::Vector3d& size) {
    write_veg(folder_ + "/bar.veg", box_mesh(cells, size));
  }
  std::string material() const {
    return "bar.veg --order " + order_ + " --young 1e5 --poisson 0.3 --threads 1 ";
  }
  nlohmann::json run(const std::string& arguments) {
    const ProgramResult result = run_program(folder_, kPrecompute + arguments);
    EXPECT_EQ(result.code, 0) << result.err;
    return result.out.empty() ? nlohmann::json{} : nlohmann::json::parse(result.out);
  }
  WorldTable reference(const std::string& arguments, double step) {
    const std::string every = std::to_string(std::lround(kInterval / step));
    run("reference " + material() + "--probe 'x>-1' --out full --duration " +
        std::to_string(kLong) + " --step " + std::to_string(step) + " --every " + every + " " +
        arguments);
    return WorldTable(slurp(folder_ + "/full/run.csv"));
  }
  Body body(double step, FrameKind frame, const Damping& damping = {}) {
    Result<Model::Pointer> model = Model::load(folder_ + "/bar.tremolo");
    EXPECT_TRUE(model);
    IntegratorOptions options;
    options.step = step;
    options.alpha = damping.alpha;
    options.beta = damping.beta;
    options.tolerance = 1e-9;
    Result<Body> made = Body::create(*model, "ep4", options, frame);
    EXPECT_TRUE(made) << made.error().message;
    return std::move(*made);
  }
  // step: of the whole mesh.
  WorldDifference driven(const GivenMotion& motion, double step, double body_step,
                         const Damping& damping, double gravity) {
    motion.write(folder_ + "/motion.csv", kLong, 5e-4);
    const WorldTable table =
        reference("--fix 'x<0.001' --support-motion motion.csv --load none --gravity 0,0," +
                      std::to_string(gravity) + " --alpha " + std::to_string(damping.alpha) +
                      " --beta " + std::to_string(damping.beta),
                  step);
    Body moved = body(body_step, FrameKind::kDriven, damping);
    EXPECT_TRUE(moved.set_gravity({0, 0, gravity}));
    return follow(
        moved, table, static_cast<int>(std::lround(kInterval / body_step)),
        [&](Body& b, double time) {
          EXPECT_TRUE(b.move_to(motion.at(time + body_step), motion.in_step(time, body_step)));
        });
  }
  WorldDifference flying(const std::string& arguments, const Eigen::Vector3d& spin,
                         const Eigen::Vector3d& force, double step, double beta = 0.0) {
    const WorldTable table =
        reference("--fix none --beta " + std::to_string(beta) + " " + arguments, step);
    Body free = body(step, FrameKind::kFree, {0.0, beta});
    EXPECT_TRUE(free.set_motion({0, 0, 0}, spin));
    EXPECT_TRUE(free.add_load({.kind = SignalKind::kSquare}, 11, force));
    return follow(free, table, static_cast<int>(std::lround(kInterval / step)),
                  [](Body&, double) {});
  }

  std::string folder_;
  std::string order_ = "1";  // of the elements
};

// Shake, spin-up (centrifugal, Euler's and Coriolis's forces), both kinds of damping, and gravity.
class DrivenTruth : public WorldTruth {
 protected:
  // A mesh fixed at one end, of `unknowns` coordinates that are all in the basis.
  void converges(const std::string& unknowns) {
    run(material() + "--fix 'x<0.001' --linear-modes " + unknowns + " --modes " + unknowns +
        " -o bar.tremolo");
    const GivenMotion motion{{0.06, 0.02, 0.025}, 2.0, {1.6, 1.0, 4.7}};
    const Damping damping{0.7, 0.003};
    const WorldDifference coarse = driven(motion, 1e-3, 1e-3, damping, -9.81);
    const WorldDifference fine = driven(motion, 5e-4, 5e-4, damping, -9.81);
    EXPECT_GT(coarse.peak, 0.04);  // a large deflection of a bar of 0.3 m
    EXPECT_LE(fine.displacement, 5e-4 * fine.peak);
    EXPECT_GE(coarse.displacement / fine.displacement, 3.3);
    EXPECT_LE(fine.place, 1e-9);  // error of the spline of the given poses
    EXPECT_LE(fine.turn, 1e-9);
  }
};

TEST_F(DrivenTruth, ABodyWithoutReductionErrorConvergesToTheWholeMesh) {
  mesh({2, 1, 1}, {0.3, 0.12, 0.1});
  converges("24");
}

TEST_F(DrivenTruth, ABodyOfQuadraticElementsWithoutReductionErrorConvergesToTheWholeMesh) {
  order_ = "2";
  mesh({1, 1, 1}, {0.3, 0.12, 0.1});
  converges("54");
}

// The whole mesh rotates freely under an initial spin; then a force along the world's axes also
// pushes a vertex.
TEST_F(WorldTruth, AFreeBodyWithoutReductionErrorConvergesToTheWholeMesh) {
  mesh({2, 1, 1}, {0.3, 0.12, 0.1});
  run(material() + "--fix none --linear-modes 30 --modes 30 -o bar.tremolo");
  const std::string spin = "--spin 9,14,-7 --integrator midpoint ";
  const std::string force = "--load square --load-at vertex:11 --load-force 1,2,3 ";
  for (const bool pushed : {false, true}) {
    const Eigen::Vector3d pull = pushed ? Eigen::Vector3d(1, 2, 3) : Eigen::Vector3d::Zero();
    const auto at = [&](double step) {
      return flying(spin + (pushed ? force : "--load none"), {9, 14, -7}, pull, step);
    };
    const WorldDifference coarse = at(5e-4), fine = at(2.5e-4);
    EXPECT_GT(fine.peak, 5e-3);
    EXPECT_LE(fine.displacement, 0.02 * fine.peak);
    EXPECT_GE(coarse.displacement / fine.displacement, 3.3);
    EXPECT_LE(fine.turn, 1e-4);  // of five radians
    EXPECT_GE(coarse.turn / fine.turn, 3.3);
    EXPECT_LE(fine.linear, 1e-9);   // kg m/s, of up to 1.1
    EXPECT_LE(fine.angular, 4e-6);  // N m s, of 0.48: where the force acts depends on the step
  }
}

// Stiffness damping of a body that spins and is pushed: that of its strains, which see no rotation.
TEST_F(WorldTruth, AFreeDampedBodyConvergesToTheWholeMesh) {
  mesh({2, 1, 1}, {0.3, 0.12, 0.1});
  run(material() + "--fix none --linear-modes 30 --modes 30 -o bar.tremolo");
  const auto at = [&](double step) {
    return flying("--spin 9,14,-7 --integrator midpoint --load none", {9, 14, -7},
                  Eigen::Vector3d::Zero(), step, 0.003);
  };
  const WorldDifference coarse = at(5e-4), fine = at(2.5e-4);
  EXPECT_GT(fine.peak, 4e-3);
  EXPECT_LE(fine.displacement, 0.02 * fine.peak);
  EXPECT_GE(coarse.displacement / fine.displacement, 3.3);
  EXPECT_LE(fine.turn, 1e-4);     // of five radians
  EXPECT_LE(fine.angular, 1e-7);  // N m s, of 0.48: error of the solves of the whole mesh
}

// With a basis that leaves much out, a shake below the first frequency and a spin-up: not farther
// than under a static load along the shake that moves some vertex as far.
TEST_F(WorldTruth, ADrivenBodyIsAsNearToTheMeshAsUnderAStaticLoad) {
  mesh({8, 2, 2}, {0.24, 0.06, 0.05});
  run(material() + "--fix 'x<0.001' --linear-modes 6 --derivatives 2 -o bar.tremolo");
  const Eigen::Vector3d along(0.06, 0.018, 0.024);
  const WorldDifference moved = driven({along, 1.0, {1.2, 0.8, 3.7}}, 1e-3, 3e-3, Damping{}, 0.0);
  EXPECT_GT(moved.peak, 0.04);
  double gravity = 10.0, reached = 0;
  nlohmann::json at_rest;
  for (int i = 0; i < 8 && std::abs(reached / moved.peak - 1.0) > 0.02; ++i) {
    if (reached > 0) gravity *= moved.peak / reached;
    const Eigen::Vector3d pull = gravity / along.norm() * along;
    at_rest = run("reference " + material() +
                  "--fix 'x<0.001' --static --compare bar.tremolo --probe 'x>-1' --json "
                  "--gravity " +
                  std::to_string(pull.x()) + "," + std::to_string(pull.y()) + "," +
                  std::to_string(pull.z()));
    reached = at_rest["largest"]["displacement"];
  }
  ASSERT_NEAR(reached, moved.peak, 0.02 * moved.peak);
  EXPECT_LE(moved.displacement / moved.peak, at_rest["comparison"]["tip_error_of_largest"]);
}

TEST_F(WorldTruth, TheWholeMeshBalancesItsEnergyWithTheWorkOfItsSupport) {
  mesh({2, 1, 1}, {0.3, 0.12, 0.1});
  const GivenMotion motion{{0.06, 0.02, 0.025}, 2.0, {1.6, 1.0, 4.7}};
  motion.write(folder_ + "/motion.csv", kLong, 5e-4);
  const auto drift = [&](const std::string& step) {
    return run("reference " + material() +
               "--fix 'x<0.001' --support-motion motion.csv --load none --gravity 0,0,-9.81 "
               "--alpha 0.7 --beta 0.003 --duration 0.3 --json --step " +
               step)["energy_drift_max"]
        .get<double>();
  };
  const double coarse = drift("0.001"), fine = drift("0.0005");
  EXPECT_LE(coarse, 1e-4);
  EXPECT_GE(coarse / fine, 3.3);  // the balance is of second order
}

TEST_F(WorldTruth, WhatDoesNotGoTogetherIsRefused) {
  mesh({2, 1, 1}, {0.3, 0.12, 0.1});
  const auto code = [&](const std::string& arguments, const std::string& words) {
    const ProgramResult result =
        run_program(folder_, kPrecompute + "reference " + material() + arguments);
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    return result.code;
  };
  const std::string held = "--fix 'x<0.001' --support-motion motion.csv ";
  GivenMotion{}.write(folder_ + "/motion.csv", 0.1, 0.01);
  EXPECT_EQ(code(held + "--duration 1", "motion lasts from"), 3);
  EXPECT_EQ(code(held + "--duration 0.1 --compare a.tremolo", "--compare"), 2);
  EXPECT_EQ(code(held + "--duration 0.1 --static", "--static"), 2);
  EXPECT_EQ(code(held + "--duration 0.1 --spin 1,0,0", "--spin"), 2);
  EXPECT_EQ(code(held + "--duration 0.1 --spin 1,0", "three numbers"), 2);
  EXPECT_EQ(code(held + "--duration 0.1 --fix-x 'x>0.29'", "--fix-x"), 3);
  EXPECT_EQ(code("--fix none --duration 0.1 --support-motion motion.csv", "not fixed anywhere"), 3);
  EXPECT_EQ(code("--fix 'x<0.001' --duration 0.1 --velocity 1,0,0", "--fix none"), 3);
  EXPECT_EQ(code("--fix none --velocity 1,0,0 --alpha 0.1", "--alpha"), 2);
  EXPECT_EQ(code("--fix 'x<0.001' --duration 0.1 --support-motion gone.csv", "gone.csv"), 1);
  std::ofstream(folder_ + "/motion.csv") << "t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n1,0,0,0,1,0\n";
  EXPECT_EQ(code(held, "line 3"), 3);
  std::ofstream(folder_ + "/motion.csv") << "0,0,0,0,1,0,0,0\n1,0,0,0,2,0,0,0\n";
  EXPECT_EQ(code(held, "length 2"), 3);
  std::ofstream(folder_ + "/motion.csv") << "0,0,0,0,1,0,0,0\n";
  EXPECT_EQ(code(held, "at least two rows"), 3);
  std::ofstream(folder_ + "/motion.csv") << "0,0,0,0,1,0,0,0\n0,0,0,0,1,0,0,0\n";
  EXPECT_EQ(code(held, "must ascend"), 3);
}

}  // namespace
}  // namespace tremolo
