// The five sections of known_answers.h, each in its own file, and what they share.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/lab/known/fput.h"
#include "tests/lab/known/known_answers.h"
#include "tests/lab/report/table.h"

namespace tremolo::known {

struct SectionContext {
  Page& page;
  const Store& store;
  std::string directory;
  bool long_form = false;
};

using Criteria = Result<std::vector<Criterion>>;

Criteria add_fput_section(const SectionContext& context);
Criteria add_resonance_section(const SectionContext& context);
Criteria add_pendulum_section(const SectionContext& context);
Criteria add_step_section(const SectionContext& context);
Criteria add_trend_section(const SectionContext& context);

// run_fput, unless the store has it.
Result<FputRun> stored_fput_run(const SectionContext& context, std::string_view method, double step,
                                long every);

// A table on the page and as `file` in the directory.
Status add_table(const SectionContext& context, const Table& table, const std::string& file,
                 std::string_view caption);

nlohmann::json to_json(const std::optional<double>& value);      // null if empty
std::optional<double> to_optional(const nlohmann::json& value);  // empty if null

// A criterion that compares one number with a bound from above.
Criterion at_most(std::string what, double measured, double bound, const std::string& who = {});

}  // namespace tremolo::known
