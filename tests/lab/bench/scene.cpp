#include "tests/lab/bench/scene.h"

#include <limits>

#include <fmt/format.h>

#include "runtime/apps/tremolo/start/run_notes.h"
#include "runtime/split.h"
#include "tests/lab/work/failure.h"

namespace tremolo::bench {
namespace {

using Json = nlohmann::json;

constexpr const char* kSearchMethod = "ep4";
constexpr double kSearchStep = 1.5e-3;  // s

LoadAttempt attempt(const Scene& scene, double scale) {
  Scene trial = scene;
  trial.scale = scale;
  RunSpec spec = trial.run(kSearchMethod, kSearchStep);
  spec.watched = scene.subject->watched;
  const SampledRun run = run_sampled(spec);
  return {
      scale,
      run.finished() ? run.largest / scene.subject->size : std::numeric_limits<double>::infinity(),
      run.reason};
}

}  // namespace

Subject make_subject(SampleModel sample) {
  Subject subject;
  const Model& model = *sample.model;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& point : model.surface().rest) box.extend(point);
  subject.size = box.sizes().maxCoeff();
  subject.watched = or_fail(model.vertex(model.default_load().vertices.front())).rows;
  subject.force = or_fail(reduce_load(model, model.default_load()));
  subject.band = or_fail(choose_split(model.lambda(), 3e-3, {})).low;
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

void find_scale(Scene& scene, const Store& store) {
  Json key = scene.key();
  key["amplitude"] = scene.amplitude;
  key["method"] = kSearchMethod;
  key["version"] = 1;
  const Json stored = store.get("scale-" + scene.name(), key, [&] {
    const LoadScale found =
        or_fail(search_load_scale(scene.amplitude, [&](double scale) -> Result<LoadAttempt> {
          return attempt(scene, scale);
        }));
    return Json{{"scale", found.scale}, {"trouble", found.trouble}};
  });
  scene.scale = stored.at("scale");
  scene.trouble = stored.at("trouble");
}

}  // namespace tremolo::bench
