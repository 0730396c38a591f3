// Runs of the FPUT chain that survive a second start.
#include <fmt/format.h>

#include "tests/lab/known/sections.h"

namespace tremolo::known {
namespace {

using Json = nlohmann::json;

Json to_json(const FputRun& run) {
  Json series = Json::array();
  for (const FputEnergies& e : run.series) series.push_back({e.t, e.i[0], e.i[1], e.i[2]});
  return {{"second", known::to_json(run.second)},
          {"third", known::to_json(run.third)},
          {"lost", known::to_json(run.lost)},
          {"lowest", run.lowest},
          {"highest", run.highest},
          {"energy_error", run.energy_error},
          {"reached", run.reached},
          {"cut_steps", run.cut_steps},
          {"failure", run.failure},
          {"series", series}};
}

FputRun from_json(std::string_view method, double step, const Json& json) {
  FputRun run;
  run.method = method;
  run.step = step;
  run.second = to_optional(json["second"]);
  run.third = to_optional(json["third"]);
  run.lost = to_optional(json["lost"]);
  run.lowest = to_number(json["lowest"]);
  run.highest = to_number(json["highest"]);
  run.energy_error = to_number(json["energy_error"]);
  run.reached = to_number(json["reached"]);
  run.cut_steps = json["cut_steps"].get<long>();
  run.failure = json["failure"].get<std::string>();
  for (const Json& row : json["series"])
    run.series.push_back(
        {to_number(row[0]), {to_number(row[1]), to_number(row[2]), to_number(row[3])}});
  return run;
}

}  // namespace

Result<FputRun> stored_fput_run(const SectionContext& context, std::string_view method, double step,
                                long every) {
  const Json key = {{"experiment", "fput"},
                    {"version", 2},
                    {"method", std::string(method)},
                    {"step", step},
                    {"every", every}};
  const Result<Json> json = context.store.get(
      fmt::format("known-fput-{}-{:.6g}-{}", method, step, every), key, [&]() -> Result<Json> {
        const Result<FputRun> run = run_fput(method, step, every);
        if (!run) return run.error();
        return to_json(*run);
      });
  if (!json) return json.error();
  return from_json(method, step, *json);
}

}  // namespace tremolo::known
