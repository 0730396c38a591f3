// A skinned surface through both programs: its bones, weights and motion move a body.
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/meshes/rigged_files.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

using nlohmann::json;

class RigProgram : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = testing::fresh_folder();
    write_veg(folder_ + "/box.veg", box_mesh({2, 3, 6}, {1, 2, 3}));
    std::ofstream(folder_ + "/box.gltf") << testing::rigged_gltf();
    made_ = run(kPrecompute +
                "box.veg --render box.gltf -o box.tremolo --fix 'x<1%' --young 1e7 --density 500 "
                "--linear-modes 3 --modes 3 --order 1");
    write_scene("scene.toml", "rig = true\n");
  }
  void SetUp() override { ASSERT_EQ(made_.code, 0) << made_.err; }

  static ProgramResult run(const std::string& command) { return run_program(folder_, command); }
  static void write_scene(const std::string& name, const std::string& keys) {
    std::ofstream(folder_ + "/" + name)
        << "duration = 1\nstep = 0.01\n[[bodies]]\nname = \"box\"\n"
           "model = \"box.tremolo\"\nkind = \"driven\"\nbeta = 0.01\n"
        << keys;
  }
  // The chunk of JSON of a .glb.
  static json glb_json(const std::string& name) {
    const std::string bytes = slurp(folder_ + "/" + name);
    const std::size_t end = bytes.find("BIN", 20);
    return json::parse(bytes.substr(20, end == std::string::npos ? end : end - 4 - 20), nullptr,
                       false);
  }

  static inline std::string folder_;
  static inline ProgramResult made_;
};

TEST_F(RigProgram, TheModelHasTheBonesOfItsSurface) {
  const ProgramResult result = run(kTremolo + "inspect box.tremolo --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const json rig = json::parse(result.out)["render"]["rig"];
  EXPECT_EQ(rig["bones"], json({"hip.L", "knee joint"}));
  EXPECT_EQ(rig["clips"][0]["name"], "bend");
  EXPECT_EQ(rig["clips"][0]["end"], 1.0);
}

TEST_F(RigProgram, TheBodyMovesAsItsSurfaceDidAndTheGlbNamesItsBones) {
  const ProgramResult result =
      run(kTremolo + "run scene.toml --out moved --surfaces 1 --surface-format obj");
  ASSERT_EQ(result.code, 0) << result.err;
  std::istringstream obj(slurp(folder_ + "/moved/box/surface-0000-t1.000000s.obj"));
  // The corner (1, 2, 3) is bent about x through (0, 0, 1.5) to (1, -1.5, 3.5); the body is stiff.
  double nearest = 1e9;
  for (std::string line; std::getline(obj, line);) {
    std::istringstream words(line);
    std::string word;
    Eigen::Vector3d x;
    if (words >> word >> x[0] >> x[1] >> x[2] && word == "v")
      nearest = std::min(nearest, (x - Eigen::Vector3d(1, -1.5, 3.5)).norm());
  }
  EXPECT_LT(nearest, 0.05) << "what a soft body lags behind in the last moments";
  const ProgramResult exported = run(kTremolo + "export scene.toml --rate 10 --glb box.glb");
  ASSERT_EQ(exported.code, 0) << exported.err;
  const json glb = glb_json("box.glb");
  std::vector<std::string> joints;
  for (const auto& joint : glb["skins"][0]["joints"])
    joints.push_back(glb["nodes"][joint.get<std::size_t>()]["name"]);
  EXPECT_EQ(joints, (std::vector<std::string>{"hip.L", "knee joint"}));
}

TEST_F(RigProgram, AClipThatIsNotThereAndARigOfNothingAreRefused) {
  write_scene("clip.toml", "rig = true\nclip = \"walk\"\n");
  ProgramResult result = run(kTremolo + "run clip.toml --out none");
  EXPECT_EQ(result.code, 3) << result.err;
  EXPECT_NE(result.err.find("there is no 'walk'; the render surface has 'bend'"), std::string::npos)
      << result.err;
  write_scene("named.toml", "rig = true\nclip = \"bend\"\n");
  EXPECT_EQ(run(kTremolo + "run named.toml --duration 0.1 --out named").code, 0);
  write_scene("fixed.toml", "clip = \"bend\"\n");
  result = run(kTremolo + "run fixed.toml --out none");
  EXPECT_EQ(result.code, 3) << result.err;
  EXPECT_NE(result.err.find("rig = true"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace tremolo
