#include "tests/lab/bench/reference.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>

#include <fmt/format.h>

namespace tremolo::bench {
namespace {

using Json = nlohmann::json;

Json to_json(const SampledRun& run) {
  return {{"modes", run.q.rows()},
          {"q", orbit_text(run.q)},
          {"high_band", run.high_band},
          {"exit_code", run.exit_code},
          {"reason", run.reason}};
}

SampledRun run_from_json(const Json& json) {
  SampledRun run;
  run.q = orbit_from_text(json.at("q").get<std::string>(), json.at("modes"));
  run.high_band = to_number(json.at("high_band"));
  run.exit_code = json.at("exit_code");
  run.reason = json.at("reason");
  return run;
}

}  // namespace

std::vector<ReferenceMethod> reference_methods() {
  return {{"verlet4", 1e-5, 1e-9}, {"ep4", 3e-3 / 64, 1e-12}};
}

SampledRun reference_orbit(const Scene& scene, const ReferenceMethod& method, const Store& store) {
  Json key = scene.key();
  key["integrator"] = method.integrator;
  key["step"] = method.step;
  key["tolerance"] = method.tolerance;
  key["version"] = 1;
  return run_from_json(store.get("reference-" + scene.name() + "-" + method.integrator, key, [&] {
    RunSpec spec = scene.run(method.integrator, method.step);
    spec.options.tolerance = method.tolerance;
    spec.keep_orbit = true;
    return to_json(run_sampled(spec));
  }));
}

Reference compare_references(const SampledRun& one, const SampledRun& other, double sample) {
  Reference reference;
  reference.q = one.q;
  reference.high_band = one.high_band;
  const Eigen::Index samples = std::min(one.q.cols(), other.q.cols());
  const double scale =
      samples == 0 ? 0.0 : std::sqrt(one.q.squaredNorm() / static_cast<double>(one.q.cols()));
  bool together = true;
  for (Eigen::Index k = 0; k < samples; ++k) {
    const double gap = (one.q.col(k) - other.q.col(k)).norm() / scale;
    reference.worst_gap = std::max(reference.worst_gap, gap);
    together = together && gap <= kAgree;
    if (together) reference.horizon = k + 1;
  }
  reference.seconds = static_cast<double>(reference.horizon) * sample;
  if (one.exit_code != 0) reference.trouble = "the reference broke off: " + one.reason;
  if (other.exit_code != 0) reference.trouble = "the second reference broke off: " + other.reason;
  if (reference.trouble.empty() && reference.horizon == 0)
    reference.trouble = "the two references differ from the start";
  if (reference.horizon > 0) reference.gap = trajectory_error(other.q, one.q, reference.horizon);
  return reference;
}

double trajectory_error(const Eigen::MatrixXd& q, const Eigen::MatrixXd& reference,
                        Eigen::Index samples) {
  if (q.cols() < samples) return std::numeric_limits<double>::infinity();
  const double off = (q.leftCols(samples) - reference.leftCols(samples)).norm();
  return off == 0.0 ? 0.0 : off / reference.leftCols(samples).norm();
}

std::string orbit_text(const Eigen::MatrixXd& q) {
  std::string text;
  text.reserve(16 * static_cast<std::size_t>(q.size()));
  for (const double value : q.reshaped())
    fmt::format_to(std::back_inserter(text), "{:016x}", std::bit_cast<std::uint64_t>(value));
  return text;
}

Eigen::MatrixXd orbit_from_text(std::string_view text, Eigen::Index rows) {
  const Eigen::Index count = text.size() / 16;
  if (rows < 1 || text.size() % 16 != 0 || count % rows != 0) return {};
  Eigen::MatrixXd q(rows, count / rows);
  for (double& value : q.reshaped()) {
    std::uint64_t bits = 0;
    const auto read = std::from_chars(text.data(), text.data() + 16, bits, 16);
    if (read.ptr != text.data() + 16) return {};
    value = std::bit_cast<double>(bits);
    text.remove_prefix(16);
  }
  return q;
}

}  // namespace tremolo::bench
