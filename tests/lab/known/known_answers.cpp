#include "tests/lab/known/known_answers.h"

#include <array>
#include <cstdio>
#include <filesystem>

#include <fmt/format.h>

#include "runtime/program/output/tell.h"
#include "tests/lab/known/sections.h"

namespace tremolo {
namespace known {

Status add_table(const SectionContext& context, const Table& table, const std::string& file,
                 std::string_view caption) {
  context.page.table(table, caption);
  return write_csv(table, (std::filesystem::path(context.directory) / file).string());
}

nlohmann::json to_json(const std::optional<double>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json();
}

std::optional<double> to_optional(const nlohmann::json& value) {
  return value.is_number() ? std::optional<double>(value.get<double>()) : std::nullopt;
}

Criterion at_most(std::string what, double measured, double bound, const std::string& who) {
  Criterion criterion;
  criterion.what = std::move(what);
  criterion.bound = fmt::format("<= {:.3g}", bound);
  criterion.measured = fmt::format("{:.3g}", measured) + (who.empty() ? "" : " (" + who + ")");
  criterion.met = measured <= bound;  // false for not-a-number
  return criterion;
}

}  // namespace known

Result<std::vector<Criterion>> add_known_answers(Page& page, const Store& store,
                                                 const std::string& out_directory, bool long_form) {
  const known::SectionContext context{page, store, out_directory, long_form};
  struct Part {
    const char* name;
    known::Criteria (*add)(const known::SectionContext&);
  };
  constexpr std::array<Part, 5> kParts{{{"chain", known::add_fput_section},
                                        {"resonance", known::add_resonance_section},
                                        {"pendulum", known::add_pendulum_section},
                                        {"one step", known::add_step_section},
                                        {"trend", known::add_trend_section}}};
  std::vector<Criterion> all;
  for (std::size_t i = 0; i < kParts.size(); ++i) {
    tell("tremolo: known answers, {}: {} of {}\n", kParts[i].name, i + 1, kParts.size());
    const known::Criteria criteria = kParts[i].add(context);
    if (!criteria) return criteria.error();
    page.criteria(*criteria);
    all.insert(all.end(), criteria->begin(), criteria->end());
  }
  return all;
}

}  // namespace tremolo
