// Meshes of other programs through tremolo-precompute: one body, one lowest frequency.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "runtime/model.h"
#include "tests/support/meshes/writer_forms.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

using testing::WriterForm;

constexpr const char* kSolid =
    " --order 1 --linear --linear-modes 2 --fix 'x<1%' --young 1e6 --poisson 0.3 --density 1000 "
    "--threads 1 -o out.tremolo --json";

class ForeignMesh : public ::testing::Test {
 protected:
  void SetUp() override { folder_ = fresh_folder(); }
  void write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder_ + "/" + name, std::ios::binary) << bytes;
  }
  nlohmann::json report(const std::string& arguments) {
    const ProgramResult result =
        run_program(folder_, kMayBeRoot + kPrecompute + arguments + kSolid);
    EXPECT_EQ(result.code, 0) << arguments << "\n" << result.err;
    return nlohmann::json::parse(result.out, nullptr, false);
  }
  double lowest(const std::string& arguments) {
    const nlohmann::json found = report(arguments);
    return found.is_object() ? found["frequencies_hz"][0].get<double>() : 0;
  }
  std::string folder_;
};

TEST_F(ForeignMesh, OfEveryWriterHasTheSameLowestFrequency) {
  write_veg(folder_ + "/bar.veg", testing::FormBar().mesh);
  const double expected = lowest("bar.veg");
  ASSERT_GT(expected, 0);
  for (const WriterForm& form : testing::all_writer_forms()) {
    for (const auto& [name, bytes] : form.files) write(name, bytes);
    // Another order of the vertices changes the last digits; Gmsh's Nastran has six decimals, which
    // hold the bar's coordinates.
    EXPECT_NEAR(lowest(form.files.front().first), expected, 1e-9 * expected)
        << form.writer << ", " << form.form;
  }
}

// The bar in two regions with separate vertices at their interface.
std::string doubled_bar() {
  const testing::FormBar bar;
  std::string nodes, elements;
  std::map<std::pair<int, VertexId>, int> ids;
  for (std::size_t t = 0; t < bar.half.size(); ++t) {
    elements += std::to_string(t + 1) + " 4 2 " + std::to_string(1 + bar.half[t]) + " 1";
    for (const VertexId v : bar.mesh.tetrahedra[t]) {
      const auto [entry, fresh] =
          ids.try_emplace({bar.half[t], v}, static_cast<int>(ids.size()) + 1);
      if (fresh)
        nodes += std::to_string(entry->second) + " " + testing::join(bar.mesh.vertices[v]) + "\n";
      elements += " " + std::to_string(entry->second);
    }
    elements += "\n";
  }
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + std::to_string(ids.size()) + "\n" +
         nodes + "$EndNodes\n$Elements\n" + std::to_string(bar.half.size()) + "\n" + elements +
         "$EndElements\n";
}

TEST_F(ForeignMesh, WithDoubledNodesIsOneBodyOnceItIsMerged) {
  write_veg(folder_ + "/bar.veg", testing::FormBar().mesh);
  write("doubled.msh", doubled_bar());
  const double expected = lowest("bar.veg");
  EXPECT_NEAR(lowest("doubled.msh --merge"), expected, 1e-9 * expected);
  // Nine vertices of the interface; the message names the free half, and says what to do.
  const ProgramResult apart =
      run_program(folder_, kMayBeRoot + kPrecompute + "doubled.msh" + kSolid);
  EXPECT_EQ(apart.code, 3) << apart.err;
  EXPECT_NE(apart.err.find("9 pairs of vertices coincide"), std::string::npos) << apart.err;
  EXPECT_NE(apart.err.find("--merge joins them"), std::string::npos) << apart.err;
}

// A list of two files, each a half of the bar.
TEST_F(ForeignMesh, InPiecesOfFilesIsOneBodyOnceItIsMerged) {
  write_veg(folder_ + "/bar.veg", testing::FormBar().mesh);
  const std::string both = testing::form_vtu(
      {testing::VtuForm::Compression::kNone, testing::VtuForm::Place::kText, false, 2});
  const std::size_t first = both.find("<Piece"), second = both.find("<Piece", first + 1);
  write("a_0.vtu", both.substr(0, second) + both.substr(both.find("</UnstructuredGrid>")));
  write("a_1.vtu", both.substr(0, first) + both.substr(second));
  write("a.pvtu",
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PUnstructuredGrid\">\n<PUnstructuredGrid>\n"
        "<Piece Source=\"a_0.vtu\"/>\n<Piece Source=\"a_1.vtu\"/>\n"
        "</PUnstructuredGrid>\n</VTKFile>\n");
  const double expected = lowest("bar.veg");
  EXPECT_NEAR(lowest("a.pvtu --merge"), expected, 1e-9 * expected);
  const ProgramResult apart = run_program(folder_, kMayBeRoot + kPrecompute + "a.pvtu" + kSolid);
  EXPECT_EQ(apart.code, 3) << apart.err;
  EXPECT_NE(apart.err.find("9 pairs of vertices coincide"), std::string::npos) << apart.err;
  // No output takes the place of a piece.
  const ProgramResult kept = run_program(
      folder_, kMayBeRoot + kPrecompute + "a.pvtu --merge --modes-vtu a_1.vtu" + kSolid);
  EXPECT_EQ(kept.code, 2) << kept.err;
}

TEST_F(ForeignMesh, MergeIsRefusedWhereItHasNothingToDo) {
  write("cube.stl", "solid x\nendsolid x\n");
  const ProgramResult surface =
      run_program(folder_, kPrecompute + "cube.stl --fix none --merge -o out.tremolo");
  EXPECT_EQ(surface.code, 2) << surface.err;
  EXPECT_NE(surface.err.find("--merge applies to a tetrahedral mesh"), std::string::npos);
}

}  // namespace

// Every sample model, held nowhere, falls on a floor with all that a scene does not say left at its
// default: with and without damping.

namespace {

using nlohmann::json;

class DroppedSample : public ::testing::TestWithParam<const char*> {};

TEST_P(DroppedSample, EndsWellAndBalances) {
  const std::string name = GetParam(), folder = fresh_folder();
  const std::string assets = TREMOLO_SOURCE_DIR "/assets/";
  const ProgramResult made = run_program(
      folder, kMayBeRoot + kPrecompute + assets + "meshes/" + name + ".msh --config " + assets +
                  "models/" + name + ".toml --fix none --order 1 --linear-modes 6 --modes 12 " +
                  "-o free.tremolo");
  ASSERT_EQ(made.code, 0) << made.err;
  const Result<Model::Pointer> model = Model::load(folder + "/free.tremolo");
  ASSERT_TRUE(model) << model.error().message;
  double lowest = 0.0;
  for (const Eigen::Vector3d& x : (*model)->surface().rest) lowest = std::min(lowest, x.z());
  for (const char* damping : {"", "alpha = 0.5\nbeta = 0.001\n"}) {
    std::ofstream(folder + "/scene.toml")
        << "duration = 1\ngravity = [0, 0, -9.81]\n[[bodies]]\nname = \"" << name
        << "\"\nmodel = \"free.tremolo\"\nkind = \"free\"\nposition = [0, 0, " << 0.1 - lowest
        << "]\n"
        << damping << "[[colliders]]\nname = \"floor\"\nshape = \"plane\"\n";
    const ProgramResult result = run_program(folder, kTremolo + "run scene.toml --json");
    ASSERT_EQ(result.code, 0) << result.err;
    const json report = json::parse(result.out);
    const json& body = report["bodies"][0];
    EXPECT_LE(report["energy_balance_error"].get<double>(), 1e-8) << damping;
    EXPECT_GT(body["contacts"].get<int>(), 0) << damping;
    // A point goes by half a margin at most beyond the surface, 0.25 % of the size, if the step
    // resolves the impact; not by ten times that.
    EXPECT_LT(body["penetration_max"].get<double>(), 0.025) << damping;
    EXPECT_LT(body["largest_displacement_share"].get<double>(), 0.5) << damping;
  }
}

INSTANTIATE_TEST_SUITE_P(Samples, DroppedSample,
                         ::testing::Values("beam", "basket", "bridge", "horse", "tower", "heart"),
                         [](const auto& sample) { return std::string(sample.param); });

}  // namespace
}  // namespace tremolo
