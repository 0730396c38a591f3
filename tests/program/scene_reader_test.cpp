// Scene files: reading, and messages about errors.
#include "runtime/io/scenes/scene_reader.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/apps/tremolo/world/world_commands.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

const std::string kBody = "[[bodies]]\nname = \"a\"\nmodel = \"m.tremolo\"\n";
const std::string kDriven = kBody + "kind = \"driven\"\n";

SceneFile read_scene_text(const std::string& text, const std::string& path = "folder/s.toml") {
  Result<SceneFile> file = parse_world(text, path);
  EXPECT_TRUE(file) << (file ? "" : file.error().message);
  return file ? *file : SceneFile{};
}

void expect_refused(const std::string& text, const std::string& words,
                    const std::string& path = "folder/s.toml") {
  const Result<SceneFile> file = parse_world(text, path);
  ASSERT_FALSE(file) << text;
  EXPECT_EQ(file.error().kind, ErrorKind::kContent);
  EXPECT_NE(file.error().message.find(words), std::string::npos) << file.error().message;
  EXPECT_EQ(file.error().message.find(path), 0U) << file.error().message;
}

// Each text is refused with the words next to it.
void expect_refused(std::initializer_list<std::pair<std::string, std::string>> texts) {
  for (const auto& [text, words] : texts) expect_refused(text, words);
}

TEST(SceneReader, KnowsAWorldByItsBodies) {
  EXPECT_TRUE(*is_world(kBody, "s.toml"));
  EXPECT_FALSE(*is_world("[horse]\nmodel = \"a\"\n", "s.toml"));
  EXPECT_FALSE(*is_world("[bodies]\nmodel = \"a\"\n", "s.toml"));
  EXPECT_FALSE(is_world("[", "s.toml"));
}

// toml++ would read true as 1.
TEST(SceneReader, ABoolIsNoNumberAndANumberIsNoBool) {
  for (const char* key :
       {"probe = true", "probe = [0, true]", "coordinate = true", "modes = true",
        "tolerance = true", "max-iterations = false", "split = true", "position = [true, 0, 0]",
        "copies = [2, true, 1]", "contact-points = true", "friction = true", "linear = 1",
        "hull = 0", "alpha = true", "alpha = [[0, true]]"})
    expect_refused(kBody + key + "\n", std::string(key).substr(0, std::string(key).find(' ')));
  for (const char* key : {"step = true", "duration = true", "gravity = [0, 0, true]",
                          "every = true", "surfaces = true", "plot = 1"})
    expect_refused(std::string(key) + "\n" + kBody,
                   std::string(key).substr(0, std::string(key).find(' ')));
  for (const char* key : {"step = true", "duration = true", "probe = true", "modes = true",
                          "linear = 1", "scale = true", "velocities = 0", "every = true"}) {
    const auto bodies = parse_scene("[a]\nmodel = \"m\"\n" + std::string(key) + "\n", "s.toml");
    ASSERT_FALSE(bodies) << key;
    EXPECT_NE(bodies.error().message.find("line 3"), std::string::npos) << bodies.error().message;
  }
}

TEST(SceneReader, ReadsBodies) {
  const SceneFile file = read_scene_text(
      "step = 1e-3\nduration = 2\ngravity = [0, 1, -9.5]\nout = \"there\"\nsurfaces = 3\n"
      "surface-format = \"obj\"\n" +
      kBody +
      "kind = \"free\"\nintegrator = \"ep2\"\nalpha = 0.5\nbeta = 1e-3\ntolerance = 1e-8\n"
      "max-iterations = 7\nmodes = 4\nlinear = true\nposition = [1, 2, 3]\n"
      "turn = [0, 0, 2, 90]\nvelocity = [1, 0, 0]\nspin = [0, 5, 0]\nprobe = [3, \"x>0\"]\n"
      "coordinate = \"all\"\nvelocities = true\nload = \"square\"\nat = 17\nforce = [1, 2, 3]\n"
      "scale = 2\n[[bodies]]\nname = \"b\"\nmodel = \"/n\"\nstart = \"static\"\n"
      "[[bodies.loads]]\nat = \"z>1\"\nforce = [0, 0, 1]\n[[bodies.loads]]\nload = \"sine\"\n");
  EXPECT_EQ(file.scene.step, 1e-3);
  EXPECT_EQ(file.scene.gravity.at(1.0), Vector3d(0.0, 1.0, -9.5));
  EXPECT_EQ(file.outputs.out, "there");
  EXPECT_EQ(file.outputs.surface_format, "obj");
  ASSERT_EQ(file.scene.bodies.size(), 2U);
  const SceneBody& a = file.scene.bodies[0];
  EXPECT_EQ(a.model, "folder/m.tremolo");
  EXPECT_EQ(a.kind, FrameKind::kFree);
  EXPECT_EQ(a.integrator, "ep2");
  EXPECT_EQ(a.options.alpha, 0.5);
  EXPECT_EQ(a.options.max_iterations, 7);
  EXPECT_EQ(a.model_options.modes, 4);
  EXPECT_TRUE(a.model_options.linear);
  EXPECT_NEAR(a.pose.rotation.z(), std::sqrt(0.5), 1e-15);
  EXPECT_EQ(a.pose.position, Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(a.velocity, Vector3d(1.0, 0.0, 0.0));
  EXPECT_EQ(a.spin, Vector3d(0.0, 5.0, 0.0));
  EXPECT_EQ(a.columns.probes, (std::vector<std::string>{"3", "x>0"}));
  ASSERT_EQ(a.loads.size(), 1U);
  EXPECT_EQ(a.loads[0].at, "17");
  EXPECT_EQ(a.loads[0].force, Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(a.loads[0].scale, 2.0);
  const SceneBody& b = file.scene.bodies[1];
  EXPECT_EQ(b.model, "/n");
  EXPECT_EQ(b.kind, FrameKind::kFixed);
  EXPECT_EQ(b.integrator, "ep4");
  EXPECT_TRUE(b.settled);
  ASSERT_EQ(b.loads.size(), 2U);
  EXPECT_EQ(b.loads[0].signal.kind, SignalKind::kSquare);
  EXPECT_EQ(b.loads[1].signal.kind, SignalKind::kSine);
}

TEST(SceneReader, ReadsDampingRatiosAsTextsAndNumbers) {
  const auto ratios_of = [](const std::string& value) {
    return read_scene_text(kBody + "damping-ratio = " + value + "\n").scene.bodies[0].options;
  };
  const std::vector<double> one = {0.02}, two = {0.02, 0.01};
  EXPECT_EQ(ratios_of("\"2%\"").ratios.of_modes, one);
  EXPECT_EQ(ratios_of("0.02").ratios.of_modes, one);
  EXPECT_EQ(ratios_of("\"2%,1%\"").ratios.of_modes, two);
  EXPECT_EQ(ratios_of("[0.02, 0.01]").ratios.of_modes, two);
  EXPECT_EQ(ratios_of("\"1:2%,10:1%,30:5%\"").ratios.table.size(), 3U);
  const IntegratorOptions rayleigh = ratios_of("\"1:2%,30:5%\"");
  EXPECT_FALSE(rayleigh.ratios.of_each_mode());
  EXPECT_GT(rayleigh.alpha, 0.0);
  EXPECT_GT(rayleigh.beta, 0.0);
  for (const char* value : {"true", "\"2%%\"", "-0.1", "nan", "1", "[]", "[0.1, 1.5]", "\"\"",
                            "\"2%\"\nalpha = 1", "\"2%\"\nbeta = 1e-3"})
    expect_refused(kBody + "damping-ratio = " + value + "\n", "damping-ratio");
}

TEST(SceneReader, ReadsMotions) {
  const SceneFile file = read_scene_text(
      kDriven +
      "[[bodies.motion]]\nkind = \"shake\"\namplitude = [0.1, 0, 0]\nfrequency = 4\nstart = 1\n"
      "duration = 3\n[[bodies.motion]]\nkind = \"spin\"\naxis = [0, 0, 1]\nrate = 2\n"
      "[[bodies.motion]]\nkind = \"glide\"\nvelocity = [1, 0, 0]\nstop = 2\nramp = 0.2\n"
      "[[bodies.motion]]\nkind = \"fall\"\nacceleration = [0, 0, -9]\nstop = 1\n"
      "[[bodies.motion]]\nkind = \"keyframes\"\ninterpolation = \"linear\"\n"
      "keys = [[0, 0, 0, 0], [1, 1, 0, 0]]\n");
  const std::vector<MotionPart>& parts = file.scene.bodies[0].motion.parts;
  ASSERT_EQ(parts.size(), 5U);
  const auto& shake = std::get<ShakeMotion>(parts[0]);
  EXPECT_EQ(shake.course.start, 1.0);
  EXPECT_EQ(shake.course.ramp, 0.25);  // a period
  EXPECT_EQ(shake.course.end, 3.75);   // the ramp down ends at 4
  EXPECT_EQ(std::get<SpinMotion>(parts[1]).course.start, kSinceEver);
  EXPECT_EQ(std::get<GlideMotion>(parts[2]).course.end, 2.0);
  EXPECT_EQ(std::get<FallMotion>(parts[3]).course.start, 0.0);
  EXPECT_EQ(std::get<KeyframeMotion>(parts[4]).interpolation, Interpolation::kLinear);
}

TEST(SceneReader, ReadsCollidersAndHands) {
  const SceneFile file = read_scene_text(
      kBody +
      "contact = false\ncontact-points = 50\ncontact-margin = 0.01\ncontact-stiffness = 4\n"
      "[[colliders]]\nname = \"floor\"\nshape = \"plane\"\nposition = [0, 0, -1]\n"
      "turn = [1, 0, 0, 90]\nfriction = 0.7\nrestitution = 0\n[[colliders.motion]]\n"
      "kind = \"glide\"\nvelocity = [1, 0, 0]\n[[colliders]]\nname = \"pill\"\n"
      "shape = \"capsule\"\nradius = 2\nhalf-length = 3\n[[colliders]]\nname = \"brick\"\n"
      "shape = \"box\"\nhalf-extents = [1, 2, 3]\n[[colliders]]\nname = \"rock\"\n"
      "shape = \"mesh\"\nfile = \"rock.collider\"\nmade-by = \"./demo\"\n"
      "[[hands]]\nbody = \"a\"\nat = 17\nstiffness = 100\ndamping = 2\n"
      "position = [1, 2, 3]\nfrom = 0.5\nuntil = 2\n[[hands.motion]]\nkind = \"spin\"\n"
      "axis = [0, 0, 1]\nrate = 1\n[[hands]]\nbody = \"a\"\nat = \"near:0,0,0\"\n"
      "stiffness = 1\n[[hands]]\nbody = \"a\"\nat = 3\npin = true\n");
  ASSERT_EQ(file.scene.bodies.size(), 1U);
  const SceneBody& body = file.scene.bodies[0];
  EXPECT_FALSE(body.feels_contact);
  EXPECT_EQ(body.contact.points, 50);
  EXPECT_EQ(body.contact.margin, 0.01);
  EXPECT_EQ(body.contact.stiffness, 4.0);
  ASSERT_EQ(file.scene.colliders.size(), 4U);
  const SceneCollider& floor = file.scene.colliders[0];
  EXPECT_TRUE(std::holds_alternative<PlaneShape>(floor.shape));
  EXPECT_EQ(floor.pose.position.z(), -1.0);
  EXPECT_EQ(floor.friction, 0.7);
  EXPECT_EQ(floor.restitution, 0.0);
  EXPECT_EQ(floor.motion.parts.size(), 1U);
  EXPECT_EQ(std::get<CapsuleShape>(file.scene.colliders[1].shape).half_length, 3.0);
  EXPECT_EQ(file.scene.colliders[1].friction, 0.3);
  EXPECT_EQ(std::get<BoxShape>(file.scene.colliders[2].shape).half_extents, Vector3d(1, 2, 3));
  EXPECT_EQ(file.scene.colliders[3].file, "folder/rock.collider");
  EXPECT_EQ(file.scene.colliders[3].made_by, "./demo");
  ASSERT_EQ(file.scene.hands.size(), 3U);
  EXPECT_FALSE(file.scene.hands[0].pin);
  EXPECT_TRUE(file.scene.hands[2].pin);
  const SceneHand& hand = file.scene.hands[0];
  EXPECT_EQ(hand.at, "17");
  EXPECT_EQ(hand.stiffness, 100.0);
  EXPECT_EQ(hand.damping, 2.0);
  EXPECT_EQ(*hand.position, Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(hand.from, 0.5);
  EXPECT_EQ(hand.until, 2.0);
  EXPECT_EQ(hand.motion.parts.size(), 1U);
  EXPECT_FALSE(file.scene.hands[1].position);
  EXPECT_EQ(file.scene.hands[1].until, kForEver);
}

TEST(SceneReader, ReadsJointsAndDampingInTime) {
  const std::string two = kBody +
                          "alpha = [[0, 1], [0.5, 0]]\n[[bodies]]\nname = \"b\"\n"
                          "model = \"m.tremolo\"\nbeta = 0.002\n";
  const Result<SceneFile> read = parse_world(
      two +
          "[[joints]]\nbody = \"a\"\nat = 3\nto = \"b\"\nto-at = \"near:0,0,0\"\nstiffness = 9\n"
          "damping = 2\nlength = 0.1\ntouch = true\nuntil = 2\n"
          "[[joints]]\nbody = \"b\"\nat = 4\nto = \"a\"\n",
      "scene.toml");
  ASSERT_TRUE(read) << read.error().message;
  const Scene& scene = read->scene;
  ASSERT_EQ(scene.joints.size(), 2U);
  const SceneJoint& joint = scene.joints[0];
  EXPECT_EQ(joint.body + joint.at + joint.to + joint.to_at, "a3bnear:0,0,0");
  EXPECT_EQ(*joint.options.stiffness, 9.0);
  EXPECT_EQ(joint.options.damping, 2.0);
  EXPECT_EQ(joint.options.length, 0.1);
  EXPECT_TRUE(joint.options.touch);
  EXPECT_EQ(joint.until, 2.0);
  EXPECT_FALSE(scene.joints[1].options.stiffness);
  EXPECT_TRUE(scene.joints[1].to_at.empty());
  ASSERT_EQ(scene.bodies[0].alphas.size(), 2U);
  EXPECT_EQ(scene.bodies[0].alphas[1].time, 0.5);
  EXPECT_EQ(scene.bodies[0].alphas[0].value, 1.0);
  EXPECT_TRUE(scene.bodies[0].betas.empty());
  EXPECT_EQ(scene.bodies[1].options.beta, 0.002);
  const std::string start = two + "[[joints]]\nbody = \"a\"\nat = 3\n";
  expect_refused({
      {start, "joint 1: it has no `to`"},
      {start + "to = \"c\"\n", "joint 1: to: there is no body 'c'"},
      {start + "to = \"a\"\n", "joint 1: to: it joins 'a' to itself"},
      {start + "to = \"b\"\ndamping = 1\n", "joint 1: without a `stiffness`"},
      {start + "to = \"b\"\nstiffness = -1\n", "joint 1: 'stiffness' must be positive"},
      {start + "to = \"b\"\nforce = 1\n", "joint 1: unknown key 'force'"},
      {kBody + "alpha = [[1, 1], [0, 1]]\n", "alpha: its moments"},
      {kBody + "beta = [[0, -1]]\n", "beta must be finite and not negative"},
      {kBody + "beta = [0, 1]\n", "a number or a list of [t, value]"},
  });
}

TEST(SceneReader, ReadsCsvFilesBesideTheScene) {
  const std::string folder = testing::fresh_folder();
  std::ofstream(folder + "/poses.csv") << "t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n1,2,0,0,0,1,0,0\n";
  std::ofstream(folder + "/quake.csv") << "# a record\nt,ax,ay,az\n0 0 0 0\n1 2 0 0\n2 0 0 0\n";
  std::ofstream(folder + "/gravity.csv") << "0,0,0,-9\n1,0,0,0\n";
  std::ofstream(folder + "/course.csv") << "0,0\n1,2\n";
  const SceneFile file = read_scene_text(
      "gravity = \"gravity.csv\"\n" + kDriven +
          "signal = \"course.csv\"\n[[bodies.motion]]\nkind = \"csv\"\nfile = \"poses.csv\"\n"
          "start = 3\nscale = 0.5\n[[bodies.motion]]\nkind = \"csv\"\nfile = \"quake.csv\"\n"
          "quantity = \"acceleration\"\n",
      folder + "/s.toml");
  EXPECT_EQ(file.files.size(), 4U);
  EXPECT_EQ(file.scene.gravity.at(0.5), Vector3d(0.0, 0.0, -4.5));
  ASSERT_EQ(file.scene.bodies.size(), 1U);
  const SceneBody& body = file.scene.bodies[0];
  EXPECT_EQ(body.loads[0].table->values[1], 2.0);
  const auto& keys = std::get<KeyframeMotion>(body.motion.parts[0]);
  EXPECT_EQ(keys.keys[1].time, 4.0);
  EXPECT_EQ(keys.keys[1].pose.position.x(), 1.0);
  EXPECT_EQ(keys.keys[1].pose.rotation.x(), 1.0);
  EXPECT_EQ(std::get<RecordMotion>(body.motion.parts[1]).accelerations[1].x(), 2.0);
}

TEST(SceneReader, AByteOrderMarkIsSkippedInScenesAndTables) {
  const std::string mark = "\xef\xbb\xbf", folder = testing::fresh_folder();
  std::ofstream(folder + "/poses.csv") << mark << "t,x,y,z\n0,0,0,0\n1,2,0,0\n";
  std::ofstream(folder + "/course.csv") << mark << "0,0\n1,2\n";
  EXPECT_TRUE(*is_world(mark + kBody, "s.toml"));
  const SceneFile file = read_scene_text(
      mark + kDriven +
          "signal = \"course.csv\"\n[[bodies.motion]]\nkind = \"csv\"\nfile = \"poses.csv\"\n",
      folder + "/s.toml");
  ASSERT_EQ(file.scene.bodies.size(), 1U);
  EXPECT_EQ(file.scene.bodies[0].loads[0].table->values[1], 2.0);
  const auto& keys = std::get<KeyframeMotion>(file.scene.bodies[0].motion.parts[0]);
  EXPECT_EQ(keys.keys[1].pose.position.x(), 2.0);
}

TEST(SceneReader, TellsFileLineAndKeyOfWhatIsWrong) {
  expect_refused({
      {"stop = 1\n" + kBody, "line 1: unknown key 'stop'"},
      {kBody + "weight = 1\n", "line 4: body 'a': unknown key 'weight'"},
      {kBody + "position = [1, 2]\n",
       "line 4: body 'a': 'position' must be a list of 3 finite numbers"},
      {kBody + "position = [1, 2, nan]\n", "3 finite numbers"},
      {kBody + "quaternion = [1, 1, 0, 0]\n",
       "line 4: body 'a': the quaternion is of length 1.41421, must be 1"},
      {kBody + "turn = [0, 0, 1, 9]\nquaternion = [1, 0, 0, 0]\n", "say one thing"},
      {kBody + "kind = \"loose\"\n", "must be one of fixed, driven, free, rigid, tets, cloth"},
      {kBody + "integrator = \"euler\"\n", "unknown integrator 'euler'"},
      {kBody + "split = \"some\"\n", "line 4: body 'a'"},
      {"[[bodies]]\nmodel = \"m\"\n", "body 1: it has no `name`"},
      {"[[bodies]]\nname = \"a\"\n", "body 'a': it has no key `model`"},
      {"[[bodies]]\nname = \"a/b\"\nmodel = \"m\"\n", "letters, digits"},
      {kBody + kBody, "two bodies are named 'a'"},
      {"bodies = []\n", "the scene has no body"},
      {"bodies = [1]\n", "'bodies' must be a table or a list of tables"},
      {"gravity = [1, 2]\n" + kBody, "line 1: 'gravity' must be"},
      {"gravity = [[1, 0, 0, 0], [0, 0, 0, 0]]\n" + kBody, "the times must ascend"},
      {"step = -1\n" + kBody, "step must be positive"},
  });
  const std::string floor = kBody + "[[colliders]]\nname = \"floor\"\n";
  expect_refused({
      {floor, "line 4: collider 'floor': it has no `shape`"},
      {kBody + "[[colliders]]\nshape = \"plane\"\n", "collider 1: it has no `name`"},
      {floor + "shape = \"disc\"\n", "must be one of plane, sphere, capsule, box, cylinder, mesh"},
      {floor + "shape = \"plane\"\nradius = 1\n", "line 7: collider 'floor': unknown key 'radius'"},
      {floor + "shape = \"sphere\"\n", "collider 'floor': it has no `radius`"},
      {floor + "shape = \"sphere\"\nradius = -1\n", "line 6: collider 'floor': "},
      {floor + "shape = \"mesh\"\n", "collider 'floor': it has no `file`"},
      {floor + "shape = \"plane\"\nfriction = -1\n",
       "collider 'floor': 'friction' must not be negative"},
      {floor + "shape = \"plane\"\nrestitution = 2\n",
       "collider 'floor': 'restitution' must be from 0 to 1"},
      {kBody + "contact = 1\n", "line 4: body 'a': 'contact' must be true or false"},
      {kBody + "contact-points = 0\n", "body 'a': contact-points must be at least 1"},
      {kBody + "contact-margin = 0\n", "body 'a': contact-margin must be above 0"},
      {kBody + "contact-stiffness = nan\n",
       "line 4: body 'a': 'contact-stiffness' must be a finite number"},
  });
  const std::string hand = kBody + "[[hands]]\nbody = \"a\"\n";
  expect_refused({
      {hand, "line 4: hand 1: it has no `at`"},
      {hand + "at = 3\n", "hand 1: it has no `stiffness`"},
      {hand + "at = 3\npin = false\n", "hand 1: it has no `stiffness`"},
      {hand + "at = 3\npin = 1\n", "hand 1: 'pin' must be true or false"},
      {hand + "at = 3\npin = true\ndamping = 2\n",
       "line 7: hand 1: a pin is as stiff as mass and step allow"},
      {hand + "at = 3\nstiffness = 0\n", "hand 1: 'stiffness' must be positive"},
      {hand + "at = 3\nstiffness = 9\nforce = 3\n", "hand 1: unknown key 'force'"},
      {hand + "at = 3\nstiffness = 9\nuntil = -1\n", "hand 1: until must be behind from"},
      {kBody + "[[hands]]\nbody = \"b\"\nat = 3\nstiffness = 9\n",
       "hand 1: body: there is no body 'b'"},
      {kBody + "at = 3\n", "`at` and `force` belong together"},
      {kBody + "at = 3\nforce = [1, 0, 0]\n", "say `load` or `signal`"},
      {kBody + "load = \"triangle\"\n", "unknown load 'triangle'"},
  });
}

TEST(SceneReader, TellsWhatHasNoEffectByItself) {
  expect_refused(kBody + "spacing = [0.1, 0, 0]\n", "it is between `copies`");
  expect_refused(kBody + "scale = 2\n", "it multiplies a load");
  const auto with = [](const std::string& keys) { return kDriven + "[[bodies.motion]]\n" + keys; };
  for (const auto& [motion, missing] :
       {std::pair{"kind = \"shake\"\nfrequency = 2\n", "`amplitude`, m"},
        {"kind = \"shake\"\namplitude = [1, 0, 0]\n", "`frequency`, Hz"},
        {"kind = \"spin\"\n", "`rate`, rad/s"},
        {"kind = \"swing\"\nfrequency = 1\n", "`amplitude`, degrees"},
        {"kind = \"glide\"\n", "`velocity`, m/s"},
        {"kind = \"fall\"\n", "`acceleration`, m/s^2"},
        {"kind = \"spin\"\nspeed = 3\n", "unknown key 'speed'"}})
    expect_refused(with(motion), missing);
}

TEST(SceneReader, TellsWhatIsWrongWithAMotion) {
  const auto with = [](const std::string& keys) { return kDriven + "[[bodies.motion]]\n" + keys; };
  expect_refused({
      {with("rate = 1\n"), "body 'a', motion: it needs a `kind`"},
      {with("kind = \"jump\"\n"), "must be one of shake, spin, glide, fall, keyframes, csv, swing"},
      {with("kind = \"shake\"\namplitude = [1, 0, 0]\nfrequency = 0\n"),
       "its frequency must be positive"},
      {with("kind = \"spin\"\nspeed = 3\n"), "line 7: body 'a', motion: unknown key 'speed'"},
      {with("kind = \"glide\"\nvelocity = [1, 0, 0]\nstart = 0\nstop = 1\nduration = 2\n"),
       "say one thing"},
      {with("kind = \"keyframes\"\nkeys = [[0, 1]]\n"), "must be a list of lists"},
      {with("kind = \"keyframes\"\nkeys = [[0, 0, 0, 0, 2, 0, 0, 0]]\n"),
       "key 1: the quaternion is of length 2"},
      {with("kind = \"csv\"\n"), "needs a `file`"},
      {kBody + "[[bodies.motion]]\nkind = \"glide\"\nvelocity = [1, 0, 0]\n",
       "a motion moves a driven body only"},
  });
  const Result<SceneFile> missing =
      parse_world(with("kind = \"csv\"\nfile = \"none.csv\"\n"), "s.toml");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().kind, ErrorKind::kSystem);
  EXPECT_NE(missing.error().message.find("none.csv"), std::string::npos);
}

TEST(SceneReader, ReadsBones) {
  const std::string folder = testing::fresh_folder();
  std::ofstream(folder + "/weights.csv") << "upper,lower\n1,0\n0.25,0.75\n0,1\n";
  const std::string bones =
      "[[bodies.bones]]\nname = \"upper\"\nhead = [0, 0, 1]\ntail = [0, 0, 2]\n"
      "[[bodies.bones]]\nname = \"lower\"\nparent = \"upper\"\nhead = [0, 0, 2]\n"
      "[[bodies.bones.motion]]\nkind = \"swing\"\naxis = [0, 1, 0]\namplitude = 90\n"
      "frequency = 2\nphase = 180\n";
  const std::string path = folder + "/s.toml";
  const SceneFile by_distance = read_scene_text(kDriven + "bone-blend = 0.1\n" + bones, path);
  const SceneBody& body = by_distance.scene.bodies[0];
  ASSERT_EQ(body.bones.size(), 2U);
  EXPECT_EQ(body.bones[0].name, "upper");
  EXPECT_EQ(body.bones[0].tail, Vector3d(0.0, 0.0, 2.0));
  EXPECT_EQ(body.bones[1].parent, "upper");
  EXPECT_EQ(body.bones[1].tail, body.bones[1].head);
  EXPECT_EQ(body.bone_blend, 0.1);
  EXPECT_EQ(body.bone_weights.size(), 0);
  const auto& swing = std::get<SwingMotion>(body.bones[1].motion.parts[0]);
  EXPECT_NEAR(swing.amplitude, std::numbers::pi / 2.0, 1e-15);
  EXPECT_NEAR(swing.phase, std::numbers::pi, 1e-15);
  EXPECT_EQ(swing.course.ramp, 0.5);  // a period
  const SceneFile given =
      read_scene_text(kDriven + "bone-weights = \"weights.csv\"\n" + bones, path);
  EXPECT_EQ(given.files, std::vector{folder + "/weights.csv"});
  ASSERT_EQ(given.scene.bodies[0].bone_weights.rows(), 3);
  EXPECT_EQ(given.scene.bodies[0].bone_weights(1, 1), 0.75);
}

TEST(SceneReader, ReadsWhetherTheBonesAreTheModels) {
  const SceneFile file = read_scene_text(kDriven + "rig = true\nclip = \"walk\"\n");
  EXPECT_TRUE(file.scene.bodies[0].rig);
  EXPECT_EQ(file.scene.bodies[0].clip, "walk");
  expect_refused({
      {kDriven + "clip = \"walk\"\n", "say rig = true"},
      {kBody + "rig = true\n", "bones carry a driven body only"},
      {kDriven + "rig = true\n[[bodies.bones]]\nname = \"b\"\n", "leave [[bodies.bones]]"},
  });
}

TEST(SceneReader, TellsWhatIsWrongWithBones) {
  const auto with = [](const std::string& keys) { return kDriven + "[[bodies.bones]]\n" + keys; };
  expect_refused({
      {with("head = [0, 0, 1]\n"), "line 5: body 'a', bone 1: it has no `name`"},
      {with("name = \"b\"\nlength = 1\n"), "line 7: body 'a', bone 'b': unknown key 'length'"},
      {with("name = \"b\"\nhead = [1]\n"), "body 'a', bone 'b': 'head' must be"},
      {with("name = \"b\"\nparent = \"c\"\n"),
       "body 'a': bone 'b': parent: there is no bone 'c' before it"},
      {with("name = \"b\"\n[[bodies.bones.motion]]\nkind = \"keyframes\"\n"
            "keys = [[0, 0, 0, 0, 1, 1, 0, 0]]\n"),
       "bone 'b', motion: key 1: the quaternion is of length 1.41421, must be 1"},
      {kBody + "[[bodies.bones]]\nname = \"b\"\n", "body 'a': bones carry a driven body only"},
      {kDriven + "bone-weights = \"w.csv\"\n", "there are no [[bodies.bones]]"},
      {kDriven + "bone-weights = \"w.csv\"\nbone-blend = 1\n[[bodies.bones]]\nname = "
                 "\"b\"\n",
       "say one thing"},
      {kDriven + "bone-blend = -1\n[[bodies.bones]]\nname = \"b\"\n",
       "bone-blend must be finite and not negative"},
  });

  const std::string folder = testing::fresh_folder();
  const auto refused = [&](const std::string& rows, const std::string& words) {
    std::ofstream(folder + "/w.csv") << rows;
    const Result<SceneFile> file =
        parse_world(kDriven +
                        "bone-weights = \"w.csv\"\n[[bodies.bones]]\nname = \"b\"\n"
                        "[[bodies.bones]]\nname = \"c\"\n",
                    folder + "/s.toml");
    ASSERT_FALSE(file);
    EXPECT_EQ(file.error().message.find(folder + "/w.csv"), 0U) << file.error().message;
    EXPECT_NE(file.error().message.find(words), std::string::npos) << file.error().message;
  };
  refused("b,c\n1,0\n0.5,0.6\n", "row 2: the weights sum to 1.1, must sum to 1");
  refused("1,0\n1.5,-0.5\n", "row 2: a weight is -0.5, must not be negative");
  refused("1,0\n1,0,0\n", "line 2: expected a weight for each of the 2 bones");
}

TEST(SceneReader, TellsTheLineOfACsvFile) {
  const std::string folder = testing::fresh_folder();
  const auto refused = [&](const std::string& rows, const std::string& words) {
    std::ofstream(folder + "/m.csv") << rows;
    const Result<SceneFile> file = parse_world(
        kDriven + "[[bodies.motion]]\nkind = \"csv\"\nfile = \"m.csv\"\n", folder + "/s.toml");
    ASSERT_FALSE(file);
    EXPECT_EQ(file.error().message.find(folder + "/m.csv"), 0U) << file.error().message;
    EXPECT_NE(file.error().message.find(words), std::string::npos) << file.error().message;
  };
  refused("t,x,y,z\n0,0,0,0\n1,0,0\n", "line 3");
  refused("t,x,y,z\n0,0,0,zero\n", "line 2");
  refused("0,0,0,0\n1,0,0,0\n0.5,0,0,0\n", "moment 3 is earlier");
  refused("t,x,y,z\n", "no rows");
}

TEST(WorldFlags, WinOverTheSceneAndAreRefusedWhereTheyAreOfOneBody) {
  SceneFile file = read_scene_text("step = 1e-3\nduration = 5\n" + kBody);
  RunOptions flags;
  flags.step = 2e-3;
  flags.duration = 9.0;
  flags.integrator = "ep2";
  const auto apply = [&](std::vector<std::string> given) {
    return apply_flags({flags,
                        [&given](const char* flag) {
                          return std::find(given.begin(), given.end(), flag) != given.end();
                        }},
                       file);
  };
  ASSERT_TRUE(apply({"--step", "--integrator"}));
  EXPECT_EQ(file.scene.step, 2e-3);
  EXPECT_EQ(file.scene.duration, 5.0);
  EXPECT_EQ(file.scene.bodies[0].integrator, "ep2");
  const Status one = apply({"--deflect"});
  ASSERT_FALSE(one);
  EXPECT_EQ(one.error().kind, ErrorKind::kUsage);
  flags.integrator = "euler";
  EXPECT_EQ(apply({"--integrator"}).error().kind, ErrorKind::kUsage);
  flags.duration = -1.0;
  EXPECT_EQ(apply({"--duration"}).error().kind, ErrorKind::kContent);
}

}  // namespace
}  // namespace tremolo
