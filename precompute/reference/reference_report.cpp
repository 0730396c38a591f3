#include "precompute/reference/reference_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "common/text.h"

namespace tremolo {

Json probe_json(const std::vector<VertexId>& probes, const Vector& field) {
  Json list = Json::array();
  for (VertexId v : probes) {
    const Eigen::Vector3d u = field.segment<3>(3 * Eigen::Index{v});
    list.push_back({{"vertex", v}, {"displacement", {u.x(), u.y(), u.z()}}});
  }
  return list;
}

Json largest_json(const Vector& field) {
  const Eigen::Map<const Eigen::Matrix3Xd> vertices(field.data(), 3, field.size() / 3);
  Eigen::Index vertex = 0;
  const double largest = vertices.colwise().norm().maxCoeff(&vertex);
  return {{"vertex", vertex}, {"displacement", largest}};
}

void report_statics(const StaticSolution& solution, double seconds, Json& json) {
  json["integrator"] = "static";
  json["load_steps"] = solution.load_steps;
  json["iterations"] = solution.iterations;
  json["linear_iterations"] = solution.linear_iterations;
  json["factorisations"] = solution.factorisations;
  json["residual"] = solution.residual;
  json["potential"] = solution.energy;
  json["work"] = solution.work;
  json["seconds"] = seconds;
  std::fprintf(
      stderr, "  static: %d load steps, %d iterations, residual %.1e, energy %.6g J, %.2f s\n",
      solution.load_steps, solution.iterations, solution.residual, solution.energy, seconds);
}

void print_progress(const Motion& motion, std::int64_t steps, double seconds) {
  const auto made = static_cast<double>(std::max<std::int64_t>(1, motion.steps));
  std::fprintf(stderr,
               "  t = %-10.6g step %lld of %lld, %.2f Newton and %.1f linear iterations a step, "
               "%.1f s\n",
               motion.time, static_cast<long long>(motion.steps), static_cast<long long>(steps),
               static_cast<double>(motion.iterations) / made,
               static_cast<double>(motion.linear_iterations) / made, seconds);
}

void report_motion(const Motion& motion, const DriftMeter& drift, double seconds, Json& json) {
  const double steps = static_cast<double>(std::max<std::int64_t>(1, motion.steps));
  json["steps"] = motion.steps;
  json["reached"] = motion.time;
  json["iterations_per_step"] = static_cast<double>(motion.iterations) / steps;
  json["linear_iterations_per_step"] = static_cast<double>(motion.linear_iterations) / steps;
  json["factorisations"] = motion.factorisations;
  json["halved_steps"] = motion.halved_steps;
  json["largest_residual"] = motion.worst_residual;
  json["seconds"] = seconds;
  json["seconds_per_step"] = seconds / steps;
  json["energy_reference"] = drift.reference();
  json["energy_final"] = motion.total();
  json["energy_drift_max"] = drift.worst();
  json["work"] = motion.work;
  json["dissipated"] = motion.dissipated;
  std::fprintf(stderr, "  energy %.6g J at the end, largest drift %.2e, %.3g s a step\n",
               motion.total(), drift.worst(), seconds / steps);
}

Json comparison_json(const std::string& file, const ReducedBody& reduced,
                     const ComparisonSummary& summary, double unseen, double seconds) {
  return {{"file", file},
          {"modes", reduced.model.size()},
          {"load_unseen", unseen},
          {"error_of_largest", summary.error_of_largest},
          {"error_at_once", summary.error_at_once},
          {"projection_of_largest", summary.projection_of_largest},
          {"projection_at_once", summary.projection_at_once},
          {"tip_error_of_largest", summary.tip_error_of_largest},
          {"mac_least", summary.mac_least},
          {"energy_difference", summary.energy_difference},
          {"shown_of_largest", summary.shown_of_largest},
          {"shown_tip_of_largest", summary.shown_tip_of_largest},
          {"seconds", seconds}};
}

void print_comparison(const std::string& file, const ReducedBody& reduced,
                      const ComparisonSummary& summary, double unseen) {
  const auto number = [](const char* format, double value) {
    return std::isnan(value) ? std::string("not measured") : text(format, value);
  };
  std::fprintf(stderr,
               "  %s, %d coordinates: displacement off by %s of the largest (no coordinates could "
               "do better than %s), the watched vertices by %s, MAC at least %s\n"
               "  of the load's linear compliance f^T K^-1 f the basis leaves out %s\n"
               "  with the response to the load (--response-at load) %s, the watched vertices %s\n",
               file.c_str(), static_cast<int>(reduced.model.size()),
               number("%.2e", summary.error_of_largest).c_str(),
               number("%.2e", summary.projection_of_largest).c_str(),
               number("%.2e", summary.tip_error_of_largest).c_str(),
               number("%.6f", summary.mac_least).c_str(), number("%.2e", unseen).c_str(),
               number("%.2e", summary.shown_of_largest).c_str(),
               number("%.2e", summary.shown_tip_of_largest).c_str());
}

namespace {

// Columns before those of the probes.
constexpr std::array kReducedColumns = {"reduced_total", "norm", "difference",    "projection",
                                        "mac",           "tip",  "tip_difference"};

void add_probes(const Vector& field, ReferenceTable& table) {
  for (VertexId v : table.probes)
    for (int axis = 0; axis < 3; ++axis)
      table.text += text(",%.8g", field[3 * Eigen::Index{v} + axis]);
}

void name_probes(char letter, const std::string& suffix, ReferenceTable& table) {
  for (VertexId v : table.probes)
    for (const char axis : {'x', 'y', 'z'}) table.text += text(",%c%d%c", letter, v, axis) + suffix;
}

}  // namespace

ReferenceTable begin_table(std::vector<VertexId> probes, std::size_t compared) {
  ReferenceTable table{std::move(probes), "t,kinetic,potential,total,work,dissipated"};
  name_probes('u', "", table);
  for (std::size_t i = 1; i <= compared; ++i) {
    const std::string suffix = i == 1 ? "" : "_" + std::to_string(i);
    for (const char* name : kReducedColumns) table.text += std::string(",") + name + suffix;
    name_probes('r', suffix, table);
  }
  table.text += '\n';
  return table;
}

void add_row(const Motion& motion, const Vector& field,
             const std::vector<std::optional<ReducedRow>>& reduced, ReferenceTable& table) {
  table.text += text("%.9g,%.10g,%.10g,%.12g,%.10g,%.10g", motion.time, motion.kinetic,
                     motion.potential, motion.total(), motion.work, motion.dissipated);
  add_probes(field, table);
  for (const std::optional<ReducedRow>& given : reduced) {
    if (!given) {
      for (std::size_t i = 0; i < kReducedColumns.size() + 3 * table.probes.size(); ++i)
        table.text += ",nan";
      continue;
    }
    const ReducedRow& row = *given;
    const Moment& moment = row.moment;
    table.text +=
        text(",%.12g,%.8g,%.8g,%.8g,%.8g,%.8g,%.8g", row.total, moment.norm, moment.difference,
             moment.projection, moment.mac, moment.tip, moment.tip_difference);
    add_probes(row.field, table);
  }
  table.text += '\n';
}

}  // namespace tremolo
