#include "tests/lab/bench/scene.h"

#include <limits>

#include <fmt/format.h>

#include "runtime/program/start/load_search.h"
#include "runtime/split.h"

namespace tremolo::bench {
namespace {

using Json = nlohmann::json;

Result<LoadAttempt> attempt(const Scene& scene, double scale, const std::string& method,
                            double step) {
  Scene trial = scene;
  trial.scale = scale;
  RunSpec spec = trial.run(method, step);
  spec.watched = scene.subject->watched;
  Result<SampledRun> run = run_sampled(spec);
  if (!run) return run.error();
  const bool broke = run->exit_code != 0;
  return LoadAttempt{
      scale, broke ? std::numeric_limits<double>::infinity() : run->largest / scene.subject->size,
      run->reason};
}

Result<Json> search(const Scene& scene, const std::string& method, double step) {
  const Result<LoadScale> found = search_load_scale(
      scene.amplitude, [&](double scale) { return attempt(scene, scale, method, step); });
  if (!found) return found.error();
  return Json{{"scale", found->scale}, {"trouble", found->trouble}};
}

}  // namespace

Result<Subject> make_subject(SampleModel sample) {
  Subject subject;
  const Model& model = *sample.model;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& point : model.surface().rest) box.extend(point);
  subject.size = box.sizes().maxCoeff();
  Result<VertexRows> vertex = model.vertex(model.default_load().vertices.front());
  if (!vertex) return vertex.error();
  subject.watched = vertex->rows;
  Result<Eigen::VectorXd> force = reduce_load(model, model.default_load());
  if (!force) return force.error();
  subject.force = std::move(*force);
  Result<Split> split = choose_split(model.lambda(), 3e-3, {});
  if (!split) return split.error();
  subject.band = split->low;
  subject.sample = std::move(sample);
  return subject;
}

std::string Scene::name() const {
  return fmt::format("{}-{}-{:g}", subject->sample.name, load, amplitude);
}

Json Scene::key() const {
  return {{"model", subject->sample.checksum},
          {"load", load},
          {"duration", duration},
          {"scale", scale}};
}

RunSpec Scene::run(const std::string& integrator, double step) const {
  RunSpec spec;
  spec.model = subject->sample.model;
  spec.integrator = integrator;
  spec.options.step = step;
  spec.load = {*parse_signal(load), scale * subject->force};
  spec.duration = duration;
  spec.band = subject->band;
  return spec;
}

Status find_scale(Scene& scene, const Store& store) {
  const std::string method = "ep4";
  const double step = 1.5e-3;
  Json key = scene.key();
  key["amplitude"] = scene.amplitude;
  key["method"] = method;
  key["version"] = 1;
  Result<Json> found =
      store.get("scale-" + scene.name(), key, [&] { return search(scene, method, step); });
  if (!found) return found.error();
  scene.scale = found->at("scale");
  scene.trouble = found->at("trouble");
  return Success{};
}

}  // namespace tremolo::bench
