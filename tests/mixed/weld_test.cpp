// Welds of bodies of all kinds, by scenes: beams of two halves, weights, momenta and energy, saved
// states, refusals.
#include "runtime/contact/weld.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "common/state_stream.h"
#include "runtime/io/scenes/nodal_readers.h"
#include "runtime/scene/selection.h"
#include "runtime/world/world_guests.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

// A world with its guests.
struct WeldWorld {
  SceneWorld world;
  WorldGuests guests;

  static Result<WeldWorld> create(const std::string& text, const std::string& path) {
    Result<MixedFile> file = parse_mixed(text, path);
    if (!file) return file.error();
    Result<SceneWorld> world =
        SceneWorld::create(file->file.scene, load_scene_model, file->has_guests());
    if (!world) return world.error();
    WeldWorld made{std::move(*world), {}};
    if (!file->has_guests()) return made;
    Result<WorldGuests> guests = add_guests(file->tets, file->cloths, path, made.world);
    if (!guests) return guests.error();
    made.guests = std::move(*guests);
    return made;
  }
  const MixedGuests* mixed() const { return guests.guests; }

  bool step() {
    bool made = world.step().empty();
    for (std::size_t i = 0; mixed() != nullptr && i < mixed()->size(); ++i)
      made = made && !mixed()->failed(i);
    return made;
  }
  Momenta momenta() {
    Momenta sum;
    for (std::size_t i = 0; i < world.size(); ++i) {
      sum.linear += world.momenta(i).linear;
      sum.angular += world.momenta(i).angular;
    }
    for (std::size_t i = 0; mixed() != nullptr && i < mixed()->size(); ++i) {
      if (const TetStep* tets = mixed()->tets(i)) {
        sum.linear += tets->body().momentum();
        sum.angular += tets->body().angular_momentum();
        continue;
      }
      const Momenta of_cloth = mixed()->cloth(i)->body().momenta();
      sum.linear += of_cloth.linear;
      sum.angular += of_cloth.angular;
    }
    return sum;
  }
  // Work of joints on all bodies since the start, J.
  double work() const {
    double sum = 0.0;
    for (std::size_t i = 0; i < world.size(); ++i) sum += world.account(i).joint;
    for (std::size_t i = 0; mixed() != nullptr && i < mixed()->size(); ++i)
      sum += mixed()->sums(i).joint;
    return sum;
  }
};

// Beams along x of a square section. The whole one has twice the length of a half.
constexpr double kHalf = 0.2, kSide = 0.04;

class Welds : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fresh_folder();
    const auto write = [](const std::string& name, const std::array<int, 3>& cells, double length,
                          double from) {
      TetMesh mesh = box_mesh(cells, {length, kSide, kSide});
      for (Vector3d& x : mesh.vertices) x += Vector3d(from, -0.5 * kSide, -0.5 * kSide);
      write_veg(folder_ + "/" + name, mesh);
    };
    write("held.veg", {6, 1, 1}, kHalf, 0.0);
    write("rest.veg", {6, 1, 1}, kHalf, kHalf);
    write("odd.veg", {5, 2, 2}, kHalf, kHalf);
    write("whole.veg", {12, 1, 1}, 2.0 * kHalf, 0.0);
    const std::string of = " --threads 1 --young 1e6 --poisson 0.3 --density 1000 --fix ";
    const std::string modes = " --linear-modes 8 --modes 16 -o ";
    for (const std::string& what : std::vector<std::string>{
             "held.veg" + of + "'x<0.001'" + modes + "held.tremolo",
             "rest.veg" + of + "none" + modes + "rest.tremolo",
             "whole.veg" + of + "'x<0.001'" + modes + "whole.tremolo",
             "tets held.veg --young 1e6 --poisson 0.3 --density 1000 --fix 'x<0.001' -o held.tets",
             "tets held.veg --young 1e6 --poisson 0.3 --density 1000 --fix none -o free.tets",
             "tets rest.veg --young 1e6 --poisson 0.3 --density 1000 --fix none -o rest.tets",
             "tets odd.veg --young 1e6 --poisson 0.3 --density 1000 --fix none -o odd.tets"}) {
      const ProgramResult made = run_program(folder_, kPrecompute + what);
      ASSERT_EQ(made.code, 0) << what << made.err;
    }
  }

  static std::string path(const std::string& name) { return folder_ + "/" + name; }
  static Result<WeldWorld> world_of(const std::string& text) {
    return WeldWorld::create(text, path("scene.toml"));
  }

  static inline std::string folder_;
};

std::string body_text(const std::string& name, const std::string& kind, const std::string& model,
                      const std::string& more = "") {
  return "[[bodies]]\nname = \"" + name + "\"\nkind = \"" + kind + "\"\nmodel = \"" + model +
         "\"\n" + more;
}

std::string step_text(double step, const std::string& gravity = "") {
  return "step = " + std::to_string(step) + "\n" +
         (gravity.empty() ? "" : "gravity = " + gravity + "\n");
}

const std::string kTets = "integrator = \"midpoint\"\ndegree = \"quadratic\"\n";
const std::string kEnds =
    "[[joints]]\nkind = \"weld\"\nbody = \"one\"\nat = \"x>0.199\"\nto = \"two\"\nto-at = "
    "\"x<0.201\"\n";

// The first frequency of the beam, Hz, from the times at which `value` passes zero. From the time
// on at which the beam's second mode is gone.
template <class Value>
double frequency_of(WeldWorld& made, double step, double from, double until, const Value& value) {
  double before = 0.0, first = 0.0, last = 0.0;
  int passes = 0;
  for (int k = 1; k * step < until; ++k) {
    if (!made.step()) return 0.0;
    const double now = value();
    if (k * step > from && before < 0.0 && now >= 0.0) {
      last = (k - now / (now - before)) * step;
      if (passes++ == 0) first = last;
    }
    before = now;
  }
  return passes > 1 ? (passes - 1) / (last - first) : 0.0;
}

double whole_frequency(const std::string& folder) {
  const Result<Model::Pointer> whole = Model::load(folder + "/whole.tremolo");
  EXPECT_TRUE(whole) << (whole ? "" : whole.error().message);
  return std::sqrt((*whole)->lambda()(0)) / (2.0 * std::numbers::pi);
}

TEST_F(Welds, TwoHalvesVibrateAsOneBeam) {
  const double exact = whole_frequency(folder_);
  const double bernoulli = std::pow(1.8751041 / (2.0 * kHalf), 2) *
                           std::sqrt(1e6 * kSide * kSide / 12e3) / (2.0 * std::numbers::pi);
  EXPECT_NEAR(exact, bernoulli, 0.02 * bernoulli);
  const double step = 8e-3;
  const std::string kicked = "velocity = [0, 0, 0.02]\n";
  const std::string soft = "beta = 0.002\n";
  const std::string held = body_text("one", "fixed", "held.tremolo", soft),
                    rest = body_text("two", "free", "rest.tremolo", soft + kicked),
                    held_tets = body_text("one", "tets", "held.tets", kTets + soft),
                    rest_tets = body_text("two", "tets", "rest.tets", kTets + soft + kicked),
                    odd_tets = body_text("two", "tets", "odd.tets", kTets + soft + kicked);
  const std::pair<std::string, std::string> pairs[] = {
      {held, rest},           {held, rest_tets},     {held_tets, rest},
      {held_tets, rest_tets}, {held_tets, odd_tets}, {held, odd_tets}};
  for (const auto& [one, two] : pairs) {
    SCOPED_TRACE(one + two);
    Result<WeldWorld> made = world_of(step_text(step) + one + two + kEnds);
    ASSERT_TRUE(made) << made.error().message;
    const MixedGuests* guests = made->mixed();
    const bool reduced = made->world.find("two").has_value();
    const std::size_t body = reduced ? *made->world.find("two") : guests->size() - 1;
    const Vector3d tip(2.0 * kHalf, 0.0, 0.0);
    const std::size_t point = reduced ? 0 : guests->point_near(body, tip);
    const JointPlace place = reduced ? place_at(made->world.body(body), tip) : JointPlace{};
    const double measured = frequency_of(*made, step, 1.0, 2.65, [&] {
      return reduced ? place_now(made->world.body(body), place).z()
                     : guests->point_at(body, point).z();
    });
    EXPECT_NEAR(measured, exact, 0.05 * exact);
  }
}

// A body that hangs on a weld pulls it with its weight, whatever its kind.
TEST_F(Welds, CarryTheWeightOfWhatHangsOnThem) {
  const double weight = 9.81 * 1000.0 * kHalf * kSide * kSide;
  const std::string hold = body_text("one", "fixed", "held.tremolo", "beta = 0.02\nalpha = 4\n");
  const std::string tets = "integrator = \"implicit-euler\"\ndegree = \"quadratic\"\nalpha = 4\n";
  for (const std::string& two :
       {body_text("two", "free", "rest.tremolo", "beta = 0.02\nalpha = 4\n"),
        body_text("two", "tets", "rest.tets", tets), body_text("two", "tets", "odd.tets", tets),
        std::string("[[bodies]]\nname = \"two\"\nkind = \"rigid\"\nshape = \"box\"\n"
                    "half-extents = [0.1, 0.02, 0.02]\nmass = 0.32\nposition = [0.3, 0, 0]\n")}) {
    SCOPED_TRACE(two);
    const bool rigid = two.find("rigid") != std::string::npos;
    Result<WeldWorld> made =
        world_of(step_text(0.01, "[9.81, 0, 0]") + hold + two +
                 (rigid ? "[[joints]]\nkind = \"weld\"\nbody = \"one\"\nat = \"x>0.199\"\n"
                          "to = \"two\"\n"
                        : kEnds));
    ASSERT_TRUE(made) << made.error().message;
    for (int k = 0; k < 400; ++k) ASSERT_TRUE(made->step()) << k;
    const Vector3d force = made->world.joint(0)->force;  // on the upper one
    EXPECT_NEAR(force.x(), weight, 1e-3 * weight);
    EXPECT_LT(std::hypot(force.y(), force.z()), 1e-3 * weight);
  }
}

struct WeldedPair {
  std::string name, one, two, weld;
  bool rotates = true;  // one of the two has a rotation, which takes the torque of dampers
};

std::vector<WeldedPair> free_pairs() {
  const std::string first = "velocity = [0.05, 0.02, 0.1]\nspin = [0.5, 1, -0.7]\n";
  const std::string second = "velocity = [0, -0.05, 0.02]\nspin = [-0.5, 0.3, 0.8]\n";
  const std::string reduced =
      body_text("one", "free", "rest.tremolo", "position = [-0.2, 0, 0]\n" + first);
  const std::string near = "[[joints]]\nkind = \"weld\"\nbody = \"one\"\nat = ";
  const std::string sheet =
      "[[bodies]]\nname = \"two\"\nkind = \"cloth\"\nintegrator = \"energy\"\ncolumns = 9\n"
      "rows = 6\nwidth = 0.08\nheight = 0.04\ncorner = [0.2, -0.02, 0.02]\ndensity = 0.3\n"
      "structural = [200, 0.01]\nshear = [60, 0.01]\nbend = [2, 0.001]\ndrag = 0\n";
  const std::string box =
      "[[bodies]]\nname = \"two\"\nkind = \"rigid\"\nshape = \"box\"\n"
      "half-extents = [0.1, 0.02, 0.02]\nmass = 0.5\nposition = [0.3, 0, 0]\n";
  const std::string tets = body_text("one", "tets", "free.tets", kTets + first);
  return {
      {"two reduced", reduced, body_text("two", "free", "rest.tremolo", second),
       near + "\"x>0.399\"\nto = \"two\"\nto-at = \"x<0.201\"\n"},
      {"reduced and rigid", reduced, box + second, near + "\"x>0.399\"\nto = \"two\"\n"},
      {"tets and reduced", tets, body_text("two", "free", "rest.tremolo", second), kEnds},
      {"reduced and tets", reduced, body_text("two", "tets", "odd.tets", kTets + second),
       near + "\"x>0.399\"\nto = \"two\"\nto-at = \"x<0.201\"\n"},
      {"tets and rigid", tets, box + second, near + "\"x>0.199\"\nto = \"two\"\n"},
      {"two of tets", tets, body_text("two", "tets", "rest.tets", kTets + second), kEnds, false},
      {"tets with other meshes", tets, body_text("two", "tets", "odd.tets", kTets + second), kEnds,
       false},
      {"tets and cloth", tets, sheet,
       "[[joints]]\nkind = \"weld\"\nbody = \"two\"\nat = \"left\"\nto = \"one\"\nto-at = "
       "\"x>0.199\"\n",
       false},
      {"reduced and cloth", reduced, sheet,
       "[[joints]]\nkind = \"weld\"\nbody = \"one\"\nat = \"x>0.399\"\nto = \"two\"\nto-at = "
       "\"left\"\n"}};
}

// The pair keeps both momenta, and what the weld gives to the bodies is what it has lost.
TEST_F(Welds, KeepBothMomentaAndTheEnergy) {
  const double step = 2e-3;
  for (const WeldedPair& pair : free_pairs())
    for (const bool given : {false, true}) {
      SCOPED_TRACE(pair.name + (given ? ", with a stiffness" : ""));
      Result<WeldWorld> made = world_of(step_text(step) + pair.one + pair.two + pair.weld +
                                        (given ? "stiffness = 2000\ndamping = 2\n" : ""));
      ASSERT_TRUE(made) << made.error().message;
      const Momenta start = made->momenta();
      double exchanged = start.linear.norm(), linear = 0.0, angular = 0.0, energy = 0.0;
      double most = 0.0;
      for (int k = 0; k < 40; ++k) {
        ASSERT_TRUE(made->step()) << k;
        const Joint& joint = *made->world.joint(0);
        exchanged += step * joint.force.norm();
        const Momenta now = made->momenta();
        linear = std::max(linear, (now.linear - start.linear).norm());
        angular = std::max(angular, (now.angular - start.angular).norm());
        energy = std::max(energy, std::abs(made->work() + joint.energy + joint.damped));
        most = std::max({most, joint.energy, joint.damped});
      }
      EXPECT_LT(linear, 1e-10 * exchanged);
      EXPECT_LT(angular, (pair.rotates || given ? 1e-10 : 1e-8) * exchanged);
      EXPECT_LT(energy, 1e-9 * most);
    }
}

// At h, h/2 and h/4 the difference to the next step falls as h^2.
TEST_F(Welds, AreOfSecondOrder) {
  const std::string soft = "beta = 0.0005\n";
  const std::string one = body_text("one", "fixed", "held.tremolo", soft);
  const double time = 0.16;
  for (const std::string& two : {body_text("two", "free", "rest.tremolo", soft),
                                 body_text("two", "tets", "rest.tets", kTets + soft)}) {
    SCOPED_TRACE(two);
    std::vector<double> tips;
    for (const double step : {4e-3, 2e-3, 1e-3}) {
      Result<WeldWorld> made =
          world_of(step_text(step, "[0, 0, -0.5]") + one + two + kEnds + "stiffness = 1e5\n");
      ASSERT_TRUE(made) << made.error().message;
      const Vector3d tip(2.0 * kHalf, 0.0, 0.0);
      const bool reduced = made->mixed() == nullptr;
      const JointPlace place = reduced ? place_at(made->world.body(1), tip) : JointPlace{};
      const std::size_t point = reduced ? 0 : made->mixed()->point_near(0, tip);
      for (int k = 0; k < std::lround(time / step); ++k) ASSERT_TRUE(made->step()) << k;
      tips.push_back(reduced ? place_now(made->world.body(1), place).z()
                             : made->mixed()->point_at(0, point).z());
    }
    EXPECT_NEAR((tips[0] - tips[1]) / (tips[1] - tips[2]), 4.0, 1.0);
  }
}

// A saved world continues with the same bits, before and after the welds are over.
TEST_F(Welds, AreRestoredToTheBit) {
  const std::string text =
      step_text(2e-3, "[0, 0, -9.81]") + body_text("one", "fixed", "held.tremolo") +
      body_text("two", "free", "rest.tremolo") +
      body_text("three", "tets", "odd.tets", kTets + "position = [0.2, 0, 0]\n") + kEnds +
      "until = 0.06\n" +
      "[[joints]]\nkind = \"weld\"\nbody = \"two\"\nat = \"x>0.399\"\nto = \"three\"\nto-at = "
      "\"x<0.201\"\nuntil = 0.08\n"
      "[[joints]]\nbody = \"three\"\nat = \"near:0.4,0,0.02\"\nto = \"world\"\npoint = [0.6, 0, "
      "0.2]\n"
      "stiffness = 50\nlength = 0.1\nuntil = 0.07\n"
      "[[joints]]\nkind = \"weld\"\nbody = \"two\"\nat = \"x>0.399\"\nto = \"world\"\nuntil = "
      "0.05\n";
  for (const int before : {0, 10, 35, 45}) {
    SCOPED_TRACE(before);
    Result<WeldWorld> whole = world_of(text), other = world_of(text);
    ASSERT_TRUE(whole) << whole.error().message;
    for (int k = 0; k < before; ++k) ASSERT_TRUE(whole->step());
    const std::vector<std::byte> bytes = whole->world.save();
    for (int k = 0; k < 38; ++k) ASSERT_TRUE(other->step());
    const Status restored = other->world.restore(bytes);
    ASSERT_TRUE(restored) << restored.error().message;
    for (int k = 0; k < 10; ++k) ASSERT_TRUE(whole->step() && other->step());
    EXPECT_TRUE(whole->world.save() == other->world.save());
    EXPECT_EQ(whole->world.joint(0) != nullptr, before + 10 <= 30);
    EXPECT_EQ(whole->world.joint(1) != nullptr, before + 10 <= 40);
  }
}

TEST_F(Welds, ThatCannotBeAreToldWithTheirLine) {
  const std::string bodies = step_text(2e-3) + body_text("one", "fixed", "held.tremolo") +
                             body_text("two", "free", "rest.tremolo") +
                             body_text("three", "tets", "rest.tets", kTets) +
                             body_text("four", "tets", "free.tets", kTets);
  const auto line = std::count(bodies.begin(), bodies.end(), '\n') + 1;
  const std::string weld = "[[joints]]\nkind = \"weld\"\n";
  const std::pair<std::string, const char*> wrong[] = {
      {"[[joints]]\nkind = \"glue\"\nbody = \"one\"\nat = 1\nto = \"two\"\n", "glue"},
      {weld + "body = \"one\"\nat = \"x>9\"\nto = \"two\"\n", "at = \"x>9\""},
      {weld + "body = \"one\"\nat = \"none\"\nto = \"two\"\n", "a weld needs some"},
      {weld + "body = \"one\"\nat = \"x<0.1\"\nto = \"two\"\n", "more than `gap` of 0.001 m"},
      {weld + "body = \"one\"\nat = \"x<0.1\"\nto = \"two\"\ngap = 0.05\n",
       "more than `gap` of 0.05 m"},
      {weld + "body = \"one\"\nat = \"x<0.001\"\nto = \"three\"\n", "more than `gap`"},
      {weld + "body = \"four\"\nat = \"x<0.1\"\nto = \"three\"\ngap = 1\n", "more than `gap`"},
      {weld + "body = \"one\"\nat = 1\nto = \"two\"\nlength = 0.1\n", "a weld has no `length`"},
      {weld + "body = \"one\"\nat = 1\nto = \"two\"\ngap = -1\n", "'gap' must not be negative"},
      {"[[joints]]\nbody = \"one\"\nat = 1\nto = \"two\"\ngap = 1\n", "has a `gap`"},
      {"[[joints]]\nbody = \"two\"\nat = 1\nto = \"world\"\nlength = 1\n", "needs a `point`"},
      {"[[joints]]\nbody = \"two\"\nat = 1\nto = \"world\"\nto-at = 1\n", "no vertices"},
      {"[[joints]]\nbody = \"two\"\nat = 1\nto = \"world\"\npoint = [9, 0, 0]\n",
       "apart at the start"},
      {"[[joints]]\nbody = \"two\"\nat = 1\nto = \"one\"\npoint = [9, 0, 0]\n",
       "only a joint to the world"},
      {weld + "body = \"three\"\nat = 1\nto = \"world\"\ngap = 1\n", "has none"}};
  for (const auto& [text, told] : wrong) {
    SCOPED_TRACE(text);
    const Result<WeldWorld> made = world_of(bodies + text);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().kind, ErrorKind::kContent);
    EXPECT_NE(made.error().message.find(told), std::string::npos) << made.error().message;
    EXPECT_TRUE(made.error().message.find("joint 1") != std::string::npos) << made.error().message;
    bool lined = false;
    for (int k = 0; k < 6; ++k)
      lined = lined || made.error().message.find(std::to_string(line + k)) != std::string::npos;
    EXPECT_TRUE(lined) << made.error().message;
  }
}

// Bodies of each kind on a joint to the world.
std::vector<std::string> hung_bodies() {
  const std::string tets = "integrator = \"implicit-euler\"\ndegree = \"quadratic\"\nalpha = 4\n";
  return {body_text("one", "free", "rest.tremolo", "beta = 0.02\nalpha = 4\n"),
          body_text("one", "tets", "rest.tets", tets),
          "[[bodies]]\nname = \"one\"\nkind = \"rigid\"\nshape = \"box\"\n"
          "half-extents = [0.1, 0.02, 0.02]\nmass = 0.32\nposition = [0.3, 0, 0]\n"};
}

// A weld to the world carries the weight and its moment about the welded face.
TEST_F(Welds, ToTheWorldCarryTheWeight) {
  const double weight = 9.81 * 1000.0 * kHalf * kSide * kSide;
  for (const std::string& one : hung_bodies()) {
    SCOPED_TRACE(one);
    const bool rigid = one.find("rigid") != std::string::npos;
    Result<WeldWorld> made =
        world_of(step_text(0.01, "[9.81, 0, 0]") + one +
                 "[[joints]]\nkind = \"weld\"\nbody = \"one\"\nat = " +
                 (rigid ? "\"x<-0.099\"" : "\"x<0.201\"") + "\nto = \"world\"\n");
    ASSERT_TRUE(made) << made.error().message;
    for (int k = 0; k < 400; ++k) ASSERT_TRUE(made->step()) << k;
    const Vector3d force = made->world.joint(0)->force;
    EXPECT_NEAR(force.x(), -weight, 1e-3 * weight);
    EXPECT_LT(std::hypot(force.y(), force.z()), 1e-3 * weight);
  }
}

// The first frequency that the shapes of a free reduced body permit on springs of `stiffness` in
// all at these vertices, Hz.
double frequency_on_springs(const Model& model, const std::vector<VertexId>& vertices,
                            const Joint& springs) {
  const std::shared_ptr<const FrameInertia> inertia = model.inertia_about_centre();
  const Eigen::Index r = model.modes();
  Eigen::MatrixXd mass = Eigen::MatrixXd::Identity(6 + r, 6 + r), stiffness = mass;
  mass.topLeftCorner<3, 3>() *= inertia->mass;
  mass.block<3, 3>(3, 3) = inertia->P0.trace() * Eigen::Matrix3d::Identity() - inertia->P0;
  stiffness.setZero();
  stiffness.diagonal().tail(r) = model.lambda();
  for (const VertexId vertex : vertices) {
    const VertexRows place = *model.vertex(vertex);
    Eigen::MatrixXd rows(3, 6 + r);
    rows << Eigen::Matrix3d::Identity(), -cross_matrix(place.rest - inertia->centre), place.rows;
    stiffness += springs.stiffness / static_cast<double>(vertices.size()) * rows.transpose() * rows;
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(stiffness, mass);
  return std::sqrt(modes.eigenvalues()[0]) / (2.0 * std::numbers::pi);
}

// Tetrahedra that are welded to the world are a beam that is fixed there. A free reduced body is
// stiffer: the shapes of its free vibrations bend its end little.
TEST_F(Welds, ToTheWorldHoldTheEndOfABeam) {
  const Result<Model::Pointer> fixed = Model::load(path("held.tremolo"));
  ASSERT_TRUE(fixed);
  const double step = 2e-3;
  for (const std::string& one :
       {body_text("one", "free", "rest.tremolo", "beta = 0.001\nspin = [0, -0.2, 0]\n"),
        body_text("one", "tets", "rest.tets", kTets + "beta = 0.001\nspin = [0, -0.2, 0]\n")}) {
    SCOPED_TRACE(one);
    Result<WeldWorld> made = world_of(step_text(step) + one +
                                      "[[joints]]\nkind = \"weld\"\nbody = \"one\"\nat = "
                                      "\"x<0.201\"\nto = \"world\"\n");
    ASSERT_TRUE(made) << made.error().message;
    const Vector3d tip(2.0 * kHalf, 0.0, 0.0);
    const bool reduced = made->mixed() == nullptr;
    const JointPlace place = reduced ? place_at(made->world.body(0), tip) : JointPlace{};
    const std::size_t point = reduced ? 0 : made->mixed()->point_near(0, tip);
    const double measured = frequency_of(*made, step, 0.3, 1.5, [&] {
      return reduced ? place_now(made->world.body(0), place).z()
                     : made->mixed()->point_at(0, point).z();
    });
    double exact = std::sqrt((*fixed)->lambda()(0)) / (2.0 * std::numbers::pi);
    if (reduced) {
      const Model& model = made->world.body(0).model();
      exact = frequency_on_springs(model, *vertices_of("x<0.201", model), *made->world.joint(0));
    }
    EXPECT_NEAR(measured, exact, 0.01 * exact);
  }
}

// On a string to a point of the world a small stiff body is a pendulum, with the period of both.
TEST_F(Welds, AStringToTheWorldIsAPendulum) {
  constexpr double kLength = 1.0, kStiffness = 1e5, kGravity = 9.81, kAngle = 0.02, kRadius = 0.05;
  const double step = 2e-3, mass = 1.0;
  const double taut = kLength + mass * kGravity / kStiffness;
  // A sphere that is held at its surface: the modes of string and sphere.
  const double turning = 0.4 * kRadius * kRadius;
  Eigen::Matrix2d inertia, gravity;
  inertia << taut * taut, taut * kRadius, taut * kRadius, kRadius * kRadius + turning;
  gravity << kGravity * taut, 0.0, 0.0, kGravity * kRadius;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix2d> modes(gravity, inertia);
  const double omega = std::sqrt(modes.eigenvalues()[0]);
  const Eigen::Vector2d mode = kAngle * modes.eigenvectors().col(0) / modes.eigenvectors()(0, 0);
  const Vector3d end(taut * std::sin(mode[0]), 0.0, -taut * std::cos(mode[0]));
  const Vector3d middle = end + kRadius * Vector3d(std::sin(mode[1]), 0.0, -std::cos(mode[1]));
  std::ostringstream text;
  text.precision(17);
  text << step_text(step, "[0, 0, -9.81]")
       << "[[bodies]]\nname = \"one\"\nkind = \"rigid\"\nshape = \"sphere\"\nradius = " << kRadius
       << "\nmass = 1\nposition = [" << middle.x() << ", 0, " << middle.z()
       << "]\nturn = [0, 1, 0, " << -mode[1] * 180.0 / std::numbers::pi
       << "]\n[[joints]]\nbody = \"one\"\nat = \"near:0,0,0.05\"\nto = \"world\"\npoint = [0, 0, "
          "0]\n"
       << "length = 1\nstiffness = 1e5\n";
  Result<WeldWorld> made = world_of(text.str());
  ASSERT_TRUE(made) << made.error().message;
  double worst = 0.0, pull = 0.0;
  int steps = 0;
  for (; steps * step < 1.5 * 2.0 * std::numbers::pi / omega; ++steps) {
    ASSERT_TRUE(made->step());
    const Vector3d at = made->world.body(0).pose() * Vector3d(0, 0, kRadius);
    const double exact = taut * mode[0] * std::cos(omega * (steps + 1) * step);
    worst = std::max(worst, std::abs(at.x() - exact));
    pull += made->world.joint(0)->force.z();
  }
  EXPECT_LT(worst, 3e-3 * taut * kAngle);
  EXPECT_NEAR(pull / steps, mass * kGravity, 2e-3 * mass * kGravity);
  const Joint& joint = *made->world.joint(0);
  EXPECT_NEAR(made->world.account(0).joint + joint.energy + joint.damped,
              0.5 * kStiffness * std::pow(taut - kLength, 2), 1e-9 * mass * kGravity);
  EXPECT_LT(std::abs(made->world.account(0).remainder()), 1e-9 * mass * kGravity);
}

// A place moves with its points: it is theirs for every map of their plane, and what they do not
// span is the offset.
TEST(WeldPlaces, MoveWithTheirPoints) {
  std::vector<Vector3d> points;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) points.emplace_back(0.1 * i, 0.1 * j, 0.0);
  const auto place_of = [](const WeldPlace& place, const std::vector<Vector3d>& at) {
    Vector3d sum = Vector3d::Zero();
    for (const WeldPlace::Point& one : place.used()) sum += one.weight * at[one.number];
    return sum;
  };
  Eigen::Matrix3d map;
  map << 1.1, 0.2, 0.0, -0.3, 0.9, 0.1, 0.2, 0.5, 1.0;
  std::vector<Vector3d> moved;
  for (const Vector3d& point : points) moved.push_back(map * point + Vector3d(1.0, 2.0, 3.0));
  for (const Vector3d& position : {Vector3d(0.13, 0.27, 0.0), Vector3d(0.2, 0.1, 0.0),
                                   Vector3d(0.05, 0.1, 0.02), Vector3d(0.31, 0.12, 0.0)}) {
    const WeldPlace place = weld_place(points, position);
    double sum = 0.0;
    for (const WeldPlace::Point& one : place.used()) sum += one.weight;
    EXPECT_NEAR(sum, 1.0, 1e-14);
    EXPECT_LT((place.offset - Vector3d(0.0, 0.0, position.z())).norm(), 1e-14);
    const Vector3d foot(position.x(), position.y(), 0.0);
    EXPECT_LT((place_of(place, points) - foot).norm(), 1e-14);
    EXPECT_LT((place_of(place, moved) - map * foot - Vector3d(1.0, 2.0, 3.0)).norm(), 1e-14);
  }
  EXPECT_EQ(weld_place(points, {0.2, 0.1, 0.0}).count, 1U) << "the point itself";
  const Vector3d beyond(1.7, 0.0, 0.0);
  EXPECT_LT((weld_place(points, {2.0, 0.1, 0.0}).offset - beyond).norm(), 1e-14);
}

}  // namespace
}  // namespace tremolo
