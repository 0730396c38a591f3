#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/atomic_file.h"
#include "runtime/program/commands.h"
#include "runtime/program/simulate.h"

namespace tremolo {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json to_json(const RunReport& report, const RunOptions& options) {
  Json json;
  json["body"] = report.name;
  json["model"] = options.model;
  json["integrator"] = report.integrator;
  json["load"] = options.load;
  json["step"] = report.step;
  json["duration"] = report.duration;
  json["steps"] = report.steps;
  json["reached"] = report.reached;
  json["iterations_per_step"] = number(report.iterations_per_step);
  json["microseconds_per_step"] = number(report.microseconds_per_step);
  json["real_time_factor"] = number(report.step * 1e6 / report.microseconds_per_step);
  json["energy_initial"] = number(report.energy_initial);
  json["energy_reference"] = number(report.energy_reference);
  json["energy_final"] = number(report.energy_final);
  json["energy_drift_max"] = number(report.energy_drift_max);
  json["high_band_final"] = number(report.high_band_final);
  json["work"] = number(report.work);
  json["dissipated"] = number(report.dissipated);
  json["low_modes"] = report.split ? Json(report.split->low) : Json(nullptr);
  json["high_modes"] = report.split ? Json(report.split->high) : Json(nullptr);
  Json moves = Json::array();
  for (const SplitMove& move : report.moves)
    moves.push_back(
        {{"time", move.time}, {"low_before", move.low_before}, {"low_after", move.low_after}});
  json["split_moves"] = moves;
  json["halved_steps"] = report.halved_steps;
  json["stretch_min"] = number(report.stretch.smallest);
  json["stretch_max"] = number(report.stretch.largest);
  json["squeezed_at"] = report.squeezed_at < 0 ? Json(nullptr) : Json(report.squeezed_at);
  if (!options.probes.empty()) json["largest_probe_displacement"] = number(report.largest_probe);
  json["exit_code"] = report.exit_code;
  json["reason"] = report.reason.empty() ? Json(nullptr) : Json(report.reason);
  json["files"] = report.files;
  return json;
}

void print_text(const RunReport& report) {
  fmt::print(stderr, "{}: {} reached {:.6g} of {:.6g} s in {} steps of {:.4g} s\n", report.name,
             report.integrator, report.reached, report.duration, report.steps, report.step);
  if (report.split)
    fmt::print(stderr, "  {} coordinates explicit, {} implicit\n", report.split->low,
               report.split->high);
  constexpr std::size_t kShown = 8;
  for (std::size_t i = 0; i < std::min(report.moves.size(), kShown); ++i)
    fmt::print(stderr, "  t = {:.6g} s: {} -> {} coordinates explicit\n", report.moves[i].time,
               report.moves[i].low_before, report.moves[i].low_after);
  if (report.moves.size() > kShown)
    fmt::print(stderr, "  ... and {} moves more (--json lists them)\n",
               report.moves.size() - kShown);
  if (report.halved_steps > 0)
    fmt::print(stderr, "  {} steps were taken in parts\n", report.halved_steps);
  fmt::print(stderr, "  {:.2f} us a step ({:.0f} times faster than real time), {:.2f} iterations\n",
             report.microseconds_per_step, report.step * 1e6 / report.microseconds_per_step,
             report.iterations_per_step);
  if (std::isfinite(report.energy_drift_max))
    fmt::print(stderr, "  energy {:.6g} J at the end, largest drift {:.2e}\n", report.energy_final,
               report.energy_drift_max);
  if (report.squeezed_at >= 0)
    fmt::print(
        stderr,
        "  warning: at t = {:.4g} s the surface is squeezed below {:.2f} of its length (at the "
        "worst to {:.2f}): StVK softens there and may turn inside out; use a smaller load or "
        "a stiffer material\n",
        report.squeezed_at, kSofteningStretch, report.stretch.smallest);
  for (const std::string& file : report.files) fmt::print(stderr, "  wrote {}\n", file);
}

}  // namespace

int report_error(const Error& error) {
  fmt::print(stderr, "tremolo: {}\n", error.message);
  return exit_code(error);
}

int run_command(const std::vector<RunOptions>& bodies, bool json) {
  Json objects = Json::array();
  int code = 0;
  for (const RunOptions& options : bodies) {
    Result<RunReport> report = simulate(options);
    if (!report) return report_error(report.error());
    print_text(*report);
    if (report->exit_code != 0) {
      fmt::print(stderr, "tremolo: {}: {}\n", report->name, report->reason);
      code = report->exit_code;
    }
    objects.push_back(to_json(*report, options));
    if (!options.out.empty())
      if (Status status =
              write_file(options.out + "/report.json",
                         objects.back().dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
          !status)
        return report_error(status.error());
  }
  if (json)
    std::cout << (objects.size() == 1 ? objects.front() : Json{{"bodies", objects}})
                     .dump(2, ' ', false, Json::error_handler_t::replace)
              << "\n";
  if (!std::cout.flush()) return report_error(system_error("standard output cannot be written"));
  return code;
}

}  // namespace tremolo
