// Bodies of tetrahedra and cloths of a scene that begin in their equilibrium, and copies, rotations
// and spin of cloths: against reduced bodies and closed forms, saved states, refusals.
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "runtime/contact/weld.h"
#include "runtime/io/scenes/nodal_readers.h"
#include "runtime/world/world_guests.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

// A world with its guests, from the text of a scene.
struct StartedWorld {
  SceneWorld world;
  MixedGuests* guests = nullptr;

  static Result<StartedWorld> create(const std::string& text, const std::string& path) {
    Result<MixedFile> file = parse_mixed(text, path);
    if (!file) return file.error();
    Result<SceneWorld> world = SceneWorld::create(file->file.scene, load_scene_model, true);
    if (!world) return world.error();
    StartedWorld made{std::move(*world)};
    Result<WorldGuests> guests = add_guests(file->tets, file->cloths, path, made.world);
    if (!guests) return guests.error();
    made.guests = guests->guests;
    return made;
  }

  bool step() {
    bool made = world.step().empty();
    for (std::size_t i = 0; i < guests->size(); ++i) made = made && !guests->failed(i);
    return made;
  }
  const VectorXd& positions(std::size_t guest) const {
    const TetStep* tets = guests->tets(guest);
    return tets != nullptr ? tets->body().positions() : guests->cloth(guest)->body().state().x;
  }
  const VectorXd& velocities(std::size_t guest) const {
    const TetStep* tets = guests->tets(guest);
    return tets != nullptr ? tets->body().velocities() : guests->cloth(guest)->body().state().v;
  }
};

constexpr double kLong = 0.4, kThick = 0.04, kYoung = 1e6;

class StaticStart : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fresh_folder();
    TetMesh mesh = box_mesh({10, 2, 2}, {kLong, kThick, kThick});
    write_veg(folder_ + "/bar.veg", mesh);
    const std::string of = " --young 1e6 --poisson 0 --density 1000 --fix ";
    for (const std::string& what : std::vector<std::string>{
             "bar.veg --threads 1" + of + "'x<0.001' --linear-modes 12 --modes 24 -o bar.tremolo",
             "tets bar.veg" + of + "'x<0.001' -o bar.tets",
             "tets bar.veg" + of + "none -o free.tets"}) {
      const ProgramResult made = run_program(folder_, kPrecompute + what);
      ASSERT_EQ(made.code, 0) << what << made.err;
    }
  }
  static Result<StartedWorld> world_of(const std::string& text) {
    return StartedWorld::create(text, folder_ + "/scene.toml");
  }
  static std::string refusal(const std::string& text) {
    const Result<StartedWorld> made = world_of(text);
    return made ? "" : made.error().message;
  }

  static inline std::string folder_;
};

std::string scene_text(const std::string& more, const std::string& gravity = "[0, 0, -9.81]") {
  return "step = 0.005\ngravity = " + gravity + "\n" + more;
}

std::string bar_text(const std::string& kind, const std::string& more = "") {
  const bool tets = kind == "tets";
  return "[[bodies]]\nname = \"bar\"\nkind = \"" + kind + "\"\nmodel = \"bar." +
         (tets ? "tets" : "tremolo") + "\"\nstart = \"static\"\n" +
         (tets ? "degree = \"quadratic\"\n" : "") + more;
}

std::string sheet_text(const std::string& more) {
  return "[[bodies]]\nname = \"sheet\"\nkind = \"cloth\"\ncolumns = 9\nrows = 9\n" + more;
}

const std::string kCorners = "pins = \"corners\"\nstart = \"static\"\n";

// The bar's end of a world whose only body it is.
Vector3d end_of_bar(const StartedWorld& made) {
  const Vector3d tip(kLong, 0.5 * kThick, 0.5 * kThick);
  const TetMesh mesh = box_mesh({10, 2, 2}, {kLong, kThick, kThick});
  VertexId vertex = 0;
  while ((mesh.vertices[static_cast<std::size_t>(vertex)] - tip).norm() > 1e-9) ++vertex;
  if (made.world.size() == 0) return made.positions(0).segment<3>(3 * Eigen::Index{vertex});
  const ContactBody& body = made.world.body(0);
  const auto rows = body.model().vertex(vertex);
  EXPECT_TRUE(rows);
  return body.place_now(vertex, *rows);
}

// F L^3/(3 E I) + F L/(k G A), nu = 0.
TEST_F(StaticStart, ABarUnderAForceBendsAsTheReducedBodyAndTheBeam) {
  const double force = 0.002, second = std::pow(kThick, 4) / 12.0;
  const double beam = force * std::pow(kLong, 3) / (3.0 * kYoung * second) +
                      force * kLong / (5.0 / 6.0 * 0.5 * kYoung * kThick * kThick);
  const std::string load = "load = \"constant\"\nat = \"x>0.399\"\nforce = [0, 0, -0.002]\n";
  double sag[2];
  for (const bool tets : {false, true}) {
    const Result<StartedWorld> made =
        world_of(scene_text(bar_text(tets ? "tets" : "fixed", load), "[0, 0, 0]"));
    ASSERT_TRUE(made) << made.error().message;
    sag[tets] = 0.5 * kThick - end_of_bar(*made).z();
  }
  EXPECT_NEAR(sag[1], beam, 0.01 * beam);
  EXPECT_NEAR(sag[1], sag[0], 0.01 * beam);
}

// F L/(E A): the end sections deform where the force is spread over vertices, the middle does not.
TEST_F(StaticStart, ABarUnderAPullStretchesByTheClosedForm) {
  const std::string load = "load = \"constant\"\nat = \"x>0.399\"\nforce = [0.16, 0, 0]\n";
  const Result<StartedWorld> made = world_of(scene_text(bar_text("tets", load), "[0, 0, 0]"));
  ASSERT_TRUE(made) << made.error().message;
  const TetModel& model = made->guests->tets(0)->body().model();
  double stretch = 0.0;
  int count = 0;
  for (std::size_t v = 0; v < model.vertices(); ++v) {
    if (std::abs(model.mesh().vertices[v].x() - 0.5 * kLong) > 1e-9) continue;
    stretch += made->positions(0)[3 * static_cast<Eigen::Index>(v)] - 0.5 * kLong;
    ++count;
  }
  const double exact = 0.16 * 0.5 * kLong / (kYoung * kThick * kThick);
  EXPECT_NEAR(stretch / count, exact, 1e-3 * exact);
}

TEST_F(StaticStart, ItStaysWhereItBegins) {
  const std::string loaded = "load = \"constant\"\nat = \"x>0.399\"\nforce = [0.1, 0.05, -0.2]\n";
  const std::string on_sheet = "load = \"constant\"\nat = \"40\"\nforce = [0.1, 0, -0.5]\n";
  std::vector<std::string> bodies;
  for (const char* method : {"bdf2", "implicit-euler", "midpoint", "newmark"})
    for (const char* degree : {"", "degree = \"adaptive\"\n"}) {
      std::string text = bar_text("tets", std::string("integrator = \"") + method + "\"\n" +
                                              "turn = [1, 2, 3, 40]\n" + loaded);
      if (*degree != '\0') text.replace(text.find("degree"), 21, "degree = \"adaptive\"\n#");
      bodies.push_back(text);
    }
  for (const char* method : {"implicit-euler", "midpoint", "energy"}) {
    const std::string with = std::string("integrator = \"") + method + "\"\n" + kCorners;
    bodies.push_back(sheet_text(with));
    bodies.push_back(sheet_text(with + on_sheet));
    bodies.push_back(sheet_text(with + "turn = [0, 0, 1, 30]\nposition = [3, 2, 1]\n"));
  }
  for (const std::string& body : bodies) {
    SCOPED_TRACE(body);
    Result<StartedWorld> made = world_of(scene_text(body));
    ASSERT_TRUE(made) << made.error().message;
    const VectorXd start = made->positions(0);
    EXPECT_EQ(made->velocities(0).norm(), 0.0);
    for (int k = 0; k < 200; ++k) ASSERT_TRUE(made->step()) << k;
    const double size = body.find("cloth") != std::string::npos ? 1.0 : kLong;
    EXPECT_LT((made->positions(0) - start).lpNorm<Eigen::Infinity>(), 1e-6 * size);
  }
}

TEST_F(StaticStart, ASavedWorldContinuesWithTheSameBits) {
  const std::string text =
      scene_text(bar_text("tets") +
                 sheet_text(kCorners + "load = \"sine\"\nat = \"40\"\nforce = [0, 0, 1]\n") +
                 "[[hands]]\nbody = \"bar\"\nat = \"near:0.4,0,0\"\nstiffness = 50\nfrom = 0.02\n"
                 "[[hands.motion]]\nkind = \"glide\"\nvelocity = [0, 0, 0.1]\nstart = 0.02\n");
  Result<StartedWorld> one = world_of(text), other = world_of(text);
  ASSERT_TRUE(one) << one.error().message;
  for (int k = 0; k < 30; ++k) ASSERT_TRUE(one->step());
  const std::vector<std::byte> saved = one->world.save();
  const Status restored = other->world.restore(saved);
  ASSERT_TRUE(restored) << restored.error().message;
  for (int k = 0; k < 30; ++k) ASSERT_TRUE(one->step() && other->step());
  EXPECT_TRUE(one->world.save() == other->world.save());
  // A scene that begins otherwise is another one.
  std::string at_rest = text;
  at_rest.replace(at_rest.find("start = \"static\""), 16, "start = \"rest\"");
  Result<StartedWorld> third = world_of(at_rest);
  ASSERT_TRUE(third) << third.error().message;
  const Status refused = third->world.restore(saved);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("body 'bar'"), std::string::npos)
      << refused.error().message;
}

TEST_F(StaticStart, WhatHasNoSingleEquilibriumIsRefusedWithItsName) {
  const std::pair<std::string, const char*> cases[] = {
      {"[[bodies]]\nname = \"bar\"\nkind = \"tets\"\nmodel = \"free.tets\"\nstart = \"static\"\n",
       "body 'bar': start = \"static\": it has no fixed vertices"},
      {bar_text("tets", "velocity = [0, 0, 1]\n"), "body 'bar': it has a velocity or a spin"},
      {sheet_text("start = \"static\"\n"), "body 'sheet': start = \"static\": it has no `pins`"},
      {sheet_text("start = \"static\"\npins = \"top-left\"\n"), "not the only one"},
      {sheet_text(kCorners + "velocity = [0, 0, 1]\n"), "start = \"static\" means at rest"},
      {bar_text("tets", "position = [0, 0, 0.03]\n") +
           "[[colliders]]\nname = \"floor\"\nshape = \"plane\"\n",
       "body 'bar': it begins"}};
  for (const auto& [body, words] : cases)
    EXPECT_NE(refusal(scene_text(body)).find(words), std::string::npos)
        << body << refusal(scene_text(body));
}

TEST_F(StaticStart, CopiesOfAClothAreTheClothElsewhere) {
  const std::string more =
      "pins = [\"near:0,0,0\", \"near:1,0,0\"]\nload = \"constant\"\nat = \"x<0.3\"\n"
      "force = [0, 0.2, 0]\nturn = [0, 0, 1, 90]\nposition = [1, 0, 0]\n";
  Result<StartedWorld> one = world_of(scene_text(sheet_text(more)));
  Result<StartedWorld> copies =
      world_of("cloths-pass = true\n" +
               scene_text(sheet_text(more + "copies = [2, 1, 2]\nspacing = [3, 0, 2]\n")));
  ASSERT_TRUE(one) << one.error().message;
  ASSERT_TRUE(copies) << copies.error().message;
  ASSERT_EQ(copies->guests->size(), 4U);
  EXPECT_EQ(copies->guests->name(3), "sheet-4");
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(one->step() && copies->step());
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector3d shift(i % 2 == 1 ? 3.0 : 0.0, 0.0, i / 2 == 1 ? 2.0 : 0.0);
    VectorXd expected = one->positions(0);
    for (Eigen::Index k = 0; k < expected.size(); k += 3) expected.segment<3>(k) += shift;
    EXPECT_LT((copies->positions(i) - expected).lpNorm<Eigen::Infinity>(), 1e-9) << i;
  }
  EXPECT_NE(refusal(scene_text(sheet_text("copies = [2, 1, 1]\nspacing = [3, 0, 0]\n")))
                .find("cloths-pass"),
            std::string::npos);
}

// The same sheet by its own directions.
TEST_F(StaticStart, TheTurnOfAClothIsThatOfItsFrame) {
  const std::string corner = "corner = [0.25, -0.5, 0]\n";
  const Result<StartedWorld> one = world_of(scene_text(sheet_text(
                                 corner + "turn = [0, 0, 1, 90]\nposition = [1, 2, 3]\n"))),
                             other = world_of(scene_text(
                                 sheet_text("corner = [1.5, 2.25, 3]\nalong = [0, 1, 0]\n"
                                            "across = [-1, 0, 0]\n")));
  ASSERT_TRUE(one) << one.error().message;
  ASSERT_TRUE(other) << other.error().message;
  EXPECT_LT((one->positions(0) - other->positions(0)).lpNorm<Eigen::Infinity>(), 1e-12);
}

TEST_F(StaticStart, AClothThatSpinsTurnsAboutItsCentreOfMass) {
  const Result<StartedWorld> made = world_of(
      scene_text(sheet_text("spin = [0, 0, 2]\nvelocity = [1, 0, 0]\nintegrator = \"energy\"\n"),
                 "[0, 0, 0]"));
  ASSERT_TRUE(made) << made.error().message;
  const ClothBody& cloth = made->guests->cloth(0)->body();
  const VectorXd& mass = cloth.model().mass();
  Vector3d momentum = Vector3d::Zero(), centre = Vector3d::Zero(), spin = Vector3d::Zero();
  double inertia = 0.0;
  for (Eigen::Index i = 0; i < mass.size(); ++i) {
    momentum += mass[i] * made->velocities(0).segment<3>(3 * i);
    centre += mass[i] / mass.sum() * made->positions(0).segment<3>(3 * i);
  }
  for (Eigen::Index i = 0; i < mass.size(); ++i) {
    const Vector3d arm = Vector3d(made->positions(0).segment<3>(3 * i)) - centre;
    spin += mass[i] * arm.cross(Vector3d(made->velocities(0).segment<3>(3 * i)));
    inertia += mass[i] * (arm.x() * arm.x() + arm.y() * arm.y());
  }
  EXPECT_NEAR((momentum - mass.sum() * Vector3d::UnitX()).norm(), 0.0, 1e-12);
  EXPECT_NEAR((spin - 2.0 * inertia * Vector3d::UnitZ()).norm(), 0.0, 1e-12);
  EXPECT_NE(refusal(scene_text(sheet_text("pins = \"corners\"\nspin = [0, 0, 2]\n")))
                .find("pins hold the cloth"),
            std::string::npos);
}

}  // namespace
}  // namespace tremolo
