// A file's stored response to forces at points (tremolo-precompute --response-at): under a constant
// force the displayed shape is that of the whole mesh, for any basis.
#include <cmath>
#include <numbers>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/basis/basis_reader.h"
#include "formats/basis/basis_writer.h"
#include "formats/basis/derived_basis.h"
#include "runtime/contact_body.h"
#include "runtime/io/exchange/recording.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

class Response : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fresh_folder();
    write_veg(folder_ + "/block.veg", block_);
  }
  static constexpr const char* kSolid =
      " --young 1e6 --poisson 0.3 --density 1000 --threads 1 --fix 'x<0.001' ";

  VertexId near(const Vector3d& place) const {
    VertexId nearest = 0;
    for (std::size_t v = 0; v < block_.vertices.size(); ++v)
      if ((block_.vertices[v] - place).norm() < (block_.vertices[nearest] - place).norm())
        nearest = static_cast<VertexId>(v);
    return nearest;
  }
  ProgramResult run(const std::string& arguments, const std::string& before = "") {
    return run_program(folder_, before + kPrecompute + "block.veg" + arguments);
  }
  std::string made(const std::string& arguments, const std::string& name,
                   const std::string& before = "") {
    const ProgramResult result = run(arguments + " -o " + name, before);
    EXPECT_EQ(result.code, 0) << result.err;
    return folder_ + "/" + name;
  }
  // Displacements of the probes at rest under a force, by the whole mesh's own statics.
  std::vector<Vector3d> whole(const std::string& order, VertexId at, const std::string& force,
                              const std::vector<VertexId>& probes) {
    std::string arguments = "reference block.veg --order " + order + kSolid + "--static --json" +
                            " --load-at vertex:" + std::to_string(at) + " --load-force=" + force;
    for (const VertexId probe : probes) arguments += " --probe vertex:" + std::to_string(probe);
    const ProgramResult result = run_program(folder_, kPrecompute + arguments);
    EXPECT_EQ(result.code, 0) << result.err;
    const auto report = nlohmann::json::parse(result.out, nullptr, false);
    std::vector<Vector3d> found;
    for (const auto& probe : report["probes"]) {
      const auto& u = probe["displacement"];
      found.emplace_back(u[0].get<double>(), u[1].get<double>(), u[2].get<double>());
    }
    return found;
  }

  std::string folder_;
  TetMesh block_ = box_mesh({6, 2, 2}, {1.0, 0.31, 0.23});
};

Model::Pointer loaded(const std::string& path, const ModelOptions& options = {}) {
  Result<Model::Pointer> model = Model::load(path, options);
  EXPECT_TRUE(model) << (model ? "" : model.error().message);
  return *model;
}

// At rest under the force, which acts in the step that was made.
ContactBody held(const Model::Pointer& model, VertexId at, const Vector3d& force) {
  ContactBody body = std::move(*ContactBody::create(model, "ep4"));
  const Eigen::VectorXd reduced = *reduce_force(*model, at, force);
  EXPECT_TRUE(body.set_state(reduced.cwiseQuotient(model->lambda()),
                             Eigen::VectorXd::Zero(model->modes())));
  EXPECT_TRUE(body.apply_force(at, force, 1));
  EXPECT_TRUE(body.step().converged);
  return body;
}

TEST_F(Response, UnderAHeldForceTheShownShapeIsThatOfTheWholeMeshHoweverSmallTheBasis) {
  const VertexId tip = near({1.0, 0.155, 0.23}), side = near({0.5, 0.31, 0.115});
  // A displacement of 1e-8: its nonlinear part is below 1e-6 of it.
  const Vector3d force(2e-6, -3e-6, 5e-6);
  for (const std::string order : {"1", "2"}) {
    const std::vector<Vector3d> truth = whole(order, tip, "2e-6,-3e-6,5e-6", {tip, side});
    ASSERT_EQ(truth.size(), 2u);
    for (const std::string modes : {"3", "9"}) {
      const Model::Pointer model =
          loaded(made(" --order " + order + kSolid + "--linear-modes 3 --modes " + modes +
                          " --response-at vertex:" + std::to_string(tip),
                      "kept.tremolo"));
      const ContactBody body = held(model, tip, force);
      EXPECT_LE((*body.displacement(tip) - truth[0]).norm(), 1e-6 * truth[0].norm())
          << order << " " << modes;
      EXPECT_LE((*body.displacement(side) - truth[1]).norm(), 1e-6 * truth[1].norm());
      // Without it the loaded spot deflects less.
      const Vector3d alone = model->vertex(tip)->rows * body.state().q;
      EXPECT_GT((alone - truth[0]).norm(), 0.02 * truth[0].norm()) << order << " " << modes;
    }
  }
}

TEST_F(Response, TheDefaultLoadIsAPlaceOfItsOwn) {
  const std::string load = " --load-at 'x>0.999' --load-force=1e-6,2e-6,-4e-6 ";
  const ProgramResult refused = run(kSolid + std::string("--response-at load -o no.tremolo"));
  EXPECT_EQ(refused.code, 3);
  EXPECT_NE(refused.err.find("no default load"), std::string::npos) << refused.err;
  std::vector<Vector3d> shown;
  for (const std::string modes : {"3", "12"}) {
    const Model::Pointer model = loaded(
        made(kSolid + load + "--order 2 --linear-modes 4 --response-at load --modes " + modes,
             "l.tremolo"));
    ASSERT_TRUE(model->response_place(kAtDefaultLoad));
    ContactBody body = std::move(*ContactBody::create(model, "ep4"));
    const Eigen::VectorXd reduced = *reduce_load(*model, model->default_load(), 0.5);
    ASSERT_TRUE(body.set_state(reduced.cwiseQuotient(model->lambda()),
                               Eigen::VectorXd::Zero(model->modes())));
    ASSERT_TRUE(body.add_default_load({.kind = SignalKind::kSquare}, 0.5));
    ASSERT_TRUE(body.step().converged);
    EXPECT_LE((body.shown().tail<3>() - Vector3d(0.5e-6, 1e-6, -2e-6)).norm(), 1e-18);
    shown.push_back(*body.displacement(near({1.0, 0.31, 0.23})));
  }
  EXPECT_LE((shown[0] - shown[1]).norm(), 1e-6 * shown[1].norm());
}

// The corners of the face have less area around them than its middle: a unit force that is shared
// equally is another load.
TEST_F(Response, UnderTheDefaultLoadOnAFaceTheShownShapeIsThatOfTheWholeMesh) {
  const VertexId tip = near({1.0, 0.155, 0.115}), corner = near({1.0, 0.31, 0.23});
  for (const std::string order : {"1", "2"}) {
    const ProgramResult statics = run_program(
        folder_, kPrecompute + "reference block.veg --order " + order + kSolid +
                     "--static --json --load-at 'x>0.999' --load-force=1e-6,2e-6,-4e-6 --probe "
                     "vertex:" +
                     std::to_string(tip) + " --probe vertex:" + std::to_string(corner));
    ASSERT_EQ(statics.code, 0) << statics.err;
    const auto truth = nlohmann::json::parse(statics.out)["probes"];
    const Model::Pointer model = loaded(
        made(kSolid +
                 std::string(" --load-at 'x>0.999' --load-force=1e-6,2e-6,-4e-6 --linear-modes 3 "
                             "--modes 3 --response-at load --order ") +
                 order,
             "face.tremolo"));
    Body body = std::move(*Body::create(model, "ep4"));
    const Eigen::VectorXd reduced = *reduce_load(*model, model->default_load(), 1.0);
    ASSERT_TRUE(body.set_state(reduced.cwiseQuotient(model->lambda()),
                               Eigen::VectorXd::Zero(model->modes())));
    ASSERT_TRUE(body.add_default_load({.kind = SignalKind::kConstant}, 1.0));
    ASSERT_TRUE(body.step().converged);
    std::size_t probe = 0;
    for (const VertexId vertex : {tip, corner}) {
      const auto& u = truth[probe++]["displacement"];
      const Vector3d expected(u[0].get<double>(), u[1].get<double>(), u[2].get<double>());
      // The part that is not linear in a displacement of 1e-8 is below 1e-6 of it; equal shares are
      // off by more than 1e-3.
      EXPECT_LE((*body.displacement(vertex) - expected).norm(), 1e-6 * expected.norm())
          << order << " " << vertex;
    }
  }
}

TEST_F(Response, SeveralRanksAndACompactFileGiveTheSame) {
  const VertexId tip = near({1.0, 0.155, 0.23});
  const std::string arguments =
      std::string(kSolid) +
      "--order 2 --linear-modes 4 --modes 8 --response-at vertex:" + std::to_string(tip);
  const BasisData one = *read_basis(made(arguments, "one.tremolo"));
  const BasisData three =
      *read_basis(made(arguments, "three.tremolo", kMayBeRoot + "mpiexec --oversubscribe -n 3 "));
  ASSERT_EQ(one.response.at, std::vector<VertexId>{tip});
  // As models of one and several ranks do (ranks_program_test.cpp).
  EXPECT_LE((one.response.surface - three.response.surface).norm(),
            1e-9 * one.response.surface.norm());
  EXPECT_LE((one.response.interior - three.response.interior).norm(),
            1e-9 * one.response.surface.norm());

  const Model::Pointer compact = loaded(made(arguments + " --encoding compact", "c.tremolo"));
  ContactBody body = held(compact, tip, {20.0, -30.0, 50.0});
  const std::size_t numbers = 3 * compact->drawn().rest.size();
  std::vector<double> exact(numbers);
  std::vector<float> drawn(numbers);
  ASSERT_TRUE(body.surface_positions(std::span<double>(exact)));
  ASSERT_TRUE(body.surface(std::span<float>(drawn)));
  // 2^-16 of the response and the rounding of floats, of 1 m.
  for (std::size_t i = 0; i < numbers; ++i) EXPECT_NEAR(exact[i], drawn[i], 2e-5 * 0.05 + 1e-6);
}

TEST_F(Response, AFreeBodyGivesWayAroundItsRigidMotion) {
  const VertexId tip = near({1.0, 0.155, 0.23});
  std::vector<BasisRows> answers;
  for (const std::string modes : {"6", "14"}) {
    const BasisData data = *read_basis(
        made(" --young 1e6 --poisson 0.3 --density 1000 --threads 1 --fix none --order 1 "
             "--linear-modes 6 --modes " +
                 modes + " --response-at vertex:" + std::to_string(tip),
             "free.tremolo"));
    const auto at =
        std::lower_bound(data.surface.vertex_ids.begin(), data.surface.vertex_ids.end(), tip) -
        data.surface.vertex_ids.begin();
    const BasisRows here = data.surface.rows.middleRows(3 * at, 3);
    answers.push_back(data.surface.rows *
                          (data.lambda.cwiseInverse().asDiagonal() * here.transpose()) +
                      data.response.surface);
  }
  // U Lambda^-1 U^T + W is the whole mesh's answer, of which r is not a part.
  EXPECT_LE((answers[0] - answers[1]).norm(), 1e-8 * answers[0].norm());
}

TEST_F(Response, AForceAlongTheWorldsAxesIsTurnedIntoTheBodys) {
  const VertexId tip = near({1.0, 0.155, 0.23});
  const Model::Pointer model = loaded(
      made(std::string(kSolid) +
               "--order 1 --linear-modes 3 --modes 6 --response-at vertex:" + std::to_string(tip),
           "kept.tremolo"));
  ContactBody body = std::move(*ContactBody::create(model, "ep4", {}, FrameKind::kDriven));
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitZ()));
  ASSERT_TRUE(body.set_pose({{1.0, 2.0, 3.0}, turn}));
  const Vector3d force(0.0, 3.0, 1.0);
  ASSERT_TRUE(body.apply_force(tip, force, 2));
  ASSERT_TRUE(body.step().converged);
  const Eigen::VectorXd& shown = body.shown();
  EXPECT_LE((shown.tail<3>() - Vector3d(3.0, 0.0, 1.0)).norm(), 1e-12);
  const VertexRows rows = *model->vertex(tip), response = *model->response(tip);
  const Vector3d there =
      turn * (rows.rest + rows.rows * body.state().q + response.rows * shown.tail<3>()) +
      Vector3d(1.0, 2.0, 3.0);
  EXPECT_LE((*body.position(tip) - there).norm(), 1e-12);
  ASSERT_TRUE(body.step().converged);
  EXPECT_FALSE(body.shown().tail<3>().isZero());
  ASSERT_TRUE(body.step().converged);
  EXPECT_TRUE(body.shown().tail<3>().isZero());  // the two steps are over
}

TEST_F(Response, AHandAtAPlaceDentsItAndSavedBodiesGoOnWithTheSameBits) {
  const VertexId tip = near({1.0, 0.155, 0.23});
  const Model::Pointer model = loaded(
      made(std::string(kSolid) +
               "--order 1 --linear-modes 3 --modes 6 --response-at vertex:" + std::to_string(tip),
           "kept.tremolo"));
  const auto create = [&] {
    ContactBody body = std::move(*ContactBody::create(model, "ep4"));
    EXPECT_TRUE(body.set_contact());
    EXPECT_TRUE(body.add_load({.kind = SignalKind::kSine, .frequency = 5.0}, tip, {1.0, 0.0, 2.0}));
    return body;
  };
  ContactBody body = create();
  const auto hand = body.grab(tip, 500.0, 1.0);
  ASSERT_TRUE(hand);
  ASSERT_TRUE(body.apply_force(tip, {0.0, 1.0, 0.0}, 12));
  for (int step = 0; step < 8; ++step) {
    ASSERT_TRUE(body.move_hand(*hand, *body.position(tip) + Vector3d(0.0, 0.0, 0.02)));
    ASSERT_TRUE(body.step().converged);
  }
  const double t = body.time();
  const Vector3d load = std::sin(2.0 * std::numbers::pi * 5.0 * t) * Vector3d(1.0, 0.0, 2.0);
  const Vector3d all = load + Vector3d::UnitY() + body.hand_force(*hand);
  EXPECT_GT(body.hand_force(*hand).norm(), 1.0);
  EXPECT_LE((body.shown().tail<3>() - all).norm(), 1e-12 * all.norm());

  ContactBody other = create();
  ASSERT_TRUE(other.restore(body.save()));
  EXPECT_EQ(other.shown(), body.shown());
  for (int step = 0; step < 8; ++step) {
    ASSERT_TRUE(body.step().converged);
    ASSERT_TRUE(other.step().converged);
    EXPECT_EQ(other.shown(), body.shown());
  }
}

TEST_F(Response, RecordingsAndLightFilesKeepIt) {
  const VertexId tip = near({1.0, 0.155, 0.23});
  const BasisData data = *read_basis(
      made(std::string(kSolid) + "--order 2 --linear-modes 3 --modes 6 --response-at vertex:" +
               std::to_string(tip) + " --response-at near:0.5,0.155,0.115,1",
           "kept.tremolo"));
  ASSERT_EQ(data.response.at.size(), 2u);
  const ContactBody body = held(*Model::from_data(data), tip, {1.0, -2.0, 3.0});
  Recording recording;
  const auto track = recording.add(body, "bar");
  ASSERT_TRUE(track);
  ASSERT_TRUE(recording.begin_frame(0.0));
  ASSERT_TRUE(recording.record(*track, body));
  const Animation animation = *recording.animation();
  std::vector<double> shown(3 * body.model().drawn().rest.size()), written(shown.size());
  ASSERT_TRUE(body.surface_positions(std::span<double>(shown)));
  world_positions(animation, animation.bodies[0], 0, written);
  for (std::size_t i = 0; i < shown.size(); ++i) EXPECT_NEAR(shown[i], written[i], 1e-13);

  // The second point is inside: a light file has no vertices there.
  const BasisData light = *without_interior(data);
  ASSERT_EQ(light.response.at.size(), 1u);
  const auto bytes = encode_basis(light, BasisEncoding::kFull);
  ASSERT_TRUE(bytes);
  const auto model = Model::load_from_memory(*bytes);
  ASSERT_TRUE(model) << model.error().message;
  const ContactBody small = held(*model, light.response.at[0], {1.0, -2.0, 3.0});
  EXPECT_LE((*small.displacement(light.response.at[0]) - *body.displacement(tip)).norm(), 1e-12);
}

TEST_F(Response, WrongPlacesAreNamed) {
  const auto fails = [&](const std::string& arguments, int code, const std::string& word) {
    const ProgramResult result = run(kSolid + arguments + " -o no.tremolo");
    EXPECT_EQ(result.code, code) << arguments;
    EXPECT_NE(result.err.find(word), std::string::npos) << result.err;
  };
  fails("--response-at vertex:0", 3, "vertex 0 is fixed");
  fails("--response-at 'x>5'", 3, "x>5");
  fails("--response-at nonsense", 2, "nonsense");
  write_veg(folder_ + "/block.veg", box_mesh({12, 6, 6}, {1.0, 0.31, 0.23}));
  fails("--order 1 --response-at 'x>0.2'", 3, "256");
}

// What `tremolo run` writes of a body at rest under its default load is the whole mesh's shape. The
// displacement of 1e-4 is well above the digits of the surface; its nonlinear part is below 1e-3.
TEST_F(Response, IsInTheProbesAndSurfacesOfARun) {
  const VertexId tip = near({1.0, 0.155, 0.23});
  const std::string at = "vertex:" + std::to_string(tip);
  made(kSolid + std::string("--order 1 --linear-modes 3 --modes 6 --response-at load --load-at ") +
           at + " --load-force=2e-2,-3e-2,5e-2",
       "r.tremolo");
  const std::vector<Vector3d> truth = whole("1", tip, "2e-2,-3e-2,5e-2", {tip});
  ASSERT_EQ(truth.size(), 1u);
  const ProgramResult ran =
      run_program(folder_, kTremolo +
                               "run r.tremolo --start static --load constant --step 0.001 "
                               "--duration 0.01 --out out --surfaces 2 --surface-format obj --json "
                               "--probe " +
                               at);
  ASSERT_EQ(ran.code, 0) << ran.err;
  const auto report = nlohmann::json::parse(ran.out);
  EXPECT_NEAR(report["largest_probe_displacement"].get<double>(), truth[0].norm(),
              2e-3 * truth[0].norm());
  std::istringstream table(slurp(folder_ + "/out/run.csv"));
  std::string row, last;
  while (std::getline(table, row)) last = row;
  std::vector<double> values;
  for (std::istringstream cells(last); std::getline(cells, row, ',');)
    values.push_back(std::stod(row));
  ASSERT_GE(values.size(), 3u);
  EXPECT_LE((Vector3d(values.end()[-3], values.end()[-2], values.end()[-1]) - truth[0]).norm(),
            2e-3 * truth[0].norm());
  // The vertex of the last surface that moves most is the loaded one.
  std::istringstream surface(slurp(folder_ + "/out/surface-0001-t0.010000s.obj"));
  double nearest = INFINITY;
  while (std::getline(surface, row)) {
    Vector3d x;
    std::istringstream words(row);
    std::string kind;
    if (!(words >> kind >> x[0] >> x[1] >> x[2]) || kind != "v") continue;
    nearest =
        std::min(nearest, (x - block_.vertices[static_cast<std::size_t>(tip)] - truth[0]).norm());
  }
  EXPECT_LE(nearest, 5e-3 * truth[0].norm());
}

}  // namespace
}  // namespace tremolo
