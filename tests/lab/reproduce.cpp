#include "tests/lab/reproduce.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "formats/file/input_file.h"
#include "formats/file/standard_streams.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "tests/lab/cloth/cloth_sections.h"
#include "tests/lab/damping/damping_matrix.h"
#include "tests/lab/known/known_answers.h"
#include "tests/lab/report/report.h"
#include "tests/lab/reproduce/sections.h"
#include "tests/lab/samples/thesis.h"
#include "tests/lab/tets/tets_section.h"
#include "tests/lab/work/failure.h"
#include "tests/lab/work/progress.h"

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

Session open_session(const ReproduceOptions& options) {
  keep_models_apart(options.out, options.models_directory, options.models, options.published);
  std::vector<SampleModel> models = load_sample_models(options.models_directory, options.models);
  thesis::Thesis thesis = thesis::read_thesis(options.published);
  const std::string directory = (fs::path(options.out) / "store").string();
  return {or_fail(Store::open(directory)),
          directory,
          or_fail(program_checksum()),
          thread_count(static_cast<unsigned>(options.threads)),
          std::move(models),
          std::move(thesis),
          options.long_form};
}

template <class T>
void append(std::vector<T>& list, const std::vector<T>& more) {
  list.insert(list.end(), more.begin(), more.end());
}

std::vector<RunName> all_runs(const Session& session) {
  std::vector<RunName> runs;
  for (const std::string method : kMethods) append(runs, thesis_runs(session.models, method));
  for (const double load_multiple : kStrongLoads)
    for (const std::string method : kStrongMethods)
      append(runs, thesis_runs(session.models, method, load_multiple));
  return runs;
}

// Damped motion against a stiff solver.
void add_damping(Report& report, const Session& session, std::vector<Criterion>& criteria) {
  using namespace damping;
  std::vector<Entry> all;
  for (const SampleModel& sample : session.models) {
    if (std::ranges::find(kModels, sample.name) == kModels.end()) continue;
    note(fmt::format("damping of the {} against Radau IIA", sample.name));
    append(all, damping_matrix(sample));
  }
  if (all.empty()) return;
  report.section("Damping, from none to overdamped");
  report.paragraph(
      "Relative error in the mass norm over 2 s of the model's own square load at 3 ms, against "
      "Radau IIA of order 5 at 0.5 ms. Empty: the run broke off. `imexv-thesis` is of first order "
      "in its damping, the explicit methods do not stand these steps.");
  const auto held = std::ranges::count_if(all, &Entry::holds);
  criteria.push_back({"damping: no method's error above its undamped one by more than 0.2 %",
                      fmt::format("{} of {}", all.size(), all.size()), std::to_string(held),
                      held == static_cast<std::ptrdiff_t>(all.size())});
  report.table(to_table(all), "Error of each method for each damping.", "damping.csv", 1);
}

// Stated criteria that `tremolo bench` measures, so that the list is complete.
std::vector<Criterion> measured_by_bench() {
  const auto line = [](const char* what, const char* bound) {
    return Criterion{what, bound, "see `tremolo bench`", false, false, true};
  };
  return {line("ep4 at 3 ms, square load, up to 15 %: trajectory error over 6 s", "<= 1 %"),
          line("the same, error of newmark and of imexv over ep4's", ">= 10"),
          line("time to 0.1 %: newmark and imexv over ep4, median", ">= 4"),
          line("time to 0.1 %: verlet and verlet4 over ep4, and where each wins", "shown")};
}

// All sections but the first.
void add_experiments(Report& report, const ReproduceOptions& options, const Session& session,
                     Outcome& outcome, std::vector<Criterion>& checks) {
  add_modes(report, session);
  const Orbits orbits = run_all(session, all_runs(session),
                                "the 36 runs of every method, and under loads times 3 and 10");
  outcome.survivors = add_reached(report, session, orbits, outcome.criteria);
  const Timings timings = time_all(session, orbits);
  add_timings(report, session, orbits, timings);
  add_energies(report, session, orbits);
  append(outcome.criteria, add_experiment3(report, session));
  append(outcome.criteria, measured_by_bench());
  add_step_figures(report, session);
  add_damping(report, session, outcome.criteria);
  // A folder for each build: these experiments do not know the program's checksum.
  const Store store =
      or_fail(Store::open((fs::path(session.directory) / session.program).string()));
  std::vector<Criterion> known =
      known::add_known_answers({report, store, options.published, session.long_form});
  // Of the known answers the chain's is first, because it is a stated criterion.
  const auto further = std::ranges::stable_partition(
      known, [](const Criterion& criterion) { return criterion.what.starts_with("FPUT"); });
  append(outcome.criteria, {known.begin(), further.begin()});
  outcome.criteria.push_back(speedups(session, orbits, timings));
  checks.assign(further.begin(), further.end());
}

// The last section, which is put first. checks: criteria beyond those that the task states.
void add_verdict(Report& report, Outcome& outcome, const std::vector<Criterion>& checks) {
  const std::vector<Criterion> stated = outcome.criteria;
  append(outcome.criteria, checks);
  report.section("What was promised, and what was measured");
  report.paragraph(verdict(outcome.criteria));
  report.criteria(stated);
  report.heading("Further checks");
  report.paragraph("Of the known answers: " + verdict(checks));
  report.criteria(checks);
  report.last_section_first();
}

nlohmann::ordered_json to_json(const Outcome& outcome, const std::string& report) {
  nlohmann::ordered_json json;
  json["report"] = report;
  for (const Survivors& one : outcome.survivors)
    json["table_3"][one.method] = {{"reached", one.reached}, {"of", one.of}};
  json["criteria"] = tremolo::to_json(outcome.criteria);
  return json;
}

// --only tets. The times and the store are of this build.
int reproduce_tets(const ReproduceOptions& options) {
  const std::string directory =
      (fs::path(options.out) / "store" / or_fail(program_checksum())).string();
  const Store store = or_fail(Store::open(directory));
  Report report(options.out, "Bodies of tetrahedra",
                "Corotated linear and quadratic tetrahedra: accuracy, time, memory.");
  const std::vector<Criterion> criteria = tets::add_tets_section(report, store);
  const std::string page = report.write();
  print(criteria);
  note(verdict(criteria));
  note("wrote " + page);
  if (options.json) print_json(to_json({criteria, {}}, page));
  or_fail(flush_standard_output());
  return exit_code(criteria);
}

// The study of cloth needs no model and nothing of the thesis.
int reproduce_cloth(const ReproduceOptions& options) {
  std::error_code error;
  fs::create_directories(options.out, error);
  if (error) throw Failure(system_error(options.out + ": cannot create: " + error.message()));
  Report report(options.out, "Cloth", "Every integrator of Tremolo's cloth on one sheet.");
  const std::vector<Criterion> criteria = cloth_study::add_cloth_sections(
      report, thread_count(static_cast<unsigned>(std::max(options.threads, 0))));
  const std::string page = report.write();
  print(criteria);
  note(verdict(criteria));
  note("wrote " + page);
  if (options.json)
    print_json(nlohmann::ordered_json{{"report", page}, {"criteria", tremolo::to_json(criteria)}});
  or_fail(flush_standard_output());
  return exit_code(criteria);
}

}  // namespace
}  // namespace reproduce

int reproduce_command(const ReproduceOptions& options) {
  using namespace reproduce;
  if (options.only == "tets") return reproduce_tets(options);
  if (options.only == "cloth") return reproduce_cloth(options);
  const Session session = open_session(options);
  Report report(options.out, "The thesis reproduced",
                "Huang 2011, Preserving High-Frequency Vibration of Deformable Objects Using the "
                "Implicit-Explicit Variational Integrator: its tables, figures and experiments on "
                "Tremolo's sample models.");
  Outcome outcome;
  std::vector<Criterion> checks;
  add_experiments(report, options, session, outcome, checks);
  add_verdict(report, outcome, checks);
  const std::string page = report.write();
  print(outcome.criteria);
  note(verdict(outcome.criteria));
  note("wrote " + page);
  if (options.json) print_json(to_json(outcome, page));
  or_fail(flush_standard_output());
  return exit_code(outcome.criteria);
}

}  // namespace tremolo
