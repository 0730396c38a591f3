// An artist's surface through both programs: in with --render, out unchanged but moved.

#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/basis/basis_reader.h"
#include "formats/basis/basis_writer.h"
#include "tests/support/frames/bar_skin.h"
#include "tests/support/meshes/rigged_files.h"
#include "tests/support/programs.h"
#include "tests/support/text_lines.h"

namespace tremolo {
namespace {

using nlohmann::json;
using testing::kBar;
using testing::lines_with;

std::vector<Eigen::Vector3d> points(const std::string& obj) {
  std::vector<Eigen::Vector3d> found;
  for (const std::string& line : lines_with(obj, "v")) {
    std::istringstream stream(line.substr(2));
    found.emplace_back();
    stream >> found.back()[0] >> found.back()[1] >> found.back()[2];
  }
  return found;
}

class RenderProgram : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = testing::fresh_folder();
    made_ = testing::make_drawn_bar(folder_);
  }
  void SetUp() override { ASSERT_EQ(made_.code, 0) << made_.err; }

  static ProgramResult run(const std::string& command) { return run_program(folder_, command); }
  static void expect_failure(const ProgramResult& result, int code,
                             const std::vector<std::string>& words) {
    EXPECT_EQ(result.code, code) << result.err;
    for (const std::string& word : words)
      EXPECT_NE(result.err.find(word), std::string::npos) << word << " in " << result.err;
  }

  static inline std::string folder_;
  static inline ProgramResult made_;
};

TEST_F(RenderProgram, TheMakerSaysHowItLies) {
  EXPECT_NE(made_.err.find("outside, the farthest by 0.0015 m"), std::string::npos) << made_.err;
}

TEST_F(RenderProgram, InspectShowsIt) {
  const ProgramResult result = run(kTremolo + "inspect bar.tremolo --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  EXPECT_EQ(report["format_version"], "1.4");
  EXPECT_EQ(report["render"]["triangles"], 12);
  EXPECT_EQ(report["render"]["objects"], json({"sides", "foot", "tip"}));
  EXPECT_EQ(report["render"]["materials"], json({"rubber", "steel"}));
  EXPECT_EQ(report["render"]["uvs"], true);
  EXPECT_EQ(report["fixed_vertices"], 9) << "the mesh's end at the foot";
  EXPECT_EQ(report["default_load"]["vertices"].size(), 3u);
  EXPECT_EQ(report["provenance"]["render"]["file"], "skin.obj");
  const ProgramResult text = run(kTremolo + "inspect bar.tremolo");
  EXPECT_NE(text.out.find("objects: sides, foot, tip"), std::string::npos) << text.out;
}

TEST_F(RenderProgram, AnObjComesOutWithAllThatItHad) {
  const ProgramResult result = run(kTremolo +
                                   "run bar.tremolo --load none --duration 0.01 --out rest "
                                   "--surfaces 1 --surface-format obj");
  ASSERT_EQ(result.code, 0) << result.err;
  const std::string obj = slurp(folder_ + "/rest/surface-0000-t0.009000s.obj");
  EXPECT_EQ(lines_with(obj, "f").size(), 12u);
  EXPECT_EQ(lines_with(obj, "o"), (std::vector<std::string>{"o sides", "o foot", "o tip"}));
  EXPECT_EQ(lines_with(obj, "usemtl"),
            (std::vector<std::string>{"usemtl rubber", "usemtl steel", "usemtl steel"}));
  EXPECT_EQ(lines_with(obj, "mtllib"), std::vector<std::string>{"mtllib surface.mtl"});
  EXPECT_EQ(lines_with(slurp(folder_ + "/rest/surface.mtl"), "newmtl"),
            (std::vector<std::string>{"newmtl rubber", "newmtl steel"}));
  EXPECT_EQ(lines_with(obj, "v").size(), 8u) << "the file's vertices, not those split by normals";
  EXPECT_EQ(lines_with(obj, "vt").size(), 24u) << "three faces meet at each";
  EXPECT_EQ(lines_with(obj, "vn").size(), 24u);
  const BoundingBox box = bounding_box(points(obj));
  // Written with nine digits.
  EXPECT_LE((box.low - Eigen::Vector3d(-0.0005, -0.001, -0.001)).norm(), 5e-8);
  EXPECT_LE((box.high - Eigen::Vector3d(0.4005, 0.051, 0.061)).norm(), 5e-8);
}

TEST_F(RenderProgram, ItMovesWithTheSolid) {
  const ProgramResult result = run(kTremolo +
                                   "run bar.tremolo --load constant --duration 0.3 --out moved "
                                   "--surfaces 1 --surface-format obj --probe 80 --json");
  ASSERT_EQ(result.code, 0) << result.err;
  double lowest = 0;
  for (const Eigen::Vector3d& x : points(slurp(folder_ + "/moved/surface-0000-t0.300000s.obj"))) {
    lowest = std::min(lowest, x.z() + 0.001);
    // The foot, half a millimetre outside the fixed vertices.
    if (x.x() < 0) {
      EXPECT_LE(std::abs(x.z() - (x.z() > 0.03 ? 0.061 : -0.001)), 2e-3);
    }
  }
  EXPECT_LT(lowest, -1e-3) << "the tip goes down";
}

TEST_F(RenderProgram, EveryFormatAndTheHullAreWritten) {
  for (const char* format : {"ply", "inc"}) {
    const ProgramResult result =
        run(kTremolo + "run bar.tremolo --load none --duration 0.01 --out " + format +
            " --surfaces 1 --surface-format " + format);
    ASSERT_EQ(result.code, 0) << result.err;
    const std::string text = slurp(folder_ + "/" + format + "/surface-0000-t0.009000s." + format);
    EXPECT_NE(text.find(std::string(format) == "ply" ? "property float s" : "uv_vectors"),
              std::string::npos);
  }
  const ProgramResult hull = run(kTremolo +
                                 "run bar.tremolo --load none --duration 0.01 --out hull --hull "
                                 "--surfaces 1 --surface-format obj");
  ASSERT_EQ(hull.code, 0) << hull.err;
  EXPECT_EQ(lines_with(slurp(folder_ + "/hull/surface-0000-t0.009000s.obj"), "v").size(), 74u)
      << "81 vertices, 7 of them inside";
}

TEST_F(RenderProgram, SelectPrintsWhatASelectorFinds) {
  ProgramResult result = run(kPrecompute + "bar.veg --select 'x<=0%'");
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out.substr(0, 46), "9 vertices from (0, 0, 0) to (0, 0.05, 0.06) m");
  result = run(kPrecompute + "bar.veg --render skin.obj --unit cm --select tip");
  EXPECT_EQ(result.out.substr(0, 10), "9 vertices") << result.out << result.err;
  result = run(kTremolo + "inspect bar.tremolo --select fixed");
  EXPECT_EQ(result.out.substr(0, 46), "9 vertices from (0, 0, 0) to (0, 0.05, 0.06) m");
  result = run(kTremolo + "inspect bar.tremolo --select 'near:0.4,0.05,0.06' --json");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(json::parse(result.out)["vertices"], json({80}));
}

TEST_F(RenderProgram, ASelectorThatFindsNothingShowsWhatThereIs) {
  expect_failure(run(kPrecompute + kBar + "-o no.tremolo --fix 'x<-1'"), 3,
                 {"x<-1", "(0.4, 0.05, 0.06)", "not painted"});
  expect_failure(run(kTremolo + "inspect bar.tremolo --select 'sphere:1,1,1,0.1'"), 3,
                 {"(0.4, 0.05, 0.06)", "`foot`", "`loaded`", "`steel`"});
  expect_failure(run(kTremolo + "inspect bar.tremolo --select head"), 2, {"`foot`"});
  expect_failure(run(kTremolo + "inspect bar.tremolo --select vertex:40"), 3,
                 {"40", "not on the boundary"});
  EXPECT_FALSE(std::filesystem::exists(folder_ + "/no.tremolo"));
}

TEST_F(RenderProgram, ALoadMayActOnASelection) {
  const std::string run_short = kTremolo + "run bar.tremolo --duration 0.1 --json ";
  const ProgramResult selected = run(run_short + "--at loaded --force 0,0,-1");
  const ProgramResult stored = run(run_short);
  ASSERT_EQ(selected.code, 0) << selected.err;
  EXPECT_NEAR(json::parse(selected.out)["energy_final"].get<double>(),
              json::parse(stored.out)["energy_final"].get<double>(), 1e-12);
  expect_failure(run(run_short + "--at fixed --force 0,0,-1"), 3, {"--at fixed", "moves"});
  expect_failure(run(run_short + "--at nowhere --force 0,0,-1"), 2, {"nowhere", "`tip`"});
}

TEST_F(RenderProgram, PaintSelects) {
  std::ofstream ply(folder_ + "/paint.ply");
  ply << "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
         "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
         "element face 2\nproperty list uchar int vertex_indices\nend_header\n";
  for (const double x : {0.0, 0.4})
    for (const double y : {0.0, 0.05})
      ply << x << " " << y << " 0.06 " << (x > 0 ? "0 0 255" : "255 0 0") << "\n";
  ply << "3 0 2 3\n3 0 3 1\n";
  ply.close();
  const std::string paint = "bar.veg --render paint.ply --unit m --select ";
  const ProgramResult red = run(kPrecompute + paint + "'colour:red'");
  // Vertices look at the paint above them, the two inside are bare; 64 of 255 are a quarter of 0.4
  // m.
  EXPECT_TRUE(
      red.out.starts_with("25 vertices from (0, 0, 0) to (0.1, 0.05, 0.06) m: 0 1 2 9 10 11 "))
      << red.out << red.err;
  expect_failure(run(kPrecompute + paint + "'colour:green'"), 3, {"#ff0000", "#0000ff"});
}

TEST_F(RenderProgram, WrongUseIsSaid) {
  expect_failure(
      run(kPrecompute + kBar + "-o no.tremolo --fix 'x<=0' --render skin.obj --unit inch"), 2,
      {"inch", "mm, cm, m"});
  expect_failure(run(kPrecompute + kBar + "--fix 'x<=0'"), 2, {"--output"});
  expect_failure(run(kPrecompute + kBar + "-o no.tremolo --fix 'x<=0' --render nothing.obj"), 1,
                 {"nothing.obj"});
  expect_failure(run(kPrecompute + kBar + "-o skin.obj --fix 'x<=0' --render skin.obj"), 2,
                 {"take the place", "--render"});
}

}  // namespace

// A skinned surface through both programs: its bones, weights and motion move a body.

namespace {

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

// Names in a basis file are somebody else's; those of bones and clips reach the terminal as text.
TEST_F(RigProgram, EscapeCodesInNamesOfBonesAndClipsAreShownAsText) {
  Result<BasisData> data = read_basis(folder_ + "/box.tremolo");
  ASSERT_TRUE(data) << data.error().message;
  auto rig = std::make_shared<SurfaceRig>(*data->render->surface.rig);
  rig->bones[0].name = "a\033[2Jb";
  rig->clips[0].name = "c\033[2Jd";
  data->render->surface.rig = rig;
  ASSERT_TRUE(write_basis(folder_ + "/hostile.tremolo", *data));
  const ProgramResult result = run(kTremolo + "inspect hostile.tremolo");
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out.find('\033'), std::string::npos);
  EXPECT_NE(result.out.find("a\\x1b[2Jb"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("c\\x1b[2Jd"), std::string::npos) << result.out;
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
