// A page about a motion: the motion itself, energies of runs, their figures.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/exchange/animation.h"

namespace tremolo {

// Parts of the page besides the motion; all are optional.
struct PageExtras {
  std::vector<std::string> runs;  // folders of `tremolo run --out`
  std::string note;               // a paragraph; `code` between backticks
  std::string live;  // path, as the page names it, of a page of the engine; shown first

  bool any() const { return !runs.empty() || !note.empty() || !live.empty(); }
};

// position_error: as PageMotion has it (runtime/page/motion.h).
struct PageReport {
  std::uint64_t bytes = 0;
  double position_error = 0.0;
};

// subtitle: a description of the motion. Errors: page_motion's; read_energies' for a run; kSystem.
Result<PageReport> write_page_report(const std::string& path, const Animation& animation,
                                     const PageExtras& extras, const std::string& subtitle,
                                     bool z_up);

}  // namespace tremolo
