#include "runtime/viewer/window/window_command.h"

#include "runtime/program/output/tell.h"

namespace tremolo {

int window_command(const ViewerOptions& options, const ViewedScene& viewed) {
  (void)options;
  (void)viewed;
  return report_error(system_error("not yet"));
}

}  // namespace tremolo
