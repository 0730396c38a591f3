#include <cmath>

#include <fmt/format.h>

#include "runtime/apps/tremolo/output/tell.h"
#include "tests/lab/speed/speed.h"

namespace tremolo::bench {
namespace {

using OrderedJson = nlohmann::ordered_json;

// The sections in the order of the report.
constexpr SpeedSection (*kSections[])(const Options&, const MachineProbe&) = {
    measure_kernel_speed, measure_step_speed, measure_world_speed,  measure_surface_speed,
    measure_frames_speed, measure_hand_speed, measure_savings_speed};

std::string machine_text(const MachineProbe& probe) {
  return fmt::format(
      "One core of this machine, measured in the same run: {:.0f} GFLOP/s in double, {:.0f} in "
      "float ({}); reads {:.0f} GB/s from the level-2 cache, {:.0f} from level 3, {:.0f} from "
      "memory.",
      probe.gflops, probe.gflops_f32, probe.vectors, probe.l2_bandwidth, probe.l3_bandwidth,
      probe.memory_bandwidth);
}

// Seconds of one operation, not-a-number where the row is about bytes.
double seconds_of(const SpeedRow& row) {
  if (row.unit == "us") return 1e-6 * row.value;
  if (row.unit == "s") return row.value;
  return SpeedRow::kNone;
}

Table to_table(const std::vector<SpeedRow>& rows) {
  Table table{{"what", "value", "unit", "textbook", "ratio", "bytes touched", "GB/s", "GFLOP/s",
               "limit", "limited by", "over limit", "note"},
              {}};
  for (const SpeedRow& row : rows) {
    const double seconds = seconds_of(row);
    table.rows.push_back({row.what, cell(row.value), row.unit, cell(row.baseline),
                          cell(row.ratio(), 3), cell(row.bytes, 6),
                          cell(1e-9 * row.bytes / seconds, 3),
                          cell(1e-9 * row.operations / seconds, 3), cell(row.limit), row.limited_by,
                          cell(row.value / row.limit, 3), row.note});
  }
  return table;
}

OrderedJson number(double value) {
  return std::isfinite(value) ? OrderedJson(value) : OrderedJson(nullptr);
}

OrderedJson to_json(const SpeedRow& row) {
  return {{"what", row.what},
          {"value", number(row.value)},
          {"unit", row.unit},
          {"baseline", number(row.baseline)},
          {"ratio", number(row.ratio())},
          {"bytes", number(row.bytes)},
          {"operations", number(row.operations)},
          {"limit", number(row.limit)},
          {"limited_by", row.limited_by},
          {"note", row.note}};
}

}  // namespace

Speed measure_speed(const Options& options) {
  Speed speed;
  tell("probing the machine\n");
  speed.machine = probe_machine();
  for (const auto measure : kSections) {
    if (options.only == "hand" && measure != measure_hand_speed) continue;
    if (options.only == "frames" && measure != measure_frames_speed) continue;
    speed.sections.push_back(measure(options, speed.machine));
    tell("{}\n", speed.sections.back().title);
    for (const SpeedRow& row : speed.sections.back().rows)
      tell("  {:<58} {:>10.4g} {:<5} ratio {:>8.3g}  {}\n", row.what, row.value, row.unit,
           row.ratio(), row.note);
  }
  return speed;
}

void report_speed(const Speed& speed, Report& report) {
  report.section("Speed");
  report.paragraph(machine_text(speed.machine));
  Table all = to_table({});
  all.columns.insert(all.columns.begin(), "section");
  for (const SpeedSection& section : speed.sections) {
    const Table table = to_table(section.rows);
    report.heading(section.title);
    report.paragraph(section.text);
    report.table(table);
    for (std::vector<std::string> row : table.rows) {
      row.insert(row.begin(), section.title);
      all.rows.push_back(std::move(row));
    }
  }
  report.file(all, "speed.csv");
}

std::vector<Criterion> speed_criteria(const Speed& speed) {
  std::vector<Criterion> criteria;
  for (const SpeedSection& section : speed.sections)
    criteria.insert(criteria.end(), section.criteria.begin(), section.criteria.end());
  return criteria;
}

OrderedJson to_json(const Speed& speed) {
  const MachineProbe& machine = speed.machine;
  OrderedJson json;
  json["machine"] = {{"vectors", machine.vectors},       {"gflops_f64", machine.gflops},
                     {"gflops_f32", machine.gflops_f32}, {"l2_gb_s", machine.l2_bandwidth},
                     {"l3_gb_s", machine.l3_bandwidth},  {"memory_gb_s", machine.memory_bandwidth}};
  json["sections"] = OrderedJson::array();
  for (const SpeedSection& section : speed.sections) {
    OrderedJson rows = OrderedJson::array();
    for (const SpeedRow& row : section.rows) rows.push_back(to_json(row));
    json["sections"].push_back({{"title", section.title}, {"rows", rows}});
  }
  return json;
}

}  // namespace tremolo::bench
