#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "runtime/apps/tremolo/output/chart.h"
#include "runtime/apps/tremolo/response/curve_report.h"
#include "runtime/apps/tremolo/response/orbit_film.h"
#include "runtime/io/page/document.h"

namespace tremolo {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kInks[] = {"#0060a8", "#d95f02", "#1b9e77", "#7b3fa0", "#d01c6f", "#8c5a1e"};

// A value of a point, for an axis.
using Axis = double (*)(const CurvePoint&, double load_scale, const CurveContext&);

double frequency_of(const CurvePoint& point, double, const CurveContext&) {
  return point.omega / (2.0 * std::numbers::pi);
}
double amplitude_of(const CurvePoint& point, double, const CurveContext&) {
  return point.amplitude;
}
double load_of(const CurvePoint& point, double, const CurveContext&) {
  return point.load;
}
double phase_of(const CurvePoint& point, double load_scale, const CurveContext& context) {
  return values_of(point, load_scale, context).phase;
}
double energy_of(const CurvePoint& point, double load_scale, const CurveContext& context) {
  return values_of(point, load_scale, context).energy;
}

// The stable or the unstable parts of a curve, with gaps between them. A part begins at the last
// point of the part before it.
Curve parts_of(const CurveResult& result, bool stable, Axis x, Axis y, const CurveContext& context,
               const std::vector<int>* loops) {
  Curve line{.label = result.label, .style = stable ? CurveStyle::kLines : CurveStyle::kDashes};
  const std::vector<CurvePoint>& points = result.curve.points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool starts = i + 1 < points.size() && points[i + 1].stable == stable;
    const bool shown = points[i].stable == stable || starts;
    const double gap = std::numeric_limits<double>::quiet_NaN();
    line.x.push_back(shown ? x(points[i], result.load_scale, context) : gap);
    line.y.push_back(shown ? y(points[i], result.load_scale, context) : gap);
    if (loops != nullptr) line.loops.push_back((*loops)[i]);
  }
  return line;
}

bool has_part(const CurveResult& result, bool stable) {
  for (const CurvePoint& point : result.curve.points)
    if (point.stable == stable) return true;
  return false;
}

Chart chart_of(const std::string& x_label, Axis x, const std::string& y_label, Axis y,
               const std::vector<CurveResult>& results, const CurveContext& context,
               const OrbitFilm& film) {
  Chart chart;
  chart.title = y_label;
  chart.x_label = x_label;
  chart.y_label = y_label;
  std::size_t number = 0;
  std::map<std::string, Curve> marks;
  for (const CurveResult& result : results) {
    const std::string ink = kInks[number % std::size(kInks)];
    const bool plays = !film.film.is_null();
    const std::vector<int>* loops = plays ? &film.loop_of_point[number] : nullptr;
    for (const bool stable : {true, false}) {
      if (!has_part(result, stable)) continue;
      chart.curves.push_back(parts_of(result, stable, x, y, context, loops));
      chart.curves.back().colour = ink;
    }
    for (std::size_t i = 0; i < result.curve.bifurcations.size(); ++i) {
      const Bifurcation& found = result.curve.bifurcations[i];
      Curve& mark = marks[name_of(found.kind)];
      if (plays) mark.loops.push_back(film.loop_of_bifurcation[number][i]);
      mark.x.push_back(x(found.point, result.load_scale, context));
      mark.y.push_back(y(found.point, result.load_scale, context));
    }
    ++number;
  }
  for (auto& [label, mark] : marks) {
    mark.label = label;
    mark.style = CurveStyle::kPoints;
    mark.colour = label == "fold" ? "#1c2126" : "#b3261e";
    chart.curves.push_back(std::move(mark));
  }
  return chart;
}

Json figure_of(const std::vector<Chart>& charts, const std::string& caption) {
  Json list = Json::array();
  for (const Chart& chart : charts) list.push_back(to_json(chart));
  return {{"kind", "charts"},
          {"charts",
           {{"caption", caption},
            {"columns", 1},
            {"height", 380},
            {"linked", false},
            {"charts", std::move(list)}}}};
}

// Folds and other bifurcations, a row each.
Json table_of(const std::vector<CurveResult>& results, const CurveContext& context) {
  Json rows = Json::array();
  for (const CurveResult& result : results)
    for (const Bifurcation& found : result.curve.bifurcations)
      rows.push_back({result.label, name_of(found.kind),
                      fmt::format("{:.8g}", frequency_of(found.point, result.load_scale, context)),
                      fmt::format("{:.6g}", found.point.amplitude),
                      fmt::format("{}", found.point.harmonics())});
  return {{"kind", "table"},
          {"table",
           {{"columns", {"curve", "kind", "frequency (Hz)", "amplitude (m)", "harmonics"}},
            {"rows", std::move(rows)},
            {"caption", "Where the curve turns or its stability changes"}}}};
}

}  // namespace

Result<std::string> curve_page(const std::string& title, const std::string& subtitle,
                               const std::vector<CurveResult>& results,
                               const CurveContext& context) {
  const Result<OrbitFilm> film = orbit_film(results, context);
  if (!film) return film.error();
  const std::string hertz = "frequency (Hz)", metres = "largest displacement (m)";
  std::vector<Chart> charts = {
      chart_of(hertz, frequency_of, metres, amplitude_of, results, context, *film)};
  if (context.forced && !context.ridge)
    charts.push_back(chart_of(hertz, frequency_of, "lag behind the load (degrees)", phase_of,
                              results, context, *film));
  if (context.ridge)
    charts.push_back(
        chart_of("load scale", load_of, metres, amplitude_of, results, context, *film));
  if (!context.forced)
    charts.push_back(
        chart_of("energy (J)", energy_of, hertz, frequency_of, results, context, *film));
  if (!context.forced) charts.back().log_x = true;
  Json parts = Json::array();
  const bool plays = !film->film.is_null();
  if (plays) parts.push_back({{"kind", "film"}, {"film", film->film}});
  parts.push_back(figure_of(
      charts, std::string("Solid: stable. Dashed: unstable. The marks are folds and other "
                          "bifurcations.") +
                  (plays ? " A click on a point plays its motion above, a period in 1.5 s." : "")));
  bool any = false;
  for (const CurveResult& result : results) {
    any = any || !result.curve.bifurcations.empty();
    if (!result.reason.empty())
      parts.push_back({{"kind", "paragraph"}, {"paragraph", result.label + ": " + result.reason}});
    for (const std::string& warning : result.warnings)
      parts.push_back({{"kind", "paragraph"}, {"paragraph", result.label + ": " + warning}});
  }
  if (any) parts.push_back(table_of(results, context));
  const Json section = {{"title", ""}, {"parts", std::move(parts)}};
  const Json report = {
      {"title", title}, {"subtitle", subtitle}, {"sections", Json::array({section})}};
  return page_document(report.dump(-1, ' ', false, Json::error_handler_t::replace));
}

}  // namespace tremolo
