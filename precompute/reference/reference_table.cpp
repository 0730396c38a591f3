#include "precompute/reference/reference_table.h"

#include <array>

#include "common/format_text.h"

namespace tremolo {
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
