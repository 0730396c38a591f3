#include "tests/lab/known/known_answers.h"

#include <array>

#include "runtime/apps/tremolo/output/tell.h"

namespace tremolo::known {

std::vector<Criterion> add_known_answers(const Experiments& experiments) {
  struct Part {
    const char* name;
    std::vector<Criterion> (*add)(const Experiments&);
  };
  constexpr std::array<Part, 5> kParts{{{"chain", add_fput_section},
                                        {"resonance", add_resonance_section},
                                        {"pendulum", add_pendulum_section},
                                        {"one step", add_step_section},
                                        {"trend", add_trend_section}}};
  std::vector<Criterion> all;
  for (std::size_t i = 0; i < kParts.size(); ++i) {
    tell("tremolo: known answers, {}: {} of {}\n", kParts[i].name, i + 1, kParts.size());
    const std::vector<Criterion> criteria = kParts[i].add(experiments);
    experiments.report.criteria(criteria);
    all.insert(all.end(), criteria.begin(), criteria.end());
  }
  return all;
}

}  // namespace tremolo::known
