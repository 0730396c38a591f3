// Meshes of other programs through tremolo-precompute: one body, one lowest frequency.
#include <cmath>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

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

TEST_F(ForeignMesh, MergeIsRefusedWhereItHasNothingToDo) {
  write("cube.stl", "solid x\nendsolid x\n");
  const ProgramResult surface =
      run_program(folder_, kPrecompute + "cube.stl --fix none --merge -o out.tremolo");
  EXPECT_EQ(surface.code, 2) << surface.err;
  EXPECT_NE(surface.err.find("--merge applies to a tetrahedral mesh"), std::string::npos);
}

}  // namespace
}  // namespace tremolo
