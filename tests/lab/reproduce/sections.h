// The sections of the report of `tremolo reproduce`, and their tables. Sections throw a Failure:
// those of the runs and the store, kSystem for a file that cannot be written.
#pragma once

#include <string>
#include <vector>

#include "tests/lab/report/report.h"
#include "tests/lab/reproduce/runs.h"

namespace tremolo::reproduce {

// Number of a method's runs that reached the end, and of all: 36 with all models.
struct Survivors {
  std::string method;
  int reached = 0;
  int of = 0;
};
Survivors count_survivors(const Session& session, const Orbits& orbits, const std::string& method,
                          double load_multiple = 1.0);
// Survivors of the thesis's IMEXv, on those models that are there: 33 of 36 with all.
Survivors thesis_survivors(const Session& session);
Table survivors_table(const std::vector<Survivors>& list);

// Table 1, low and high modes at 3 ms.
Table modes_table(const Session& session);

// Table 3: seconds reached.
Table reached_table(const Session& session, const Orbits& orbits);

// Loads times 3 and 10: the seconds reached, and a row for each run with the other measurements.
Table strong_reached_table(const Session& session, const Orbits& orbits);
Table strong_runs_table(const Session& session, const Orbits& orbits);

// Table 5-10 (the one with this load and damping): seconds, iterations, speed-up. A run that did
// not reach 30 s is marked with an asterisk; its seconds are for the steps it made, its speed-up is
// per step.
Table timing_table(const Session& session, SignalKind load, double alpha, const Orbits& orbits,
                   const Timings& timings);

// Seconds of every method, for the same runs.
Table all_timings_table(const Session& session, const Timings& timings, const Orbits& orbits);

// Mean energy (after the load has ended; of the whole run if it lasts) and the largest error of the
// energy balance, of every method.
Table energies_table(const Session& session, const Orbits& orbits);

// The speed-ups Newmark / imexv as a criterion that decides nothing.
Criterion speedups(const Session& session, const Orbits& orbits, const Timings& timings);

// Table 1.
void add_modes(Report& report, const Session& session);

// Table 3 and the same runs under stronger loads. Returns the survivors of table 3, the thesis
// first; the criteria are added to `criteria`.
std::vector<Survivors> add_reached(Report& report, const Session& session, const Orbits& orbits,
                                   std::vector<Criterion>& criteria);

// Tables 5-10 and those of all methods.
void add_timings(Report& report, const Session& session, const Orbits& orbits,
                 const Timings& timings);

// Figures 13-16 (horse) and 22-35, as far as their models are there, with figure-NN.csv (thinned as
// drawn), and the same runs in numbers.
void add_energies(Report& report, const Session& session, const Orbits& orbits);
void add_energy_figures(Report& report, const Session& session, const Orbits& orbits);

// Experiment 3, does the energy stay over 10 000 s? Table, figure 17 and the criteria for ep4, on
// the horse; nothing without it.
std::vector<Criterion> add_experiment3(Report& report, const Session& session);

// Experiment 4, figures 18 and 19: the beam at 10, 5 and 1 ms. Runs them. Nothing without the beam.
void add_step_figures(Report& report, const Session& session);

}  // namespace tremolo::reproduce
