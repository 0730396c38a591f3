#include "runtime/apps/tremolo/output/sound.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "common/mesh/surface_mesh.h"
#include "common/units.h"
#include "formats/sound/wav_writer.h"
#include "formats/surface/surface_writer.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/bodies/reduced/integrators/dispersion.h"
#include "runtime/scene/selection.h"

namespace tremolo {
namespace {

constexpr double kLoudest = 0.9;

// The vertex of the surface that is nearest to the vertex, which may be inside.
Result<VertexId> nearest_outside(VertexId vertex, const Model& model) {
  const Result<VertexRows> place = model.vertex(vertex);
  if (!place) return place.error();
  const auto& rest = model.surface().rest;
  const auto nearer = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return (a - place->rest).squaredNorm() < (b - place->rest).squaredNorm();
  };
  const auto nearest = std::min_element(rest.begin(), rest.end(), nearer);
  return model.surface().vertex_ids[static_cast<std::size_t>(nearest - rest.begin())];
}

// A default load may act inside, where nothing sounds.
Result<std::vector<VertexId>> listened_to(const std::string& listen, const Model& model) {
  if (!listen.empty()) return vertices_of(listen, model);
  if (model.default_load().vertices.empty())
    return content_error("--wav: the model has no default load: say where to --listen");
  std::vector<VertexId> outside;
  for (const VertexId vertex : model.default_load().vertices) {
    const Result<VertexId> nearest = nearest_outside(vertex, model);
    if (!nearest) return nearest.error();
    outside.push_back(*nearest);
  }
  std::sort(outside.begin(), outside.end());
  outside.erase(std::unique(outside.begin(), outside.end()), outside.end());
  return outside;
}

}  // namespace

Status check_sound(const std::string& path, const std::string& listen, double step) {
  if (path.empty() && !listen.empty())
    return usage_error("--listen chooses what --wav hears: add --wav OUT.wav");
  if (path.empty()) return Success{};
  if (std::filesystem::path(path).extension() != ".wav")
    return usage_error("--wav " + path + ": the file's name must end with .wav");
  const double rate = 1.0 / step;
  if (!(rate > 7999.5 && rate < 192000.5) || std::abs(rate - std::round(rate)) > 1e-6 * rate)
    return content_error(
        fmt::format("--wav: a step of {:.6g} s is {:.6g} samples a second; it must be a whole "
                    "number from 8000 to 192000",
                    step, rate));
  return Success{};
}

SoundFit fit_of_sound(const Model& model, std::string_view method, const IntegratorOptions& options,
                      double rate) {
  const double h = options.step;
  SoundFit fit;
  for (const double lambda : model.lambda()) {
    const double frequency = hertz(lambda), z = h * std::sqrt(lambda);
    const bool linear = model.potential().linear() && !options.moving_frame;
    const std::optional<double> angle = step_angle(method, z, options, linear);
    if (angle && !(frequency < 0.5 * rate)) continue;
    const double error = frequency_error(method, z, options, linear);
    if (error <= fit.worst) continue;
    fit = {error, frequency, angle.value_or(0.0) / (2.0 * std::numbers::pi * h)};
  }
  return fit;
}

int steps_a_sample(const Model& model, std::string_view method, const IntegratorOptions& options,
                   double rate) {
  IntegratorOptions tried = options;
  for (int steps = 1; steps < kMostSoundSteps; ++steps) {
    tried.step = 1.0 / (rate * steps);
    if (fit_of_sound(model, method, tried, rate).worst <= kSoundError) return steps;
  }
  return kMostSoundSteps;
}

std::string sound_warning(const Model& model, std::string_view method,
                          const IntegratorOptions& options, double rate) {
  const SoundFit fit = fit_of_sound(model, method, options, rate);
  if (fit.worst <= kSoundError || !std::isfinite(fit.worst)) return {};
  return fmt::format(
      "with a step of {:.4g} s {} lets the mode of {:.5g} Hz sound at {:.5g} Hz: leave --step out "
      "(--wav then takes as many steps a sample as the modes need)",
      options.step, method, fit.frequency, fit.heard);
}

Result<Ear> Ear::create(const std::string& listen, const Model& model, double rate) {
  if (model.modes() == 0)
    return content_error("--wav: it is rigid and makes no sound: say where to --listen");
  const Result<std::vector<VertexId>> vertices = listened_to(listen, model);
  if (!vertices) return vertices.error();
  const std::vector<Eigen::Vector3d> normals =
      vertex_normals({model.surface().rest, model.triangles()});
  Eigen::VectorXd along = Eigen::VectorXd::Zero(model.modes());
  for (const VertexId vertex : *vertices) {
    const auto at = find_vertex(model.surface().vertex_ids, vertex);
    if (!at && static_cast<std::size_t>(vertex) >= model.vertex_count())
      return content_error(
          fmt::format("--wav: the model has no vertex {}; it has {}, counted from 0", vertex,
                      model.vertex_count()));
    if (!at)
      return content_error(fmt::format(
          "--wav: vertex {} is inside, and sound comes from the surface: say where to --listen",
          vertex));
    const Eigen::Index row = 3 * *at;
    along += model.surface().rows.middleRows(row, 3).transpose() * normals[*at];
  }
  if (along.isZero(0.0))
    return content_error("--wav: what is listened to does not move along its normal");
  for (Eigen::Index i = 0; i < along.size(); ++i)
    if (!(hertz(model.lambda()[i]) < 0.5 * rate)) along[i] = 0.0;
  if (along.isZero(0.0))
    return content_error(
        fmt::format("--wav: every mode is above {:.5g} Hz, half of the samples a second: say a "
                    "shorter --step",
                    0.5 * rate));
  return Ear(along / static_cast<double>(vertices->size()));
}

Status SoundTrack::write(const std::string& path, double interval) const {
  if (places_.size() < 3) return content_error("--wav: the run has less than three samples");
  std::vector<double> samples(places_.size() - 2);
  double most = 0.0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    samples[k] = (places_[k + 2] - 2.0 * places_[k + 1] + places_[k]) / (interval * interval);
    most = std::max(most, std::abs(samples[k]));
  }
  if (!(most > 0.0)) return content_error("--wav: nothing moved: there is no sound to write");
  for (double& sample : samples) sample *= kLoudest / most;
  const auto rate = static_cast<std::uint32_t>(std::llround(1.0 / interval));
  if (Status status = write_wav(path, rate, samples); !status) return status;
  tell("{}: {:.6g} s of sound, {} samples a second, full scale {:.4g} m/s^2\n", path,
       static_cast<double>(samples.size()) * interval, rate, most / kLoudest);
  return Success{};
}

}  // namespace tremolo
