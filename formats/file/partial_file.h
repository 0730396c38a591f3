// Temporary files next to a target: their names, their owners, and the removal of stale ones.
#pragma once

#include <string>

namespace tremolo {

// A temporary file. descriptor: open for writing; -1: none, with the reason in errno.
struct PartialFile {
  std::string path;
  int descriptor = -1;
};

// Creates TARGET.partial-PID, empty; with -2, -3, ... appended if threads write the same target. It
// is locked while the descriptor is open, which shows other processes that it has an owner.
PartialFile create_partial(const std::string& target);

// Opens a closed temporary file at its end and locks it. Returns the descriptor; -1: none, with the
// reason in errno.
int open_partial(const std::string& path);

// Removes the temporary files of `target` that no process has locked: their owners were killed,
// crashed or lost power. A folder is scanned once per process. Removes nothing if the file system
// has no locks.
void remove_stale_partials(const std::string& target);

}  // namespace tremolo
