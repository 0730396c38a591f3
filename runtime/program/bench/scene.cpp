#include "runtime/program/bench/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "runtime/split.h"

namespace tremolo::bench {
namespace {

using Json = nlohmann::json;

constexpr int kAttempts = 30;
constexpr double kNear = 0.01;  // relative, of the amplitude

double four_digits(double value) {
  return std::stod(fmt::format("{:.4g}", value));
}

struct Attempt {
  double scale = 0.0;
  double amplitude = 0.0;  // infinite if the run broke off
  std::string reason;
};

// Secant steps on logarithms, kept inside the bracket once there is one.
class Search {
 public:
  explicit Search(double wanted) : wanted_(wanted) {}

  void take(const Attempt& attempt) {
    Attempt& side = attempt.amplitude < wanted_ ? low_ : high_;
    side = attempt;
  }

  double next(const Attempt& last) const {
    if (high_.scale == 0.0) return last.scale * std::clamp(wanted_ / last.amplitude, 1.05, 10.0);
    if (low_.scale == 0.0)
      return std::isfinite(last.amplitude)
                 ? last.scale * std::clamp(wanted_ / last.amplitude, 0.1, 0.95)
                 : 0.1 * last.scale;
    const double width = std::log(high_.scale / low_.scale);
    const double slope = std::log(high_.amplitude / low_.amplitude);
    const double part = std::isfinite(slope) ? std::log(wanted_ / low_.amplitude) / slope : 0.5;
    return low_.scale * std::exp(width * std::clamp(part, 0.1, 0.9));
  }

  bool closed() const {
    return low_.scale > 0.0 && high_.scale > 0.0 && high_.scale < 1.002 * low_.scale;
  }

  std::string trouble() const {
    if (!high_.reason.empty())
      return fmt::format("with {:.4g} times the default load, at {:.3g} of the size: {}",
                         low_.scale, low_.amplitude,
                         "the next larger one breaks off: " + high_.reason);
    return fmt::format(
        "the displacement jumps from {:.3g} to {:.3g} of the size near {:.4g} times "
        "the default load",
        low_.amplitude, high_.amplitude, high_.scale);
  }

 private:
  double wanted_;
  Attempt low_, high_;
};

Result<Attempt> attempt(const Scene& scene, double scale, const std::string& method, double step) {
  Scene trial = scene;
  trial.scale = scale;
  RunSpec spec = trial.run(method, step);
  spec.watched = scene.subject->watched;
  Result<SampledRun> run = run_sampled(spec);
  if (!run) return run.error();
  const bool broke = run->exit_code != 0;
  return Attempt{
      scale, broke ? std::numeric_limits<double>::infinity() : run->largest / scene.subject->size,
      run->reason};
}

Result<Json> search(const Scene& scene, const std::string& method, double step) {
  Search search(scene.amplitude);
  double scale = 1e-2;
  for (int i = 0; i < kAttempts && !search.closed(); ++i) {
    Result<Attempt> result = attempt(scene, four_digits(scale), method, step);
    if (!result) return result.error();
    if (!(result->amplitude > 0.0))
      return Json{{"scale", 0.0}, {"trouble", "the load does not move the loaded vertex"}};
    if (std::abs(result->amplitude / scene.amplitude - 1.0) <= kNear)
      return Json{{"scale", result->scale}, {"trouble", ""}};
    search.take(*result);
    scale = search.next(*result);
  }
  return Json{{"scale", 0.0}, {"trouble", search.trouble()}};
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
