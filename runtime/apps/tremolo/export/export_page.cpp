#include <filesystem>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "formats/file/atomic_file.h"
#include "formats/file/input_file.h"
#include "runtime/apps/tremolo/export/export.h"
#include "runtime/apps/tremolo/output/plot.h"
#include "runtime/apps/tremolo/output/warnings.h"
#include "runtime/io/page/document.h"

namespace tremolo {
namespace {

using Json = nlohmann::ordered_json;

struct Figure {
  const char* key;
  const char* text;
};

constexpr const char* kPace = "real_time_factor";

// Figures of a run's report.json.
constexpr Figure kFigures[] = {
    {"integrator", "method"},
    {"steps", "steps"},
    {"reached", "reached, s"},
    {"microseconds_per_step", "time a step, µs"},
    {kPace, "pace"},
    {"iterations_per_step", "iterations a step"},
    {"energy_reference", "energy after the push, J"},
    {"energy_final", "energy at the end, J"},
    {"energy_drift_max", "largest relative drift of the energy"},
    {"low_modes", "coordinates stepped explicitly"},
    {"high_modes", "coordinates stepped implicitly"},
};

std::string figure_text(const Json& report, const char* key) {
  const auto found = report.find(key);
  if (found == report.end() || found->is_null()) return "–";
  if (std::string_view(key) == kPace && found->is_number()) return pace_text(found->get<double>());
  if (found->is_number_float()) return fmt::format("{:.4g}", found->get<double>());
  return found->is_string() ? found->get<std::string>() : found->dump();
}

// A row per figure, a column per run; a missing figure is a dash.
Json figures_table(const std::vector<PlotSource>& runs) {
  std::vector<std::string> columns = {""};
  std::vector<Json> reports;
  for (const PlotSource& run : runs) {
    const auto path = std::filesystem::path(run.csv).parent_path() / "report.json";
    const Result<std::string> text = read_whole_file(path.string());
    const Json report = text ? Json::parse(*text, nullptr, false) : Json();
    reports.push_back(report.is_object() ? report : Json::object());
    columns.push_back(run.label);
  }
  Json rows = Json::array();
  for (const Figure& figure : kFigures) {
    Json row = Json::array({figure.text});
    for (const Json& report : reports) row.push_back(figure_text(report, figure.key));
    rows.push_back(std::move(row));
  }
  return {{"caption", ""}, {"columns", columns}, {"rows", std::move(rows)}};
}

Json part(const char* kind, Json value) {
  return {{"kind", kind}, {kind, std::move(value)}};
}

Json section(const char* title, Json parts) {
  return {{"title", title}, {"parts", std::move(parts)}};
}

std::string page_title(const Animation& animation) {
  std::vector<std::string> names;
  for (const AnimatedBody& body : animation.bodies)
    if (!body.collider) names.push_back(body.name);
  if (names.size() > 3) return fmt::format("{} bodies", names.size());
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

Result<PageReport> write_page_report(const std::string& path, const Animation& animation,
                                     const PageExtras& extras, const std::string& subtitle,
                                     bool z_up) {
  const Result<PageMotion> motion = page_motion(animation, z_up);
  if (!motion) return motion.error();
  Json film = Json::parse(motion->json);
  if (!extras.live.empty()) film["live"] = extras.live;
  Json first = Json::array({part("film", std::move(film))});
  if (!extras.note.empty()) first.push_back(part("paragraph", extras.note));
  Json sections = Json::array({section("", std::move(first))});
  if (!extras.runs.empty()) {
    const std::vector<PlotSource> runs = plot_sources(extras.runs);
    Result<Json> charts = energy_charts(runs, true);
    if (!charts) return charts.error();
    sections.push_back(section("Energy", Json::array({part("charts", std::move(*charts))})));
    sections.push_back(section("Figures", Json::array({part("table", figures_table(runs))})));
  }
  const Json report = {
      {"title", page_title(animation)}, {"subtitle", subtitle}, {"sections", std::move(sections)}};
  const std::string page =
      page_document(report.dump(-1, ' ', false, Json::error_handler_t::replace));
  if (Status s = write_file(path, page); !s) return s.error();
  return PageReport{page.size(), motion->position_error};
}

}  // namespace tremolo
