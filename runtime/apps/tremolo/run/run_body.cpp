#include "runtime/apps/tremolo/run/run_body.h"

#include <charconv>
#include <cmath>
#include <utility>

#include "formats/basis/basis_reader.h"
#include "runtime/apps/tremolo/start/start_state.h"
#include "runtime/scene/selection.h"

namespace tremolo {
namespace {

// Reduced and scaled; zero without a load.
Result<Load> reduced_load(const RunInput& input) {
  const SceneLoad& given = input.scene.load();
  Load load{given.signal, Eigen::VectorXd::Zero(input.model->modes())};
  load.signal.table = given.table.get();
  if (load.signal.kind == SignalKind::kNone) return load;
  if (Status s = take(load.force, reduce_load(*input.model, input.forces, given.scale)); !s)
    return value_error(s.error());
  if (!given.at.empty() && given.scale != 0.0 && load.force.isZero(0.0))
    return content_error("--at " + given.at +
                         ": no vertex there moves (they are fixed or belong to no tetrahedron), or "
                         "the force is zero");
  return load;
}

// A model of another material; it is read as a whole, since all of it changes.
Result<Model::Pointer> load_rescaled(const SceneBody& body, const std::string& rescale) {
  Result<BasisData> data = read_basis(body.model);
  if (!data) return data.error();
  data = rescale_model(std::move(*data), rescale, body.model);
  if (!data) return data.error();
  Result<Model::Pointer> model = Model::from_data(*data, body.model_options);
  if (!model) return error_of_file(body.model, value_error(model.error()));
  return model;
}

// The world without the load, whose forces are found already.
Result<SceneWorld> unloaded_world(const RunInput& input) {
  Scene scene = input.scene.file.scene;
  SceneBody& body = scene.bodies.front();
  body.loads.clear();
  Result<SceneWorld> world = SceneWorld::create(
      scene, [&input](const SceneBody&) { return Result<Model::Pointer>(input.model); });
  if (!world) return error_of_body(world.error(), body.name);
  return world;
}

}  // namespace

Error value_error(Error error) {
  if (error.kind == ErrorKind::kUsage) error.kind = ErrorKind::kContent;
  return error;
}

Error error_of_body(Error error, const std::string& name) {
  const std::string start = "body '" + name + "': ";
  if (error.message.starts_with(start)) error.message.erase(0, start.size());
  return value_error(std::move(error));
}

Result<Model::Pointer> load_model(const BodyScene& scene) {
  const SceneBody& body = scene.body();
  if (!scene.rescale.empty()) return load_rescaled(body, scene.rescale);
  Result<Model::Pointer> model = Model::load(body.model, body.model_options);
  if (!model) return value_error(model.error());
  return model;
}

Result<DefaultLoad> load_of_run(const BodyScene& scene, const Model& model) {
  const SceneLoad& load = scene.load();
  if (load.signal.kind == SignalKind::kNone) return DefaultLoad{};
  if (load.at.empty()) {
    if (model.default_load().vertices.empty())
      return usage_error(scene.body().model +
                         ": the model has no default load; name one with --at and --force, or "
                         "--load none");
    return model.default_load();
  }
  const Result<std::vector<VertexId>> vertices = vertices_of(load.at, model);
  if (!vertices) return Error{vertices.error().kind, "--at: " + vertices.error().message};
  return shared_by_area(*vertices, load.force, model);
}

Result<RunInput> load_body(const BodyScene& scene) {
  RunInput input{nullptr, scene, {}};
  if (Status s = take(input.model, load_model(scene)); !s) return s.error();
  if (Status s = take(input.forces, load_of_run(scene, *input.model)); !s) return s.error();
  return input;
}

Result<SceneWorld> world_of_one(const RunInput& input) {
  const BodyScene& scene = input.scene;
  Result<SceneWorld> world = unloaded_world(input);
  if (!world) return world;
  const Result<Load> load = reduced_load(input);
  if (!load) return load.error();
  if (load->signal.kind != SignalKind::kNone) {
    DefaultLoad forces = input.forces;
    for (Eigen::Vector3d& force : forces.forces) force *= scene.load().scale;
    if (Status status = world->add_load(0, scene.load(), forces); !status)
      return value_error(status.error());
  }
  if (scene.start.empty()) return world;
  const double at_start = sample_signal(load->signal, 0.0, scene.step()).start;
  const Result<State> start = start_state(scene.start, *input.model, at_start * load->force);
  if (!start) return start.error();
  if (Status status = world->start_at(0, *start); !status) return value_error(status.error());
  return world;
}

Result<Eigen::VectorXd> largest_load(const RunInput& input) {
  const Result<Load> load = reduced_load(input);
  if (!load) return load.error();
  const SignalKind kind = load->signal.kind;
  const bool lasts = kind == SignalKind::kSquare || kind == SignalKind::kSine ||
                     kind == SignalKind::kConstant || kind == SignalKind::kRamp ||
                     kind == SignalKind::kChirp;
  return lasts ? load->force : Eigen::VectorXd(Eigen::VectorXd::Zero(input.model->modes()));
}

Result<double> parse_share(const std::string& text) {
  const bool percent = text.ends_with('%');
  const char* end = text.data() + text.size() - (percent ? 1 : 0);
  double share = 0.0;
  const auto [stop, error] = std::from_chars(text.data(), end, share);
  if (error != std::errc{} || stop != end)
    return usage_error("--deflect " + text + ": expected a share of the size, as in 5% or 0.05");
  if (percent) share *= 0.01;
  if (!(share > 0) || !std::isfinite(share))
    return content_error("--deflect " + text + ": must be positive and finite");
  return share;
}

}  // namespace tremolo
