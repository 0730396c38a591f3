#include "tests/lab/bench.h"

#include <filesystem>
#include <optional>

#include <fmt/format.h>

#include "formats/file/standard_streams.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "tests/lab/bench/precision_report.h"
#include "tests/lab/bench/stability.h"
#include "tests/lab/report/report.h"
#include "tests/lab/speed/speed.h"
#include "tests/lab/work/failure.h"

namespace tremolo::bench {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson to_json(const std::string& page, const std::vector<Criterion>& criteria,
                    const std::vector<std::string>& sentences, const std::optional<Speed>& speed) {
  OrderedJson json;
  json["page"] = page;
  json["recommendations"] = sentences;
  json["criteria"] = tremolo::to_json(criteria);
  if (speed) json["speed"] = to_json(*speed);
  return json;
}

// All measurements; those that --only leaves out are empty.
struct Measured {
  std::optional<Speed> speed;
  std::optional<Precision> precision;
  std::vector<StabilityCell> stability;
};

Measured measure(const Options& options, std::vector<SampleModel> models) {
  const Store store = or_fail(Store::open((std::filesystem::path(options.out) / "work").string()));
  const auto wanted = [&](const char* part) {
    return options.only.empty() || options.only == part;
  };
  Measured measured;
  if (wanted("speed") || options.only == "hand" || options.only == "frames")
    measured.speed = measure_speed(options);
  if (wanted("precision")) measured.precision = measure_precision(options, models, store);
  if (wanted("stability")) {
    std::vector<Subject> subjects;
    for (SampleModel& model : models) subjects.push_back(make_subject(std::move(model)));
    measured.stability = measure_stability(options, subjects, store);
  }
  return measured;
}

std::vector<Criterion> criteria_of(const Measured& measured) {
  std::vector<Criterion> criteria;
  if (measured.precision) criteria = precision_criteria(*measured.precision);
  if (measured.speed)
    for (const Criterion& criterion : speed_criteria(*measured.speed))
      criteria.push_back(criterion);
  return criteria;
}

// The criteria are first on the page, so everything is measured before anything is written. Returns
// the path of the page.
std::string write_report(const Options& options, const Measured& measured,
                         const std::vector<Criterion>& criteria) {
  Report report(options.out,
                options.only == "stability" ? "Where each method survives"
                : options.only == "speed" || options.only == "hand" || options.only == "frames"
                    ? "Speed"
                    : "Run time against error",
                fmt::format("tremolo bench, {} methods", options.integrators.size()));
  if (!criteria.empty()) {
    report.section("What was promised");
    report.paragraph(verdict(criteria));
    report.criteria(criteria);
  }
  if (measured.precision) report_precision(*measured.precision, report);
  if (measured.speed) report_speed(*measured.speed, report);
  if (!measured.stability.empty()) report_stability(measured.stability, options, report);
  return report.write();
}

}  // namespace

int run(Options options) {
  or_fail(settle(options));
  reproduce::keep_models_apart(options.out, options.models_dir, options.models);
  const Measured measured =
      measure(options, reproduce::load_sample_models(options.models_dir, options.models, true));
  const std::vector<Criterion> criteria = criteria_of(measured);
  const std::string page = write_report(options, measured, criteria);
  std::vector<std::string> sentences;
  if (measured.precision) sentences = recommendations(*measured.precision);
  for (const std::string& sentence : sentences) tell("{}\n", sentence);
  print(criteria);
  tell("wrote {}\n", page);
  if (options.json) print_json(to_json(page, criteria, sentences, measured.speed));
  or_fail(flush_standard_output());
  return exit_code(criteria);
}

}  // namespace tremolo::bench
