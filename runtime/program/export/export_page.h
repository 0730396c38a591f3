// A page about a motion: the motion itself, energies of runs, their figures.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/exchange/animation.h"

namespace tremolo {

// What stands on the page beside the motion; empty: nothing. runs: folders of `tremolo run --out`.
// note: a paragraph, `code` between backticks. live: a page of the engine itself, its path as the
// written page shall name it; it is shown first.
struct PageExtras {
  std::vector<std::string> runs;
  std::string note;
  std::string live;

  bool any() const { return !runs.empty() || !note.empty() || !live.empty(); }
};

// position_error: as PageMotion has it (runtime/page/motion.h).
struct PageReport {
  std::uint64_t bytes = 0;
  double position_error = 0.0;
};

// subtitle: what moved and how. Errors: page_motion's; read_energies' for a run; kSystem.
Result<PageReport> write_page_report(const std::string& path, const Animation& animation,
                                     const PageExtras& extras, const std::string& subtitle,
                                     bool z_up);

}  // namespace tremolo
