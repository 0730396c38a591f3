// VegaFEM's files through both programs: an imported model has the forces of the .cub and is
// exported byte for byte.
#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/basis/basis_reader.h"
#include "formats/mesh/mesh_reader.h"
#include "runtime/model.h"
#include "tests/support/meshes/box_mesh.h"
#include "tests/support/meshes/mesh_file.h"
#include "tests/support/meshes/vega_files.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

using namespace testing;

const std::string kTremolo = TREMOLO_BIN_DIR "/tremolo ";

class Vega : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fresh_folder();
    write_veg(folder_ + "/block.veg", mesh_);
    std::ofstream(folder_ + "/block.vegb", std::ios::binary) << vegb_bytes(mesh_);
  }

  ProgramResult run(const std::string& command) { return run_program(folder_, command); }
  void expect_success(const std::string& command) {
    const ProgramResult result = run(command);
    ASSERT_EQ(result.code, 0) << command << "\n" << result.err;
  }
  std::string bytes(const std::string& name) { return slurp(folder_ + "/" + name); }

  // model.tremolo, model.cub and model.U, of Tremolo's own.
  void make_model(const std::string& mass) {
    expect_success(kPrecompute + "block.veg -o model.tremolo --fix 'x<0.001' --linear-modes 4 " +
                   "--modes 8 --density 1100 --order 1 --mass " + mass);
    expect_success(kTremolo + "export model.tremolo --cub model.cub --U model.U");
  }

  // The model's forces against those of a .cub: y = R q, R from the two bases.
  void expect_same_forces(const std::string& model, const std::string& cub,
                          const Eigen::MatrixXd& from) {
    const auto loaded = Model::load(folder_ + "/" + model);
    ASSERT_TRUE(loaded) << loaded.error().message;
    const Potential& potential = (*loaded)->potential();
    const Eigen::Index r = potential.size();
    Eigen::MatrixXd rows(from.rows(), r);
    for (VertexId v = 0; v < static_cast<VertexId>(mesh_.vertices.size()); ++v)
      rows.middleRows(3 * Eigen::Index{v}, 3) = (*loaded)->vertex(v)->rows;
    const Eigen::MatrixXd change = from.colPivHouseholderQr().solve(rows);
    const ForceRows forces = parse_cub(bytes(cub));
    PotentialWorkspace workspace = potential.make_workspace();
    Evaluation here = potential.make_evaluation();
    for (unsigned seed = 0; seed < 5; ++seed) {
      // Some vertex moves by a tenth of the block.
      Eigen::VectorXd q = random_vector(r, 1.0, seed).cwiseQuotient(potential.lambda().cwiseSqrt());
      const Eigen::VectorXd moved = rows * q;
      q *= 0.05 / moved.cwiseAbs().maxCoeff();
      potential.evaluate(q, kWantForce, workspace, here);
      const Eigen::VectorXd expected =
          change.transpose() * evaluate_rows(forces, Eigen::VectorXd(change * q));
      EXPECT_LE((here.force - expected).norm(), 1e-12 * expected.norm());
    }
  }

  // U of a file made by `export`, without the product's reader.
  Eigen::MatrixXd parse_u(const std::string& name) {
    const std::string file = bytes(name);
    std::int32_t counts[2];
    std::memcpy(counts, file.data(), sizeof(counts));
    EXPECT_EQ(file.size(), 8 + 8 * static_cast<std::size_t>(counts[0] * counts[1]));
    Eigen::MatrixXd basis(counts[0], counts[1]);
    std::memcpy(basis.data(), file.data() + 8, file.size() - 8);
    return basis;
  }

  TetMesh mesh_ = box_mesh({4, 2, 2}, {0.4, 0.15, 0.2});
  std::string folder_;
};

TEST_F(Vega, AModelExportedAndImportedIsTheSameModelAndGivesTheSameBytes) {
  make_model("lumped");
  ASSERT_FALSE(HasFatalFailure());
  const ProgramResult result = run(kPrecompute +
                                   "block.vegb --import-basis model.U --import-cubic model.cub "
                                   "--density 1100 -o again.tremolo --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const auto report = nlohmann::json::parse(result.out);
  EXPECT_EQ(report["import"]["mass"], "lumped");
  EXPECT_LE(report["import"]["lumped_orthonormality_error"], 1e-9);
  EXPECT_LE(report["import"]["force_error"], 1e-13);
  EXPECT_NE(result.err.find("orthonormal in the lumped mass"), std::string::npos) << result.err;
  const auto first = read_basis(folder_ + "/model.tremolo");
  const auto second = read_basis(folder_ + "/again.tremolo");
  ASSERT_TRUE(first && second);
  EXPECT_EQ(second->lambda, first->lambda);
  EXPECT_EQ(second->surface.rows, first->surface.rows);
  EXPECT_EQ(second->interior.rows, first->interior.rows);
  EXPECT_EQ(second->fixed_vertices, first->fixed_vertices);
  EXPECT_EQ(second->triangles, first->triangles);
  expect_same_forces("again.tremolo", "model.cub", parse_u("model.U"));
  expect_success(kTremolo + "export again.tremolo --cub again.cub --U again.U");
  EXPECT_EQ(bytes("again.cub"), bytes("model.cub"));
  EXPECT_EQ(bytes("again.U"), bytes("model.U"));
  expect_success(kTremolo + "run again.tremolo --at 4 --force 0,0,1 --duration 0.01");
  expect_success(kTremolo + "inspect again.tremolo");
}

TEST_F(Vega, ATurnedModelHasTheSameForcesAndGivesTheSameBytes) {
  make_model("lumped");
  ASSERT_FALSE(HasFatalFailure());
  const Eigen::MatrixXd turned = parse_u("model.U") * random_turn(8, 2);
  const StrainModel springs = random_strain_model(spread_omega(8, 60, 900), 0.5, 3);
  std::ofstream(folder_ + "/turned.U", std::ios::binary) << basis_file(turned);
  std::ofstream(folder_ + "/turned.cub", std::ios::binary)
      << cub_file(turned_forces(springs, random_turn(8, 7)));
  expect_success(kPrecompute +
                 "block.veg --import-basis turned.U --import-cubic turned.cub --density 1100 "
                 "-o turned.tremolo --modes-vtu turned.vtu");
  expect_same_forces("turned.tremolo", "turned.cub", turned);
  expect_success(kTremolo + "export turned.tremolo --cub out.cub --U out.U --vtu surface.vtu");
  EXPECT_EQ(bytes("out.cub"), bytes("turned.cub"));
  EXPECT_EQ(bytes("out.U"), bytes("turned.U"));
  const auto file = read_tet_mesh(folder_ + "/turned.vtu");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->mesh.vertices, mesh_.vertices);
  EXPECT_EQ(file->mesh.tetrahedra.size(), mesh_.tetrahedra.size());
  EXPECT_NE(bytes("surface.vtu").find("mode_08"), std::string::npos);
}

TEST_F(Vega, ABasisOfTheConsistentMassIsToldWhenItIsExported) {
  make_model("consistent");
  ASSERT_FALSE(HasFatalFailure());
  const ProgramResult result = run(kTremolo + "export model.tremolo --U consistent.U");
  EXPECT_EQ(result.code, 0);
  EXPECT_NE(result.err.find("consistent mass"), std::string::npos) << result.err;
  const ProgramResult import = run(kPrecompute +
                                   "block.veg --import-basis model.U --import-cubic model.cub "
                                   "--density 1100 -o again.tremolo");
  EXPECT_EQ(import.code, 0) << import.err;
  EXPECT_NE(import.err.find("orthonormal in the consistent mass"), std::string::npos) << import.err;
}

TEST_F(Vega, WrongUsageIsToldAndLeavesTheOldFiles) {
  make_model("lumped");
  ASSERT_FALSE(HasFatalFailure());
  const std::string old = bytes("model.tremolo");
  const std::string exported = kTremolo + "export ";
  const std::string import = kPrecompute + "block.veg --import-basis model.U ";
  for (const auto& [command, code] : std::initializer_list<std::pair<std::string, int>>{
           {exported + "model.tremolo", 2},
           {exported + "model.tremolo --cub model.tremolo", 2},
           {exported + "model.tremolo --cub a --U ./a", 2},
           {exported + "block.veg --cub a.cub", 3},
           {exported + "none --cub a.cub", 1},
           {exported + "model.tremolo --cub nowhere/a.cub", 1},
           {import + "-o a.tremolo", 2},
           {import + "--import-cubic model.cub --modes 3 -o a.tremolo", 2},
           {import + "--import-cubic model.cub -o model.U", 2},
           {import + "--import-cubic model.cub -o a.tremolo --modes-vtu block.veg", 2},
           {import + "--import-cubic model.U -o a.tremolo", 3},
           {import + "--import-cubic none.cub -o a.tremolo", 1},
       })
    EXPECT_EQ(run(command).code, code) << command;
  const ProgramResult density = run(import + "--import-cubic model.cub -o model.tremolo");
  EXPECT_EQ(density.code, 3);
  EXPECT_NE(density.err.find("--density"), std::string::npos) << density.err;
  EXPECT_EQ(bytes("model.tremolo"), old);
  EXPECT_EQ(bytes("a.tremolo"), "");
}

}  // namespace
}  // namespace tremolo
