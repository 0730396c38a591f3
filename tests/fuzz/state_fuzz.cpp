// The CSV from which `tremolo run --start FILE.csv@T` continues.
#include "runtime/apps/tremolo/start/start_state.h"
#include "tests/fuzz/harness.h"

void tremolo::fuzz::read_input(std::string_view bytes) {
  constexpr Eigen::Index kModes = 2;
  for (const std::optional<double> time : {std::optional<double>{}, std::optional<double>{0.01}}) {
    const Result<State> state = parse_state_row(bytes, "input.csv", time, kModes);
    check_error(state);
    if (!state) continue;
    if (state->q.size() != kModes || state->p.size() != kModes)
      finding("a state of another number of coordinates");
    if (!state->q.allFinite() || !state->p.allFinite()) finding("a state that is not finite");
  }
}
