// The thesis's tables with our numbers beside its own.
#pragma once

#include <string>
#include <vector>

#include "tests/lab/report/criterion.h"
#include "tests/lab/report/table.h"
#include "tests/lab/reproduce/runs.h"

namespace tremolo::reproduce {

// How many of a method's runs reached the end, of how many: 36 with all models.
struct Survivors {
  std::string method;
  int reached = 0;
  int of = 0;
};
Survivors count_survivors(const Workshop& shop, const Orbits& orbits, const std::string& method,
                          double another = 1.0);
// Of the thesis's IMEXv, on those models that are there: 33 of 36 with all.
Survivors thesis_survivors(const Workshop& shop);
Table survivors_table(const std::vector<Survivors>& list);

// Table 1: low and high modes at 3 ms.
Table modes_table(const Workshop& shop);

// Table 3: seconds reached.
Table reached_table(const Workshop& shop, const Orbits& orbits);

// Loads times 3 and 10: seconds reached; and a row a run with what else was measured.
Table strong_reached_table(const Workshop& shop, const Orbits& orbits);
Table strong_runs_table(const Workshop& shop, const Orbits& orbits);

// Table 5-10 (the one with this load and damping): seconds, iterations, speed-up. A run that did
// not reach 30 s is marked with an asterisk; its seconds are for the steps it made, its speed-up is
// per step.
Table timing_table(const Workshop& shop, SignalKind load, double alpha, const Orbits& orbits,
                   const Timings& timings);

// Seconds of every method, for the same runs.
Table all_timings_table(const Workshop& shop, const Timings& timings, const Orbits& orbits);

// Mean energy (after the load has ended; of the whole run if it lasts) and the largest error of the
// energy balance, of every method.
Table energies_table(const Workshop& shop, const Orbits& orbits);

// The speed-ups Newmark / imexv as a criterion that decides nothing.
Criterion speedups(const Workshop& shop, const Orbits& orbits, const Timings& timings);

}  // namespace tremolo::reproduce
