// tremolo-lab: the cost and the accuracy of the methods. `tremolo bench` and `tremolo reproduce`
// start it.
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "formats/file/command_words.h"
#include "formats/file/output_guard.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "tests/lab/bench.h"
#include "tests/lab/report/report.h"
#include "tests/lab/reproduce.h"
#include "tests/lab/work/failure.h"

namespace tremolo {
namespace {

void add_bench_flags(CLI::App& bench, bench::Options& o, bool& quick) {
  bench
      .add_option(
          "--models", o.models,
          "a,b,...: of the six, NAME.tremolo in the folder, or paths of basis files; default: all "
          "six")
      ->delimiter(',');
  bench.add_option("--models-dir", o.models_dir, "where NAME.tremolo are")->capture_default_str();
  bench.add_option("--integrators", o.integrators, "a,b,...; default: all")->delimiter(',');
  bench.add_option("--loads", o.loads, "square, impulse, sine")->delimiter(',');
  bench
      .add_option("--amplitudes", o.amplitudes,
                  "largest displacement of the loaded vertex over the solid's size")
      ->delimiter(',');
  bench.add_option("--steps-ms", o.steps_ms, "steps, ms; each divides 6 ms")->delimiter(',');
  bench.add_option("--duration", o.duration, "simulated time, s")->capture_default_str();
  bench.add_flag("--quick", quick,
                 "beam and horse, square load, two amplitudes, fewer steps: minutes, not hours");
  bench.add_option("--only", o.only,
                   "precision, stability, speed, or hand or frames (parts of speed)");
  bench.add_option("--out", o.out, "directory for the page and the CSVs")->capture_default_str();
  bench.add_option("--threads", o.threads, "for all but the timing; 0: one a core")
      ->check(CLI::Range(0, 1024));
  bench.add_flag("--json", o.json, "print one JSON object on stdout");
}

// Parts that --quick leaves out, unless a flag requests them.
void shorten(const CLI::App& bench, bench::Options& o) {
  const auto given = [&](const char* flag) { return bench.count(flag) > 0; };
  if (!given("--models")) o.models = {"beam", "horse"};
  if (!given("--loads")) o.loads = {"square"};
  if (!given("--amplitudes")) o.amplitudes = {0.05, 0.15};
  if (!given("--steps-ms")) o.steps_ms = {6, 3, 1.5, 0.75, 0.3};
  o.stability_scales = {1, 10};
  o.stability_steps_ms = {10, 3};
}

void add_reproduce_flags(CLI::App& reproduce, ReproduceOptions& o) {
  reproduce.add_option("--models", o.models, "of the six, comma-separated (default: all)")
      ->delimiter(',');
  reproduce.add_option("--models-dir", o.models_directory, "where their basis files are")
      ->capture_default_str();
  reproduce.add_option("--published", o.published, "where the thesis's numbers are, as CSV files")
      ->capture_default_str();
  reproduce.add_option("--out", o.out, "directory for index.html and CSVs")->capture_default_str();
  reproduce
      .add_option(
          "--only", o.only,
          "cloth: the study of its integrators; tets: bodies of tetrahedra; each a report of "
          "its own")
      ->check(CLI::IsMember({"cloth", "tets"}));
  reproduce.add_flag("--long", o.long_form, "experiment 3 over 10 000 s instead of 200 s");
  reproduce.add_option("--threads", o.threads, "for the curves (default: all cores)")
      ->check(CLI::Range(1, 1024));
  reproduce.add_flag("--json", o.json, "print the criteria as one JSON object on stdout");
}

int run_laboratory(int count, char** words) {
  CLI::App app{"What the methods of Tremolo cost, and how far they are from the truth."};
  bench::Options bench_options;
  bool quick = false;
  ReproduceOptions reproduce_options;
  app.name("tremolo-lab");
  app.set_version_flag("--version", std::string("tremolo-lab ") + TREMOLO_VERSION);
  app.require_subcommand(1);
  CLI::App& bench =
      *app.add_subcommand("bench", "run time against error and stability of all methods");
  add_bench_flags(bench, bench_options, quick);
  CLI::App& reproduce =
      *app.add_subcommand("reproduce", "the thesis's tables and figures, ours beside them");
  add_reproduce_flags(reproduce, reproduce_options);
  std::string report, shown;
  CLI::App& page =
      *app.add_subcommand("page", "a report.json as a page, which needs no other file");
  page.add_option("report", report, "the report")->required();
  page.add_option("-o,--output", shown, "the page, .html")->required();
  if (const std::optional<int> code = read_words(app, count, words)) return *code;
  if (page) {
    or_fail(keep_apart({shown}, {{report, "the report"}}));
    or_fail(check_writable({shown}));
    or_fail(page_of_file(report, shown));
    return 0;
  }
  if (reproduce) return reproduce_command(reproduce_options);
  if (quick) shorten(bench, bench_options);
  return bench::run(bench_options);
}

}  // namespace
}  // namespace tremolo

int main(int count, char** words) {
  return tremolo::run_guarded([&] {
    try {
      return tremolo::run_laboratory(count, words);
    } catch (const tremolo::Failure& failure) {
      return tremolo::report_error(failure.error);
    }
  });
}
