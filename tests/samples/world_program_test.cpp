// `tremolo run` of scenes with [[bodies]], as a user meets them: on a small block, fixed and free,
// and the scenes of assets/.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/samples/shipped_scene.h"
#include "tests/support/programs.h"
#include "tests/support/text_lines.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::shipped_scene;

class WorldProgram : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    models_ = testing::fresh_folder();
    testing::write_veg(models_ + "/bar.veg", box_mesh({6, 2, 2}, {0.4, 0.05, 0.06}));
    const std::string common = TREMOLO_BIN_DIR
        "/tremolo-precompute bar.veg --young 2e6 --density 1000 --load-at 'x>0.399' --load-force "
        "0,0,-1 --linear-modes 5 --modes 9 --order 1 ";
    for (const char* what : {"--fix 'x<0.001' -o held.tremolo", "--fix none -o free.tremolo"}) {
      const ProgramResult made = run_program(models_, common + what);
      ASSERT_EQ(made.code, 0) << made.err;
    }
  }

  void SetUp() override { folder_ = fresh_folder(); }

  static std::string body(const std::string& name, const std::string& kind,
                          const std::string& keys = "") {
    return "[[bodies]]\nname = \"" + name + "\"\nkind = \"" + kind + "\"\nmodel = \"" + models_ +
           (kind == "free" ? "/free" : "/held") + ".tremolo\"\n" + keys;
  }

  ProgramResult run(const std::string& scene, const std::string& flags = "") {
    std::ofstream(folder_ + "/scene.toml") << scene;
    return run_program(folder_, kTremolo + "run scene.toml " + flags);
  }

  static inline std::string models_;
  std::string folder_;
};

const char* const kShaken =
    "load = \"square\"\nbeta = 0.001\n[[bodies.motion]]\nkind = \"shake\"\namplitude = [0.01, 0, "
    "0.01]\n"
    "frequency = 3\nduration = 1\n[[bodies.motion]]\nkind = \"spin\"\naxis = [0, 0, 1]\nrate = 4\n"
    "start = 0.2\n";
const char* const kThrown = "position = [0, 0, 2]\nvelocity = [1, 0, 0]\nspin = [1, 2, 8]\n";

TEST_F(WorldProgram, TellsWhatScriptsRelyOn) {
  const ProgramResult result =
      run("duration = 1.2\ngravity = [0, 0, -9.81]\n" + body("shaken", "driven", kShaken) +
              body("thrown", "free", kThrown) + body("still", "fixed"),
          "--json");
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  EXPECT_EQ(report["scene"], "scene.toml");
  EXPECT_EQ(report["steps"], 400);
  EXPECT_EQ(report["exit_code"], 0);
  ASSERT_EQ(report["bodies"].size(), 3U);
  for (const json& one : report["bodies"]) {
    for (const char* when : {"_initial", "_final"}) {
      EXPECT_EQ(one[std::string("position") + when].size(), 3U);
      EXPECT_EQ(one[std::string("quaternion") + when].size(), 4U);
      EXPECT_EQ(one[std::string("linear_momentum") + when].size(), 3U);
      EXPECT_EQ(one[std::string("angular_momentum") + when].size(), 3U);
    }
    double given = 0.0;
    for (const char* cause :
         {"load", "support", "gravity", "contact", "friction", "restitution", "damping", "hand"})
      given += one["energy_by_cause"][cause].get<double>();
    const double change = one["energy_final"].get<double>() - one["energy_initial"].get<double>();
    EXPECT_NEAR(change, given, 1e-11 * one["energy_max"].get<double>()) << one["body"];
    EXPECT_LE(one["energy_balance_error"].get<double>(), 1e-11) << one["body"];
    EXPECT_EQ(one["penetration_max"], 0.0);
    EXPECT_EQ(one["asleep"], false);
    EXPECT_EQ(one["steps"], 400);
  }
  const json& shaken = report["bodies"][0];
  EXPECT_EQ(shaken["body"], "shaken");
  EXPECT_EQ(shaken["kind"], "driven");
  EXPECT_NE(shaken["energy_by_cause"]["support"], 0.0);
  EXPECT_NE(shaken["energy_by_cause"]["load"], 0.0);
  EXPECT_LT(shaken["energy_by_cause"]["damping"].get<double>(), 0.0);
  const json& thrown = report["bodies"][1];
  EXPECT_NEAR(thrown["position_initial"][2].get<double>(), 2.0, 1e-12);
  EXPECT_LT(thrown["position_final"][2].get<double>(), 0.0);
}

TEST_F(WorldProgram, WritesAFolderABody) {
  const ProgramResult result =
      run("duration = 0.3\n" + body("shaken", "driven", kShaken) + body("thrown", "free", kThrown),
          "--out made --every 10 --surfaces 2 --json");
  ASSERT_EQ(result.code, 0) << result.err;
  std::set<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder_ + "/made"))
    if (entry.is_regular_file())
      files.insert(fs::relative(entry.path(), folder_ + "/made").string());
  EXPECT_EQ(files, (std::set<std::string>{"report.json", "shaken/frames.csv", "shaken/run.csv",
                                          "shaken/surface-0000-t0.150000s.ply",
                                          "shaken/surface-0001-t0.300000s.ply", "thrown/frames.csv",
                                          "thrown/run.csv", "thrown/surface-0000-t0.150000s.ply",
                                          "thrown/surface-0001-t0.300000s.ply"}));
  EXPECT_EQ(json::parse(std::ifstream(folder_ + "/made/report.json")), json::parse(result.out));
  const auto table = testing::all_lines(testing::slurp(folder_ + "/made/thrown/run.csv"));
  ASSERT_EQ(table.size(), 1U + 11U);
  EXPECT_EQ(table[0],
            "t,kinetic,potential,total,high_band,work,dissipated,load,support,gravity,contact,"
            "friction,damping,x,y,z,qw,qx,qy,qz,px,py,pz,lx,ly,lz,restitution,hand,"
            "contact_energy,contact_force,joint,contact_fx,contact_fy,contact_fz,"
            "hand_fx,hand_fy,hand_fz");
}

TEST_F(WorldProgram, OrderOfBodiesChangesNothing) {
  const std::string one = body("a", "driven", kShaken), two = body("b", "free", kThrown);
  const ProgramResult forth = run("duration = 0.6\n" + one + two, "--json");
  const ProgramResult back = run("duration = 0.6\n" + two + one, "--json");
  ASSERT_EQ(forth.code + back.code, 0) << forth.err << back.err;
  const json a = json::parse(forth.out), b = json::parse(back.out);
  EXPECT_EQ(a["bodies"][0], b["bodies"][1]);
  EXPECT_EQ(a["bodies"][1], b["bodies"][0]);
}

TEST_F(WorldProgram, RefusesBeforeAnythingIsWritten) {
  const auto refused = [this](const std::string& scene, int code, const std::string& words,
                              const std::string& flags = "") {
    const ProgramResult result = run(scene, "--out made " + flags);
    EXPECT_EQ(result.code, code) << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    EXPECT_NE(result.err.find(flags.empty() ? "scene.toml" : "--"), std::string::npos);
    EXPECT_FALSE(fs::exists(folder_ + "/made")) << words;
  };
  const std::string keys =
      "[[bodies.motion]]\nkind = \"keyframes\"\ninterpolation = \"linear\"\n"
      "keys = [[0.1, 0, 0, 0], [0.1, 1, 0, 0]]\n";
  refused(body("a", "driven", keys), 3, "its pose jumps at t = 0.1 s by 1 m");
  refused(body("a", "driven", "integrator = \"verlet\"\n"), 3, "is not moved by 'verlet'");
  refused(body("a", "free", "at = \"vertex:999999\"\nforce = [1, 0, 0]\nload = \"sine\"\n"), 3,
          "body 'a'");
  refused(body("a", "driven", "probe = \"nothing\"\n"), 3, "body 'a': --probe");
  refused("[[bodies]]\nname = \"a\"\nmodel = \"none.tremolo\"\nmade-by = \"./demo\"\n", 1,
          "there is no such basis file; make it with `./demo`");
  refused(body("a", "fixed", "mass = 3\n"), 3, "line 5: body 'a': unknown key 'mass'");
  refused(body("a", "fixed"), 2, "--load applies only to one body", "--load none");
  refused(body("a", "fixed"), 2, "unknown integrator", "--integrator euler");
  refused(body("a", "fixed"), 3, "duration must be positive", "--duration -1");
  refused("[[bodies]]\nname = \"a\"\nkind = \"free\"\nmodel = \"" + models_ + "/held.tremolo\"\n",
          3, "--fix none");
}

const char* const kFloor =
    "[[colliders]]\nname = \"floor\"\nshape = \"plane\"\nfriction = 0.4\nrestitution = 0.5\n";
const char* const kHand =
    "[[hands]]\nbody = \"held\"\nat = \"near:0.4,0,0\"\nstiffness = 50\nuntil = 0.6\n"
    "[[hands.motion]]\nkind = \"glide\"\nvelocity = [0, 0.05, 0]\nstart = 0\nstop = 0.4\n";

// Contact is solved to 1e-10 of the momenta in a step.
TEST_F(WorldProgram, TellsWhatContactAndHandsGaveAndTook) {
  const ProgramResult result =
      run("duration = 1.2\ngravity = [0, 0, -9.81]\n" +
              body("thrown", "free", "position = [0, 0, 0.1]\nspin = [1, 0, 2]\nbeta = 0.001\n") +
              body("held", "driven", "position = [2, 0, 1]\n") + kFloor + kHand,
          "--json --out made");
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  for (const json& one : report["bodies"]) {
    double given = 0.0;
    for (const auto& [cause, value] : one["energy_by_cause"].items()) given += value.get<double>();
    const double change = one["energy_final"].get<double>() - one["energy_initial"].get<double>();
    EXPECT_NEAR(change, given, 1e-8 * one["energy_max"].get<double>()) << one["body"];
    EXPECT_LE(one["energy_balance_error"].get<double>(), 1e-8) << one["body"];
    EXPECT_LT(one["penetration_max"].get<double>(), 0.02);
  }
  const json &thrown = report["bodies"][0], &held = report["bodies"][1];
  EXPECT_GT(thrown["contacts"].get<int>(), 0);
  EXPECT_LT(thrown["energy_by_cause"]["friction"].get<double>(), 0.0);
  EXPECT_LT(thrown["energy_by_cause"]["restitution"].get<double>(), 0.0);
  EXPECT_EQ(held["contacts"], 0);
  EXPECT_NE(held["energy_by_cause"]["hand"], 0.0);
}

// A bar that would be behind a plate a step later: 0.18 m at once.
TEST_F(WorldProgram, AThinPlateStopsWhatIsShotAtIt) {
  const std::string plate =
      "[[colliders]]\nname = \"plate\"\nshape = \"box\"\nhalf-extents = [2, 2, 0.003]\n";
  // Near the plate at the start: only then is there a point whose speed counts.
  const std::string place = "position = [0, 0, 0.02]\nvelocity = [0, 0, ";
  for (const int speed : {1, 60}) {
    const ProgramResult result = run(
        "duration = 0.03\n" + body("shot", "free", place + std::to_string(-speed) + "]\n") + plate,
        "--json");
    ASSERT_EQ(result.code, 0) << result.err;
    const json report = json::parse(result.out);
    const json& shot = report["bodies"][0];
    EXPECT_DOUBLE_EQ(report["contact_speed_limit"].get<double>(), 1.0);
    const bool fast = speed > 1;
    EXPECT_EQ(shot["passed_through"], 0);
    EXPECT_EQ(result.err.find("went through"), std::string::npos) << result.err;
    EXPECT_NEAR(shot["contact_speed_max"].get<double>(), speed, fast ? 0.2 * speed : 0.1);
  }
}

TEST_F(WorldProgram, ThreadsChangeNoByte) {
  std::string scene = "gravity = [0, 0, -9.81]\n" + std::string(kFloor);
  for (int k = 0; k < 6; ++k)
    scene += body("thrown-" + std::to_string(k), "free",
                  "position = [" + std::to_string(k) + ", 0, 0.1]\nspin = [1, 2, 8]\n");
  for (const char* threads : {"1", "2", "4"})
    ASSERT_EQ(
        run(scene, std::string("--duration 0.3 --save saved-") + threads + " --threads " + threads)
            .code,
        0);
  const auto bytes = [this](const std::string& name) {
    std::stringstream text;
    text << std::ifstream(folder_ + "/" + name, std::ios::binary).rdbuf();
    return text.str();
  };
  EXPECT_GT(bytes("saved-1").size(), 1000U);
  EXPECT_EQ(bytes("saved-1"), bytes("saved-2"));
  EXPECT_EQ(bytes("saved-1"), bytes("saved-4"));
}

TEST_F(WorldProgram, TellsWhichBodyBeginsInsideACollider) {
  const ProgramResult result = run(body("sunk", "free", "position = [0, 0, -0.02]\n") + kFloor);
  EXPECT_EQ(result.code, 3);
  EXPECT_NE(result.err.find("body 'sunk': it begins 0.02 m ("), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("inside collider 'floor'"), std::string::npos) << result.err;
}

TEST_F(WorldProgram, RunsTheScenesThatAreShipped) {
  for (const char* name :
       {"tumbling", "shaken-tower", "stopped-horse", "dropped-heart", "pulled-horse", "bells",
        "walking-horse", "necklace", "stacked-baskets"}) {
    const ProgramResult result = run(shipped_scene(name), "--json");
    ASSERT_EQ(result.code, 0) << name << result.err;
    const json report = json::parse(result.out);
    // Contact is solved to 1e-10 of the momenta in a step.
    bool touches = false;
    for (const json& body : report["bodies"]) touches |= body["contacts"].get<int>() > 0;
    EXPECT_LE(report["energy_balance_error"].get<double>(), touches ? 1e-8 : 1e-11) << name;
    double share = 0.0;
    for (const json& body : report["bodies"])
      share = std::max(share, body["largest_displacement_share"].get<double>());
    EXPECT_GT(share, 0.02) << name;
    // The stopped horse bends most, by 0.4 of its size.
    EXPECT_LT(share, 0.45) << name;
  }
}

// Plates on soft balls with a weight of twice their mass on top: it settles and sleeps where it was
// built. The balls are pressed by what they carry and roll a little.
TEST_F(WorldProgram, AStackOfRigidAndSoftBodiesRests) {
  const ProgramResult result = run(shipped_scene("mixed-stack"), "--json");
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  EXPECT_LE(report["energy_balance_error"].get<double>(), 1e-9);
  int rigid = 0;
  for (const json& body : report["bodies"]) {
    rigid += body["kind"] == "rigid" ? 1 : 0;
    EXPECT_TRUE(body["asleep"].get<bool>()) << body["body"];
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(body["position_final"][axis].get<double>(),
                  body["position_initial"][axis].get<double>(), 0.015)
          << body["body"];
  }
  EXPECT_EQ(rigid, 3);
}

TEST_F(WorldProgram, ThrownRigidBodiesBounceOffASoftHorse) {
  const ProgramResult result = run(shipped_scene("struck-horse"), "--json --duration 2");
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  EXPECT_LE(report["energy_balance_error"].get<double>(), 1e-8);
  for (const json& body : report["bodies"]) EXPECT_GT(body["contacts"].get<int>(), 0);
  // The light ball comes back.
  const json& light = report["bodies"][1];
  EXPECT_GT(light["linear_momentum_initial"][1].get<double>(), 0.0);
  EXPECT_LT(light["linear_momentum_final"][1].get<double>(), 0.0);
}

// Ducks and a mat of tetrahedra, a reduced ball and a rigid one: all have met something then.
TEST_F(WorldProgram, DucksAndBallsFallOnATrampoline) {
  const ProgramResult result = run(shipped_scene("trampoline-ducks"), "--json --duration 0.25");
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  ASSERT_EQ(report["bodies"].size(), 5U);
  EXPECT_LE(report["energy_balance_error"].get<double>(), 1e-8);
  double given = 0.0;
  for (const json& body : report["bodies"]) {
    const double contact = body["energy_by_cause"]["contact"].get<double>();
    EXPECT_NE(contact, 0.0) << body["body"];
    given += contact;
  }
  EXPECT_LE(report["momentum_error"].get<double>(), 1e-10);
  // All contact is between these bodies: of about 1 J that they exchange nothing is left over.
  EXPECT_LE(std::abs(given), 1e-8);
}

// The first layers have reached the floor then, and each other.
TEST_F(WorldProgram, PoursTwoHundredBalls) {
  const ProgramResult result = run(shipped_scene("poured"), "--json --duration 0.15");
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  ASSERT_EQ(report["bodies"].size(), 200U);
  EXPECT_LE(report["energy_balance_error"].get<double>(), 1e-8);
  int contacts = 0;
  for (const json& body : report["bodies"]) {
    contacts += body["contacts"].get<int>();
    // Contacts of some milliseconds at 1.5 m/s, of columns of balls: 3.6 mm of one of 60 mm.
    EXPECT_LE(body["penetration_max"].get<double>(), 0.07) << body["body"];
  }
  EXPECT_GE(contacts, 50);
  EXPECT_NE(result.err.find("and 188 more bodies"), std::string::npos) << result.err;
}

// A run divided into two by --save and --restore writes the same rows, and the same file at the
// end; a state of another scene is refused, and nothing is written.
TEST_F(WorldProgram, ARunThatWasSavedGoesOnWithTheSameBits) {
  const std::string scene =
      "gravity = [0, 0, -9.81]\n" + body("shaken", "driven", kShaken) +
      body("thrown", "free", "position = [0, 0, 0.5]\nspin = [1, 2, 8]\n") +
      "[[colliders]]\nname = \"floor\"\nshape = \"plane\"\nposition = [0, 0, -0.1]\n";
  const std::string columns = " --coordinate all --velocities ";
  ASSERT_EQ(run(scene, "--duration 1.2 --out whole --save whole.saved" + columns).code, 0);
  ASSERT_EQ(run(scene, "--duration 0.45 --save cut.saved").code, 0);
  const ProgramResult rest = run(
      scene, "--duration 1.2 --restore cut.saved --out rest --save rest.saved --json" + columns);
  ASSERT_EQ(rest.code, 0) << rest.err;
  EXPECT_EQ(json::parse(rest.out)["steps"], 400);
  const auto text_of = [this](const std::string& name) {
    std::ostringstream text;
    text << std::ifstream(folder_ + "/" + name, std::ios::binary).rdbuf();
    return text.str();
  };
  EXPECT_EQ(text_of("whole.saved"), text_of("rest.saved"));
  for (const char* name : {"shaken", "thrown"}) {
    const std::string whole = text_of(std::string("whole/") + name + "/run.csv");
    std::string tail = text_of(std::string("rest/") + name + "/run.csv");
    tail.erase(0, tail.find('\n') + 1);
    EXPECT_GT(tail.size(), 1'000U);
    EXPECT_TRUE(whole.ends_with(tail)) << name;
  }
  const ProgramResult other =
      run("gravity = [0, 0, -9]\n" + scene.substr(scene.find('\n') + 1),
          "--duration 1.2 --restore cut.saved --out never --save never.saved");
  EXPECT_EQ(other.code, 3) << other.err;
  EXPECT_NE(other.err.find("another step or gravity"), std::string::npos) << other.err;
  EXPECT_FALSE(fs::exists(folder_ + "/never.saved"));
  EXPECT_EQ(run(scene, "--duration 0.3 --restore cut.saved").code, 3);
  EXPECT_EQ(run(scene, "--restore cut.saved --save cut.saved").code, 2);
  EXPECT_EQ(run(scene, "--restore none.saved").code, 1);
}

}  // namespace
}  // namespace tremolo
