// --target-error: growth of k, and messages.
#include "precompute/target_error.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/text.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kMostLinearModes = 24;
constexpr int kMostGrowths = 2;

const TargetRow* best(const std::vector<TargetRow>& rows) {
  const auto found =
      std::min_element(rows.begin(), rows.end(),
                       [](const TargetRow& a, const TargetRow& b) { return a.error < b.error; });
  return found == rows.end() ? nullptr : &*found;
}

[[noreturn]] void throw_missed_target(const TargetFindings& findings) {
  const TargetRow* row = best(findings.rows);
  std::string reached = "no candidate has an equilibrium";
  std::string help;
  if (row != nullptr && std::isfinite(row->error)) {
    reached = text("%.3g was reached with %d linear modes and %d coordinates", row->error,
                   findings.linear_modes, row->modes);
    help = row->projection > findings.asked
               ? text(
                     " (no coordinates in this basis could do better than %.3g). More linear "
                     "modes (--linear-modes %d) or a smaller load may do",
                     row->projection, 2 * findings.linear_modes)
               : ". The basis holds the shape but is too stiff on the way there: more linear "
                 "modes or a smaller load may do";
  }
  throw Failure({ErrorKind::kCriterion, text("--target-error %g was missed: ", findings.asked) +
                                            reached + help + "; no file is written"});
}

}  // namespace

std::string describe(const TargetFindings& findings) {
  const std::string vectors =
      findings.load_vectors > 0
          ? text(", %d of them the load's own response", findings.load_vectors)
          : "";
  if (const TargetRow& row = findings.chosen; findings.kept())
    return text("%d coordinates", row.modes) + vectors +
           text(": static displacement off by %.2e (at most %g), the loaded vertices by %.2e",
                row.error, findings.asked, row.tip);
  return text("not reached with %d linear modes", findings.linear_modes) + vectors;
}

std::string table_text(const TargetFindings& findings) {
  std::string table = "    r   error      projection tip        unseen\n";
  for (const TargetRow& row : findings.rows)
    table += text("  %3d%c  %.3e  %.3e  %.3e  %.3e\n", row.modes,
                  row.modes == findings.chosen.modes ? '*' : ' ', row.error, row.projection,
                  row.tip, row.unseen);
  return table;
}

nlohmann::ordered_json target_json(const std::optional<TargetFindings>& findings) {
  if (!findings) return nullptr;
  const auto numbers = [](const TargetRow& row) {
    return Json{{"modes", row.modes},
                {"displacement", std::isfinite(row.error) ? Json(row.error) : Json(nullptr)},
                {"projection", row.projection},
                {"tip", row.tip},
                {"unseen", row.unseen}};
  };
  Json measured = Json::array();
  for (const TargetRow& row : findings->rows) measured.push_back(numbers(row));
  return {{"asked", findings->asked},
          {"reached", numbers(findings->chosen)},
          {"load", findings->load},
          {"linear_modes", findings->linear_modes},
          {"load_vectors", findings->load_vectors},
          {"measured", measured}};
}

PrecomputeResult precompute_to_target(const PrecomputeRequest& request, const LoadedProblem& loaded,
                                      StageLog& log) {
  const LoadRequest& load = *request.solid.load;
  TargetSearch search;
  search.asked = *request.basis.target_error;
  search.load_text =
      load.at.text + text(", %g,%g,%g N", load.force.x(), load.force.y(), load.force.z());
  PrecomputeRequest attempt = request;
  for (int growths = 0;; ++growths) {
    PrecomputeResult result = run_precompute(attempt, loaded, log, &search);
    const TargetFindings& findings = *result.findings.target;
    std::fputs(table_text(findings).c_str(), stderr);
    if (findings.kept()) return result;
    const int now = findings.linear_modes;
    const int next = std::min({kMostLinearModes, loaded.free_dofs(), now + std::max(2, now / 2)});
    if (growths == kMostGrowths || next <= now) throw_missed_target(findings);
    log.note(text("%d linear modes are not enough: %d", now, next));
    attempt.basis.linear_modes = next;
  }
}

}  // namespace tremolo
