// The sections of the report about the 36 runs: modes, how far they come, how long they take.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "tests/lab/report/page.h"
#include "tests/lab/reproduce/tables.h"

namespace tremolo::reproduce {

// A table on the page, its first `repeating` columns without repeats, and whole as
// directory/NAME.csv. Errors: kSystem.
Status add_table(Page& page, const Table& table, const std::string& caption,
                 const std::string& directory, const std::string& name, std::size_t repeating = 0);

// Table 1.
Status add_modes(Page& page, const Workshop& shop, const std::string& directory);

// Table 3 and the same runs under stronger loads. survivors: of table 3, the thesis first. The
// criteria are added to `criteria`.
Status add_reached(Page& page, const Workshop& shop, const Orbits& orbits,
                   const std::string& directory, std::vector<Survivors>& survivors,
                   std::vector<Criterion>& criteria);

// Tables 5-10 and those of all methods.
Status add_timings(Page& page, const Workshop& shop, const Orbits& orbits, const Timings& timings,
                   const std::string& directory);

// The figures of energy over time and their numbers.
Status add_energies(Page& page, const Workshop& shop, const Orbits& orbits,
                    const std::string& directory);

}  // namespace tremolo::reproduce
