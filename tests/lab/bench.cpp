#include "tests/lab/bench.h"

#include <filesystem>

#include <fmt/format.h>

#include "formats/file/standard_streams.h"
#include "runtime/program/output/tell.h"
#include "tests/lab/bench/precision_report.h"
#include "tests/lab/bench/stability.h"
#include "tests/lab/report/page.h"
#include "tests/lab/speed/speed_report.h"

namespace tremolo::bench {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const Options& options, const std::vector<Criterion>& criteria,
             const std::vector<std::string>& sentences, const std::optional<Speed>& speed) {
  Json json;
  json["page"] = (std::filesystem::path(options.out) / "index.html").string();
  json["recommendations"] = sentences;
  json["criteria"] = tremolo::to_json(criteria);
  if (speed) json["speed"] = to_json(*speed);
  return json;
}

// The criteria come first on the page, so all is measured before anything is written.
Result<int> measure_and_report(const Options& options, std::vector<SampleModel> models) {
  Result<Store> store = Store::open((std::filesystem::path(options.out) / "work").string());
  if (!store) return store.error();
  std::optional<Precision> precision;
  std::vector<StabilityCell> cells;
  const auto wanted = [&](const char* part) {
    return options.only.empty() || options.only == part;
  };
  std::optional<Speed> speed;
  if (wanted("speed")) {
    Result<Speed> measured = measure_speed(options);
    if (!measured) return measured.error();
    speed = std::move(*measured);
  }
  if (wanted("precision")) {
    Result<Precision> measured = measure_precision(options, models, *store);
    if (!measured) return measured.error();
    precision = std::move(*measured);
  }
  if (wanted("stability")) {
    std::vector<Subject> subjects;
    for (SampleModel& model : models) {
      Result<Subject> subject = make_subject(std::move(model));
      if (!subject) return subject.error();
      subjects.push_back(std::move(*subject));
    }
    Result<std::vector<StabilityCell>> measured = measure_stability(options, subjects, *store);
    if (!measured) return measured.error();
    cells = std::move(*measured);
  }

  Page page(options.only == "stability" ? "Where each method survives"
            : options.only == "speed"   ? "Speed"
                                        : "Run time against error",
            fmt::format("tremolo bench, {} methods", options.integrators.size()));
  std::vector<Criterion> criteria;
  std::vector<std::string> sentences;
  if (precision) {
    criteria = precision_criteria(*precision);
    sentences = recommendations(*precision);
  }
  if (speed) {
    const std::vector<Criterion> more = speed_criteria(*speed);
    criteria.insert(criteria.end(), more.begin(), more.end());
  }
  if (!criteria.empty()) {
    page.section("What was promised");
    page.paragraph(verdict(criteria));
    page.criteria(criteria);
  }
  if (precision)
    if (Status s = report_precision(*precision, options.out, page); !s) return s.error();
  if (speed)
    if (Status s = report_speed(*speed, options.out, page); !s) return s.error();
  if (!cells.empty())
    if (Status s = report_stability(cells, options, options.out, page); !s) return s.error();
  const std::string path = (std::filesystem::path(options.out) / "index.html").string();
  if (Status s = page.write(path); !s) return s.error();
  for (const std::string& sentence : sentences) tell("{}\n", sentence);
  print(criteria);
  tell("wrote {}\n", path);
  if (options.json) print_json(to_json(options, criteria, sentences, speed));
  if (Status s = flush_standard_output(); !s) return s.error();
  return exit_code(criteria);
}

}  // namespace

int run(Options options) {
  if (Status status = settle(options); !status) return report_error(status.error());
  if (Status status = reproduce::keep_models_apart(options.out, options.models_dir, options.models);
      !status)
    return report_error(status.error());
  Result<std::vector<SampleModel>> models =
      reproduce::load_sample_models(options.models_dir, options.models);
  if (!models) return report_error(models.error());
  Result<int> code = measure_and_report(options, std::move(*models));
  return code ? *code : report_error(code.error());
}

}  // namespace tremolo::bench
