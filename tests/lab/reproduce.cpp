#include "tests/lab/reproduce.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include <fmt/format.h>

#include "formats/file/checksum.h"
#include "formats/file/standard_streams.h"
#include "runtime/program/output/progress.h"
#include "runtime/program/output/tell.h"
#include "tests/lab/damping/damping_matrix.h"
#include "tests/lab/known/known_answers.h"
#include "tests/lab/report/page.h"
#include "tests/lab/reproduce/experiment3.h"
#include "tests/lab/reproduce/figures.h"
#include "tests/lab/reproduce/run_sections.h"

namespace tremolo {
namespace reproduce {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  std::vector<Criterion> criteria;
  std::vector<Survivors> survivors;  // table 3, the thesis first
};

void note(const std::string& text) {
  tell("tremolo: {}\n", text);
}

Result<Workshop> open_workshop(const ReproduceOptions& options) {
  if (Status status = keep_models_apart(options.out, options.models_directory, options.models);
      !status)
    return status.error();
  Result<std::vector<SampleModel>> models =
      load_sample_models(options.models_directory, options.models);
  if (!models) return models.error();
  const std::string directory = (fs::path(options.out) / "store").string();
  Result<Store> store = Store::open(directory);
  if (!store) return store.error();
  Result<std::string> program = program_checksum();
  if (!program) return program.error();
  return Workshop{std::move(*store),   directory,
                  std::move(*program), thread_count(static_cast<unsigned>(options.threads)),
                  std::move(*models),  options.long_form};
}

template <class T>
void append(std::vector<T>& list, const std::vector<T>& more) {
  list.insert(list.end(), more.begin(), more.end());
}

std::vector<RunName> all_runs(const Workshop& shop) {
  std::vector<RunName> runs;
  const auto add = [&](const std::string& method, double another) {
    const std::vector<RunName> some = the_runs(shop.models, method, another);
    runs.insert(runs.end(), some.begin(), some.end());
  };
  for (const std::string method : kMethods) add(method, 1.0);
  for (const double another : kStrongLoads)
    for (const std::string method : kStrongMethods) add(method, another);
  return runs;
}

// Damped motion against a stiff solver.
Status add_damping(Page& page, const Workshop& shop, const std::string& directory,
                   std::vector<Criterion>& criteria) {
  using namespace damping;
  std::vector<Entry> all;
  for (const SampleModel& sample : shop.models) {
    if (std::ranges::find(kModels, sample.name) == kModels.end()) continue;
    note(fmt::format("damping of the {} against Radau IIA", sample.name));
    const Result<std::vector<Entry>> entries = damping_matrix(sample);
    if (!entries) return entries.error();
    append(all, *entries);
  }
  if (all.empty()) return Success{};
  page.section("Damping, from none to overdamped");
  page.paragraph(
      "Relative error in the mass norm over 2 s of the model's own square load at 3 ms, against "
      "Radau IIA of order 5 at 0.5 ms. Empty: the run broke off. `imexv-thesis` is of first order "
      "in its damping, the explicit methods do not stand these steps.");
  const auto held = std::ranges::count_if(all, &Entry::holds);
  criteria.push_back({"damping: no method's error above its undamped one by more than 0.2 %",
                      fmt::format("{} of {}", all.size(), all.size()), std::to_string(held),
                      held == static_cast<std::ptrdiff_t>(all.size())});
  return add_table(page, to_table(all), "Error of each method for each damping.", directory,
                   "damping", 1);
}

// What the task states and `tremolo bench` measures, so that the list is whole.
std::vector<Criterion> measured_by_bench() {
  const auto line = [](const char* what, const char* bound) {
    return Criterion{what, bound, "see `tremolo bench`", false, false, true};
  };
  return {line("ep4 at 3 ms, square load, up to 15 %: trajectory error over 6 s", "<= 1 %"),
          line("the same, error of newmark and of imexv over ep4's", ">= 10"),
          line("time to 0.1 %: newmark and imexv over ep4, median", ">= 4"),
          line("time to 0.1 %: verlet and verlet4 over ep4, and where each wins", "shown")};
}

Status build_page(Page& page, const Workshop& shop, const std::string& directory,
                  Outcome& outcome) {
  if (Status status = add_modes(page, shop, directory); !status) return status;

  Result<Orbits> orbits = watch_all(shop, all_runs(shop),
                                    "the 36 runs of every method, and under loads times 3 and 10");
  if (!orbits) return orbits.error();
  if (Status status =
          add_reached(page, shop, *orbits, directory, outcome.survivors, outcome.criteria);
      !status)
    return status;
  Result<Timings> timings = time_all(shop, *orbits);
  if (!timings) return timings.error();
  if (Status status = add_timings(page, shop, *orbits, *timings, directory); !status) return status;
  if (Status status = add_energies(page, shop, *orbits, directory); !status) return status;

  Result<std::vector<Criterion>> third = add_experiment3(page, shop, directory);
  if (!third) return third.error();
  append(outcome.criteria, *third);
  append(outcome.criteria, measured_by_bench());

  page.section("Experiment 4: the step");
  if (Status status = add_step_figures(page, shop, directory); !status) return status;

  if (Status status = add_damping(page, shop, directory, outcome.criteria); !status) return status;

  // A folder for each build: these experiments do not know the program's checksum.
  const Result<Store> store = Store::open((fs::path(shop.directory) / shop.program).string());
  if (!store) return store.error();
  Result<std::vector<Criterion>> known = add_known_answers(page, *store, directory, shop.long_form);
  if (!known) return known.error();
  // What the task states comes first: of the known answers that is the chain's.
  const auto further = std::ranges::stable_partition(
      *known, [](const Criterion& criterion) { return criterion.what.starts_with("FPUT"); });
  append(outcome.criteria, {known->begin(), further.begin()});
  outcome.criteria.push_back(speedups(shop, *orbits, *timings));
  const std::vector<Criterion> stated = outcome.criteria;
  const std::vector<Criterion> checks(further.begin(), further.end());
  append(outcome.criteria, checks);

  page.section("What was promised, and what was measured");
  page.paragraph(verdict(outcome.criteria));
  page.criteria(stated);
  page.heading("Further checks");
  page.paragraph("Of the known answers: " + verdict(checks));
  page.criteria(checks);
  page.last_section_first();
  return Success{};
}

nlohmann::ordered_json to_json(const Outcome& outcome, const std::string& report) {
  nlohmann::ordered_json json;
  json["report"] = report;
  for (const Survivors& one : outcome.survivors)
    json["table_3"][one.method] = {{"reached", one.reached}, {"of", one.of}};
  json["criteria"] = tremolo::to_json(outcome.criteria);
  return json;
}

}  // namespace
}  // namespace reproduce

int reproduce_command(const ReproduceOptions& options) {
  using namespace reproduce;
  Result<Workshop> shop = open_workshop(options);
  if (!shop) return report_error(shop.error());
  Page page("The thesis reproduced",
            "Huang 2011, Preserving High-Frequency Vibration of Deformable Objects Using the "
            "Implicit-Explicit Variational Integrator: its tables, figures and experiments on "
            "Tremolo's sample models.");
  Outcome outcome;
  if (Status status = build_page(page, *shop, options.out, outcome); !status)
    return report_error(status.error());
  const std::string report = (fs::path(options.out) / "index.html").string();
  if (Status status = page.write(report); !status) return report_error(status.error());
  print(outcome.criteria);
  note(verdict(outcome.criteria));
  note("wrote " + report);
  if (options.json) print_json(to_json(outcome, report));
  return flushed(exit_code(outcome.criteria));
}

}  // namespace tremolo
