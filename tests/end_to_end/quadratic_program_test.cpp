// Quadratic elements as a user meets them: output, several ranks and every solver, free bodies and
// materials, files of quadratic meshes, the reference, and refusals.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/mesh/edge_points.h"
#include "formats/basis/basis_reader.h"
#include "runtime/model.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

class Quadratic : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fresh_folder();
    write_veg(folder_ + "/block.veg", block_);
  }

  ProgramResult run(const std::string& arguments, const std::string& before = "") {
    return run_program(folder_, before + kPrecompute + arguments);
  }
  BasisData made(const std::string& arguments, const std::string& before = "") {
    const ProgramResult result = run(arguments + " -o made.tremolo", before);
    EXPECT_EQ(result.code, 0) << result.err;
    auto data = read_basis(folder_ + "/made.tremolo");
    EXPECT_TRUE(data);
    return data ? *data : BasisData{};
  }
  nlohmann::json report_of(const std::string& arguments) {
    const ProgramResult result = run(arguments + " -o made.tremolo --json");
    EXPECT_EQ(result.code, 0) << result.err;
    return nlohmann::json::parse(result.out, nullptr, false);
  }

  std::string folder_;
  // Three different sides: no two modes are equal.
  TetMesh block_ = box_mesh({6, 2, 2}, {1.0, 0.31, 0.23});
  static constexpr const char* kSolid = "--young 1e6 --poisson 0.3 --density 1000 --fix 'x<0.001' ";
  static std::string good(const std::string& order = "2", const std::string& mesh = "block.veg") {
    return mesh + " --order " + order + " " + kSolid + "--linear-modes 5 --modes 10 ";
  }
};

TEST_F(Quadratic, OrderElementsAndDofsAreTold) {
  const nlohmann::json report = report_of(good());
  const std::size_t edges = mesh_edges(block_).size();
  EXPECT_EQ(report["order"], 2);
  EXPECT_EQ(report["elements"], block_.tetrahedra.size());
  EXPECT_EQ(report["n"], block_.vertices.size() + edges);
  // One side of 2 x 2 cells: 9 corners, 16 edges of its 8 triangles.
  EXPECT_EQ(report["dofs"], 3 * (block_.vertices.size() + edges - 9 - 16));
  const ProgramResult inspected =
      run_program(folder_, TREMOLO_BIN_DIR "/tremolo inspect made.tremolo --json");
  ASSERT_EQ(inspected.code, 0) << inspected.err;
  EXPECT_EQ(nlohmann::json::parse(inspected.out)["order"], 2);
  EXPECT_EQ(report_of(good("1"))["order"], 1);
}

TEST_F(Quadratic, AutoIsARuleOfTheMesh) {
  const std::string automatic = good("auto");
  EXPECT_EQ(report_of(automatic)["order"], 2);
  EXPECT_EQ(report_of(automatic + "--mass lumped")["order"], 1);
}

// A slender bar of one cell across (nu = 0) against Euler and Bernoulli with Timoshenko's and the
// rotary inertia's first correction: the refined limit of the elements.
TEST_F(Quadratic, ASlenderCantileverOfOneCellBendsAsItShould) {
  write_veg(folder_ + "/bar.veg", box_mesh({50, 1, 1}, {1.0, 0.02, 0.021}));
  write_veg(folder_ + "/fine.veg", box_mesh({100, 2, 2}, {1.0, 0.02, 0.021}));
  const std::string options =
      " --order 2 --young 1e7 --poisson 0 --density 1000 --fix 'x<0.001' --linear --linear-modes 6";
  const Eigen::VectorXd coarse = made("bar.veg" + options).lambda.cwiseSqrt();
  const Eigen::VectorXd fine = made("fine.veg" + options).lambda.cwiseSqrt();
  // Bending about both axes alternately: modes 1, 3, 5 in one plane and 2, 4, 6 in the other.
  const double roots[] = {1.8751040687, 4.6940911330, 7.8547574382};
  for (int plane = 0; plane < 2; ++plane) {
    const double h = plane == 0 ? 0.02 : 0.021, speed = std::sqrt(1e7 / 1000.0);
    const double gyration = h / std::sqrt(12.0), shear = 5.0 / 6.0;
    for (int mode = 0; mode < 3; ++mode) {
      const double euler = roots[mode] * roots[mode] * speed * gyration;
      const double slender = roots[mode] * gyration;
      // Clamped-free bars: of the order of (gyration root)^2 (1 + E/(kappa G)).
      const double correction = slender * slender * (1.0 + 2.0 / shear);
      EXPECT_NEAR(coarse[2 * mode + plane] / fine[2 * mode + plane], 1.0, 0.01) << mode;
      EXPECT_NEAR(fine[2 * mode + plane] / euler, 1.0, 0.002 + correction) << mode;
    }
  }
}

void expect_same_model(const BasisData& a, const BasisData& b, double tolerance) {
  ASSERT_EQ(a.lambda.size(), b.lambda.size());
  EXPECT_LE((a.lambda - b.lambda).norm(), tolerance * a.lambda.norm());
  const auto map = [](const std::vector<double>& values) {
    return Eigen::VectorXd::Map(values.data(), std::ssize(values));
  };
  EXPECT_LE((map(a.cubic) - map(b.cubic)).norm(), tolerance * map(a.cubic).norm());
  EXPECT_LE((map(a.quartic) - map(b.quartic)).norm(), tolerance * map(a.quartic).norm());
  ASSERT_EQ(a.surface.vertex_ids, b.surface.vertex_ids);
  EXPECT_LE((a.surface.rows - b.surface.rows).norm(), tolerance * a.surface.rows.norm());
  ASSERT_EQ(a.interior.vertex_ids, b.interior.vertex_ids);
  EXPECT_LE((a.interior.rows - b.interior.rows).norm(), tolerance * a.interior.rows.norm());
}

TEST_F(Quadratic, EveryRankAndSolverMakesTheSameModel) {
  const BasisData alone = made(good() + "--surface-subdivide on");
  const std::string three = kMayBeRoot + "mpiexec --oversubscribe -n 3 ";
  expect_same_model(alone, made(good() + "--surface-subdivide on", three), 1e-7);
  expect_same_model(alone, made(good() + "--surface-subdivide on --solver mumps"), 1e-7);
  expect_same_model(alone, made(good() + "--surface-subdivide on --solver iterative"), 1e-5);
}

TEST_F(Quadratic, AFreeBodyOfSeveralMaterialsAndPointMassesIsOneOnRanksToo) {
  const std::string options =
      "block.veg --order 2 --young 1e6 --poisson 0.3 --density 1000 --fix none "
      "--point-mass 'x>0.99=5' --linear-modes 4 --modes 8 ";
  const nlohmann::json report = report_of(options);
  EXPECT_EQ(report["rigid_modes"], 6);
  EXPECT_NEAR(report["total_mass_kg"].get<double>(), 1000 * 0.31 * 0.23 + 5, 1e-9);
  expect_same_model(made(options), made(options, kMayBeRoot + "mpiexec --oversubscribe -n 2 "),
                    1e-6);
}

TEST_F(Quadratic, TheDrawnBoundaryMayUseTheEdgePointsAndTheEnergyDoesNotCare) {
  const BasisData plain = made(good() + "--surface-subdivide off");
  const BasisData fine = made(good() + "--surface-subdivide on");
  EXPECT_EQ(fine.triangles.size(), 4 * plain.triangles.size());
  EXPECT_EQ(fine.quartic, plain.quartic);
  // A closed surface of the sphere's kind: vertices - edges + faces = 2.
  EXPECT_EQ(std::ssize(fine.surface.vertex_ids) - std::ssize(fine.triangles) / 2, 2);
  // The rows of an edge point are those of its position: between its ends in a motion that is slow
  // along the edge, and not the control value.
  ASSERT_TRUE(Model::from_data(fine));
}

TEST_F(Quadratic, ModesInAVtuAreReadAgainAsTheMeshTheyWereMadeOn) {
  const BasisData first = made(good() + "--modes-vtu modes.vtu");
  const BasisData second = made(good("auto", "modes.vtu"));
  EXPECT_EQ(second.edges.size(), first.edges.size());
  expect_same_model(first, second, 0.0);
  const BasisData linear = made(good("1", "modes.vtu"));
  EXPECT_EQ(linear.vertex_count, block_.vertices.size());
  expect_same_model(linear, made(good("1")), 0.0);
}

TEST_F(Quadratic, TheReferenceFindsItsOwnMatricesInTheBasis) {
  const std::string load = "--load-at 'x>0.99' --load-force 0,0.6,-1 ";
  const std::string solid = std::string("block.veg --order 2 ") + kSolid + load;
  EXPECT_EQ(made(solid + "--linear-modes 6 --modes 20").lambda.size(), 20);
  // The reference assembles M and K independently and refuses a basis that does not fit them to
  // 1e-6.
  const ProgramResult statics =
      run("reference " + solid + "--static --compare made.tremolo --json");
  ASSERT_EQ(statics.code, 0) << statics.err;
  const nlohmann::json report = nlohmann::json::parse(statics.out);
  EXPECT_EQ(report["order"], 2);
  EXPECT_LE(report["comparison"]["error_of_largest"].get<double>(), 0.01);
  const ProgramResult motion =
      run("reference " + solid +
          "--load sine --step 0.01 --duration 0.3 --compare made.tremolo --json");
  ASSERT_EQ(motion.code, 0) << motion.err;
  const nlohmann::json moved = nlohmann::json::parse(motion.out);
  EXPECT_LE(moved["energy_drift_max"].get<double>(), 1e-6);
  EXPECT_LE(moved["comparison"]["error_of_largest"].get<double>(), 0.05);
  const ProgramResult linear = run(std::string("reference block.veg --order 1 ") + kSolid + load +
                                   "--static --compare made.tremolo");
  EXPECT_EQ(linear.code, 3);
  EXPECT_NE(linear.err.find("order 2"), std::string::npos) << linear.err;
}

// The mesh's error against the deflection near the tip on the mesh and on the refined one. Under a
// small load both shapes are equal, and the error of one is that of the other.
TEST_F(Quadratic, TheErrorBudgetIsThatOfTheTipOnARefinedMesh) {
  TetMesh fine = block_;
  ASSERT_TRUE(add_edge_points(fine));
  write_veg(folder_ + "/fine.veg", refined_mesh(fine));
  // All vertices of the free end, which keep their numbers when the mesh is refined.
  std::string ids;
  for (std::size_t v = 0; v < block_.vertices.size(); ++v)
    if (block_.vertices[v].x() > 0.99) ids += (ids.empty() ? "" : ",") + std::to_string(v);
  const std::string load = "--load-at vertex:" + ids + " --load-force 0,0.01,-0.02 ";
  const auto tip = [&](const std::string& mesh, const std::string& order) {
    const ProgramResult found = run("reference " + mesh + " --order " + order + " " + kSolid +
                                    load + "--static --probe near:0.83,0.155,0.115 --json");
    EXPECT_EQ(found.code, 0) << found.err;
    const auto u = nlohmann::json::parse(found.out)["probes"][0]["displacement"];
    return std::hypot(u[0].get<double>(), u[1].get<double>(), u[2].get<double>());
  };
  for (const char* order : {"1", "2"}) {
    const nlohmann::json budget = report_of(good(order) + load + "--error-budget")["error_budget"];
    const double off = 1.0 - tip("block.veg", order) / tip("fine.veg", order);
    EXPECT_NEAR(budget["discretisation"].get<double>() / off, 1.0, 0.25) << order;
    EXPECT_NEAR(budget["discretisation_limit"].get<double>(),
                budget["discretisation"].get<double>() * 4 / 3, 1e-12);
    EXPECT_GT(budget["reduction"].get<double>(), 0.0);
    EXPECT_LT(budget["reduction"].get<double>(), 0.2);
    EXPECT_GT(budget["integration"].get<double>(), 0.0);
    EXPECT_LT(budget["integration"].get<double>(), 0.2);
    EXPECT_TRUE(budget["not_measured"].empty()) << budget;
    if (order == std::string("1")) {
      EXPECT_EQ(budget["spend_on"], "discretisation");
    }
  }
  EXPECT_TRUE(report_of(good())["error_budget"].is_null());
}

TEST_F(Quadratic, AnErrorBudgetNeedsALoadAndOneProcess) {
  EXPECT_EQ(run(good() + "--error-budget -o made.tremolo").code, 3);
  EXPECT_EQ(run(good() + "--load-at 'x>0.99' --load-force 0,0,1 --error-budget -o made.tremolo",
                kMayBeRoot + "mpiexec --oversubscribe -n 2 ")
                .code,
            2);
  EXPECT_FALSE(std::filesystem::exists(folder_ + "/made.tremolo"));
}

TEST_F(Quadratic, WhatDoesNotGoTogetherIsRefused) {
  const ProgramResult lumped = run(good() + "--mass lumped -o out.tremolo");
  EXPECT_EQ(lumped.code, 2);
  EXPECT_NE(lumped.err.find("lumped"), std::string::npos) << lumped.err;
  EXPECT_FALSE(std::filesystem::exists(folder_ + "/out.tremolo"));
  const ProgramResult third = run(good("3") + "-o out.tremolo");
  EXPECT_EQ(third.code, 2);
  EXPECT_NE(third.err.find("--order"), std::string::npos) << third.err;
}

// One tetrahedron whose first edge has its point at that position.
std::string quadratic_msh(const std::string& first_middle) {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 "
         "1\n5 " +
         first_middle +
         "\n6 0.5 0.5 0\n7 0 0.5 0\n8 0 0 0.5\n9 0 0.5 0.5\n10 0.5 0 0.5\n$EndNodes\n$Elements\n1\n"
         "1 11 2 1 1 1 2 3 4 5 6 7 8 9 10\n$EndElements\n";
}

TEST_F(Quadratic, CurvedEdgesAreToldAndPointsOfNoEdgeRefused) {
  const std::string options = " --fix 'x<0.1' --linear --linear-modes 2 ";
  const auto with = [&](const std::string& middle, const std::string& order) {
    std::ofstream(folder_ + "/one.msh") << quadratic_msh(middle);
    std::filesystem::remove(folder_ + "/out.tremolo");
    return run("one.msh --order " + order + options + "-o out.tremolo");
  };
  const ProgramResult straight = with("0.5 0 0", "2");
  EXPECT_EQ(straight.code, 0) << straight.err;
  EXPECT_EQ(straight.err.find("curved"), std::string::npos) << straight.err;
  const ProgramResult curved = with("0.5 -0.1 0", "2");
  EXPECT_EQ(curved.code, 0) << curved.err;
  EXPECT_NE(curved.err.find("1 of 6 edges of the file are curved, by up to 10 % of their length "
                            "(vertex 4): they are straightened"),
            std::string::npos)
      << curved.err;
  const ProgramResult misplaced = with("0.5 -0.6 0", "2");
  EXPECT_EQ(misplaced.code, 3);
  EXPECT_NE(misplaced.err.find("vertex 4 stands for the edge between vertices 0 and 1"),
            std::string::npos)
      << misplaced.err;
  EXPECT_FALSE(std::filesystem::exists(folder_ + "/out.tremolo"));
  EXPECT_EQ(with("0.5 -0.6 0", "1").code, 0);
}

TEST_F(Quadratic, WhatDoesNotFitMemoryIsToldWithWhatWould) {
  const ProgramResult refused = run(good() + "--memory 60MB -o out.tremolo");
  EXPECT_EQ(refused.code, 1) << refused.err;
  EXPECT_NE(refused.err.find("quadratic tetrahedra would fit, or linear ones, --order 1"),
            std::string::npos)
      << refused.err;
}

// Against a file with the refined mesh, whose fixed side the same selector finds.
TEST_F(Quadratic, RefiningIsAFileOfTheRefinedMesh) {
  TetMesh fine = block_;
  ASSERT_TRUE(add_edge_points(fine));
  write_veg(folder_ + "/fine.veg", refined_mesh(fine));
  for (const char* order : {"1", "2"}) {
    const nlohmann::json refined = report_of(good(order) + "--refine 1");
    const nlohmann::json file = report_of(good(order, "fine.veg"));
    EXPECT_EQ(refined["elements"], 8 * block_.tetrahedra.size());
    EXPECT_EQ(refined["dofs"], file["dofs"]);
    EXPECT_NEAR(refined["total_mass_kg"].get<double>(), 1000 * 0.31 * 0.23, 1e-9);
    for (std::size_t i = 0; i < 5; ++i)
      EXPECT_NEAR(
          refined["frequencies_hz"][i].get<double>() / file["frequencies_hz"][i].get<double>(), 1.0,
          1e-9);
  }
  EXPECT_EQ(report_of(good("1") + "--refine 2")["elements"], 64 * block_.tetrahedra.size());
}

TEST_F(Quadratic, WhatSelectorsChoseHoldsOnARefinedMesh) {
  // The first cells end at x = 1/6: the middles of their edges lie in the half-space, their ends do
  // not.
  const std::string options =
      "block.veg --order 1 --young 1e6 --linear --linear-modes 3 --refine 1 ";
  const nlohmann::json narrow = report_of(options + "--fix 'x<0.001'");
  const nlohmann::json wide = report_of(options + "--fix 'x<0.1'");
  EXPECT_EQ(narrow["dofs"], wide["dofs"]);
  EXPECT_EQ(narrow["frequencies_hz"], wide["frequencies_hz"]);
  // A stiff half, whose border is that of the mesh as it is given; on two ranks too.
  const std::string half =
      options + "--fix 'x<0.001' --material 'x<0.6: young=1e8' -o made.tremolo";
  const ProgramResult one = run(half + " --json");
  const ProgramResult two = run(half + " --json", kMayBeRoot + "mpiexec --oversubscribe -n 2 ");
  ASSERT_EQ(one.code, 0) << one.err;
  ASSERT_EQ(two.code, 0) << two.err;
  const auto first = nlohmann::json::parse(one.out), second = nlohmann::json::parse(two.out);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(
        first["frequencies_hz"][i].get<double>() / second["frequencies_hz"][i].get<double>(), 1.0,
        1e-8);
  EXPECT_GT(first["frequencies_hz"][0].get<double>(),
            1.5 * narrow["frequencies_hz"][0].get<double>());
}

TEST_F(Quadratic, AReferenceIsRefinedAlike) {
  const std::string load = "--load-at 'x>0.99' --load-force 0,0.01,-0.02 ";
  made(good("1") + load + "--refine 1");
  const std::string reference = std::string("reference block.veg --order 1 ") + kSolid + load +
                                "--static --compare made.tremolo --json ";
  const ProgramResult same = run(reference + "--refine 1");
  ASSERT_EQ(same.code, 0) << same.err;
  EXPECT_LE(nlohmann::json::parse(same.out)["comparison"]["error_of_largest"].get<double>(), 0.02);
  EXPECT_EQ(run(reference).code, 3);
  EXPECT_EQ(run(reference + "--refine 2").code, 3);
}

TEST_F(Quadratic, NumbersOfRefinementsThatMakeNoSenseAreRefused) {
  for (const char* number : {"-1", "6", "1.5", "x"}) {
    const ProgramResult refused =
        run(good() + "--refine " + std::string(number) + " -o out.tremolo");
    EXPECT_EQ(refused.code, 2) << number;
    EXPECT_NE(refused.err.find("from 0 to 5"), std::string::npos) << refused.err;
    EXPECT_FALSE(std::filesystem::exists(folder_ + "/out.tremolo"));
  }
}

// A config file made for a nonlinear model may say how modes are derived.
TEST_F(Quadratic, LinearOverrulesTheDerivativesOfAConfigFile) {
  std::ofstream(folder_ + "/model.toml") << "derivatives = 2\n";
  EXPECT_EQ(report_of("block.veg --config model.toml --linear --linear-modes 5 --fix 'x<0.1'")["r"],
            5);
  const ProgramResult both = run(good("1") + "--linear --derivatives 2 -o out.tremolo");
  EXPECT_EQ(both.code, 2);
  EXPECT_NE(both.err.find("--linear excludes --derivatives"), std::string::npos) << both.err;
}

}  // namespace
}  // namespace tremolo
