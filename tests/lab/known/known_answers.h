// Experiments with known answers, as a part of a report: the chain of Fermi, Pasta, Ulam and
// Tsingou, linear resonance, the pendulum, invariants of one step, the trend of the energy.
#pragma once

#include <string>
#include <vector>

#include "tests/lab/report/report.h"
#include "tests/lab/work/store.h"

namespace tremolo::known {

// published: the folder of fput.csv. long_form: the energy is followed for a million steps instead
// of a hundred thousand.
struct Experiments {
  Report& report;
  const Store& store;
  std::string published;
  bool long_form = false;
};

// Adds the five sections below to the report, with known-*.csv. Returns the criteria with their
// measurements; the page shows the same list section by section. Throws a Failure: kSystem if a
// file cannot be written, those of PublishedTable and of the store.
std::vector<Criterion> add_known_answers(const Experiments& experiments);

// One section each, in its own file.
std::vector<Criterion> add_fput_section(const Experiments& experiments);
std::vector<Criterion> add_resonance_section(const Experiments& experiments);
std::vector<Criterion> add_pendulum_section(const Experiments& experiments);
std::vector<Criterion> add_step_section(const Experiments& experiments);
std::vector<Criterion> add_trend_section(const Experiments& experiments);

}  // namespace tremolo::known
