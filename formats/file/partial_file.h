// Temporary files beside a target: their names, whose they are, and those that nobody has any more.
#pragma once

#include <string>

namespace tremolo {

// descriptor: open for writing; -1: errno tells why there is none.
struct PartialFile {
  std::string path;
  int descriptor = -1;
};

// Creates TARGET.partial-PID, empty; -2, -3, ... behind it where threads write the same target. It
// is locked while the descriptor is open, so that other processes see that it has an owner.
PartialFile create_partial(const std::string& target);

// Removes temporary files of `target` whose owner is gone: killed, crashed or without power. They
// are those that nobody has locked. What stands in a folder is looked at once a process. Where the
// file system has no locks nothing is removed.
void remove_stale_partials(const std::string& target);

}  // namespace tremolo
