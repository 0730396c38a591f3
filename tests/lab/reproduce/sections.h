// The sections of the report that `tremolo reproduce` writes. All throw a Failure: those of the
// runs and the store, kSystem for what cannot be written.
#pragma once

#include <vector>

#include "tests/lab/report/report.h"
#include "tests/lab/reproduce/tables.h"

namespace tremolo::reproduce {

// Table 1.
void add_modes(Report& report, const Workshop& shop);

// Table 3 and the same runs under stronger loads. Returns the survivors of table 3, the thesis
// first; the criteria are added to `criteria`.
std::vector<Survivors> add_reached(Report& report, const Workshop& shop, const Orbits& orbits,
                                   std::vector<Criterion>& criteria);

// Tables 5-10 and those of all methods.
void add_timings(Report& report, const Workshop& shop, const Orbits& orbits,
                 const Timings& timings);

// Figures 13-16 (horse) and 22-35, as far as their models are there, with figure-NN.csv (thinned as
// drawn), and the same runs in numbers.
void add_energies(Report& report, const Workshop& shop, const Orbits& orbits);
void add_energy_figures(Report& report, const Workshop& shop, const Orbits& orbits);

// Experiment 3, does the energy stay over 10 000 s? Table, figure 17 and the criteria for ep4, on
// the horse; nothing without it.
std::vector<Criterion> add_experiment3(Report& report, const Workshop& shop);

// Experiment 4, figures 18 and 19: the beam at 10, 5 and 1 ms. Runs them. Nothing without the beam.
void add_step_figures(Report& report, const Workshop& shop);

}  // namespace tremolo::reproduce
