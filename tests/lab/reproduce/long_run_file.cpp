// A long run as JSON, and its checkpoint.
#include <chrono>
#include <filesystem>
#include <optional>

#include "formats/file/atomic_file.h"
#include "formats/file/checksum.h"
#include "formats/file/whole_file.h"
#include "tests/lab/reproduce/long_run.h"

namespace tremolo::reproduce {
namespace {

using Json = nlohmann::json;

constexpr std::chrono::seconds kCheckpointInterval{20};

Json to_json(const Windows& windows) {
  return {{"length", windows.length}, {"count", windows.count}, {"taken", windows.taken},
          {"sum", windows.sum},       {"means", windows.means}, {"first", windows.first},
          {"last", windows.last}};
}

Windows windows_from_json(const Json& json) {
  Windows windows;
  json.at("length").get_to(windows.length);
  json.at("count").get_to(windows.count);
  json.at("taken").get_to(windows.taken);
  json.at("sum").get_to(windows.sum);
  json.at("means").get_to(windows.means);
  json.at("first").get_to(windows.first);
  json.at("last").get_to(windows.last);
  return windows;
}

std::vector<double> numbers(const Eigen::VectorXd& vector) {
  return {vector.begin(), vector.end()};
}

Eigen::VectorXd vector(const Json& json) {
  const auto values = json.get<std::vector<double>>();
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

std::optional<LongRun> read_checkpoint(const std::string& path, const Json& key) {
  const Result<std::string> text = read_whole_file(path);
  if (!text) return std::nullopt;
  const Json json = Json::parse(*text, nullptr, false);
  if (!json.is_object() || json.value("key", Json()) != key || !json.contains("run"))
    return std::nullopt;
  if (json.value("checksum", Json()) != checksum(json.at("run").dump())) return std::nullopt;
  Result<LongRun> run = long_run_from_json(json.at("run"));
  if (!run) return std::nullopt;
  return std::move(*run);
}

Status write_checkpoint(const std::string& path, const Json& key, const LongRun& run) {
  const Json state = to_json(run);
  return write_file(
      path, Json{{"key", key}, {"run", state}, {"checksum", checksum(state.dump())}}.dump());
}

}  // namespace

Json to_json(const LongRun& run) {
  return {{"done", run.done},
          {"q", numbers(run.q)},
          {"p", numbers(run.p)},
          {"reference", run.reference},
          {"drift", run.drift},
          {"iterations", run.iterations},
          {"total", to_json(run.total)},
          {"high_band", to_json(run.high_band)},
          {"exit_code", run.exit_code},
          {"reason", run.reason}};
}

Result<LongRun> long_run_from_json(const Json& json) {
  try {
    LongRun run;
    json.at("done").get_to(run.done);
    run.q = vector(json.at("q"));
    run.p = vector(json.at("p"));
    json.at("reference").get_to(run.reference);
    json.at("drift").get_to(run.drift);
    json.at("iterations").get_to(run.iterations);
    run.total = windows_from_json(json.at("total"));
    run.high_band = windows_from_json(json.at("high_band"));
    json.at("exit_code").get_to(run.exit_code);
    json.at("reason").get_to(run.reason);
    return run;
  } catch (const Json::exception& error) {
    return content_error(std::string("not a stored long run: ") + error.what());
  }
}

Result<LongRun> run_to_end(const LongRunSpec& spec, const std::string& checkpoint, const Json& key,
                           const std::function<void(const LongRun&)>& report) {
  std::optional<LongRun> run = read_checkpoint(checkpoint, key);
  if (!run) {
    Result<LongRun> started = start_long_run(spec);
    if (!started) return started;
    run = std::move(*started);
  }
  auto written = std::chrono::steady_clock::now();
  while (!is_over(spec, *run)) {
    if (Status status = advance(spec, *run); !status) return status.error();
    const auto now = std::chrono::steady_clock::now();
    if (now - written < kCheckpointInterval || is_over(spec, *run)) continue;
    if (Status status = write_checkpoint(checkpoint, key, *run); !status) return status.error();
    report(*run);
    written = std::chrono::steady_clock::now();
  }
  return std::move(*run);
}

}  // namespace tremolo::reproduce
