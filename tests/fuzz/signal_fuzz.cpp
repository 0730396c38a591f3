// The files of `tremolo run --signal`.
#include <cmath>

#include "runtime/io/scenes/csv_rows.h"
#include "tests/fuzz/harness.h"

void tremolo::fuzz::read_input(std::string_view bytes) {
  const Result<SignalTable> table = parse_signal_table(bytes, "input.csv");
  check_error(table);
  if (!table) return;
  if (table->times.empty() || table->times.size() != table->values.size())
    finding("a table without a value for each time");
  for (std::size_t i = 0; i < table->times.size(); ++i) {
    if (!std::isfinite(table->times[i]) || !std::isfinite(table->values[i]))
      finding("a value that is not finite");
    // A jump has two values at one time.
    if (i > 0 && table->times[i] < table->times[i - 1]) finding("times that descend");
  }
}
