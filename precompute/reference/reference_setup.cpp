#include "precompute/reference/reference_setup.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "formats/basis/selector_reader.h"
#include "formats/file/atomic_file.h"
#include "precompute/options/named_files.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

void require(bool good, const char* message) {
  if (!good) throw Failure(content_error(message));
}

void make_folder(const std::string& path) {
  if (path.empty()) return;
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) throw Failure(system_error(path + ": cannot create: " + error.message()));
}

}  // namespace

void check_reference(const ReferenceOptions& options) {
  const TimeSettings& time = options.time;
  require(time.step > 0 && std::isfinite(time.step), "--step must be positive and finite (s)");
  require(options.duration > 0 && std::isfinite(options.duration),
          "--duration must be positive and finite (s)");
  require(options.statics || options.duration >= 0.5 * time.step,
          "--duration is shorter than half a step: nothing would be done");
  require(options.duration / time.step <= 1e9, "--duration and --step ask for more than 1e9 steps");
  require(time.alpha >= 0 && std::isfinite(time.alpha),
          "--alpha must not be negative, and finite (1/s)");
  require(time.beta >= 0 && std::isfinite(time.beta),
          "--beta must not be negative, and finite (s)");
  require(std::isfinite(options.scale), "--scale must be finite");
  require(options.gravity.allFinite(), "--gravity must be finite (m/s^2)");
  require(options.tolerance > 0 && options.tolerance < 1, "--tolerance must be between 0 and 1");
  require(options.max_iterations >= 1, "--max-iterations must be at least 1");
  require(options.every >= 1, "--every must be at least 1");
}

std::string table_path(const ReferenceOptions& options) {
  return (std::filesystem::path(options.out) / "run.csv").string();
}

std::vector<VertexId> probe_vertices(const ReferenceOptions& options, const TetMesh& mesh) {
  std::vector<VertexId> ids;
  for (const std::string& text : options.probes) {
    VertexId id = 0;
    const char* end = text.data() + text.size();
    const auto [stop, code] = std::from_chars(text.data(), end, id);
    const bool number = stop == end && code == std::errc{};
    for (VertexId v : unwrap(resolve_selector(number ? "vertex:" + text : text, mesh)))
      if (std::find(ids.begin(), ids.end(), v) == ids.end()) ids.push_back(v);
  }
  return ids;
}

void require_output(const ReferenceOptions& options) {
  if (options.out.empty()) return;
  std::vector<NamedFile> inputs = input_files(options.solid, options.config_path);
  if (!options.support_motion.empty())
    inputs.push_back({options.support_motion, "--support-motion"});
  for (const std::string& file : options.compare) inputs.push_back({file, "--compare"});
  for (const std::string& probe : options.probes) add_files_of_selector(probe, "--probe", inputs);
  unwrap(keep_apart({table_path(options)}, inputs));
  make_folder(options.out);
  const Result<AtomicFile> file = AtomicFile::create(table_path(options));
  if (!file) throw Failure(file.error());
}

Vector BodyLoads::mean(double time, double step) const {
  return sample_signal(signal, time, step).average * point + gravity;
}

double BodyLoads::share_at(double time, double step) const {
  return time > 0.0 ? sample_signal(signal, time - step, step).end : 0.0;
}

bool BodyLoads::to_come(double time, double step) const {
  return !gravity.isZero(0.0) || time < signal_end(signal) - 1e-9 * step;
}

BodyLoads make_body_loads(const ReferenceOptions& options, const Problem& problem,
                          const FullOrder& body) {
  BodyLoads loads;
  loads.signal = unwrap(parse_signal(options.load.value_or("impulse")));
  const Vector point = options.scale * point_load(body, problem.load);
  loads.point = deforming_load(body, point);
  loads.gravity = deforming_load(body, gravity_load(body, options.gravity));
  if (problem.load.vertices.empty()) {
    if (options.load && loads.signal.kind != SignalKind::kNone)
      throw Failure(
          {ErrorKind::kUsage, "--load needs a default load: give --load-at and --load-force"});
    loads.signal = {};
  } else if (options.scale != 0 && point.isZero(0.0)) {
    throw Failure(content_error("--load-at: the force acts along held components only"));
  }
  const bool pushed = loads.signal.kind != SignalKind::kNone && !point.isZero(0.0);
  if (!pushed) loads.point.setZero();
  if (!loads.point.isZero(0.0) || !loads.gravity.isZero(0.0)) return loads;
  if (problem.free_body && (pushed || !options.gravity.isZero(0.0)))
    throw Failure(content_error("the load moves the free body as a whole and deforms nothing"));
  throw Failure(
      {ErrorKind::kUsage, "nothing loads the body: use --load-at with --load-force, or --gravity"});
}

}  // namespace tremolo
