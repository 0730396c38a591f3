// Files that are written whole or not at all: under a temporary name next to the target, which is
// then renamed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "common/result.h"

namespace tremolo {

struct PartialSlot;

// One file being written. Until commit() succeeds the target path is untouched; the destructor
// removes an uncommitted temporary file. Errors are ErrorKind::kSystem and name the path. A process
// that is killed leaves its temporary file; the next that writes the same target removes it.
class AtomicFile {
 public:
  // Refuses a target that exists and is not a regular file, and one that is an input which is
  // guarded (formats/file/output_guard.h).
  static Result<AtomicFile> create(const std::string& path);

  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile();

  Status write(std::span<const std::byte> bytes);
  Status write(std::string_view text);
  // Writes at an offset in bytes; the file grows if need be, and the position of write() stays.
  Status write_at(std::uint64_t offset, std::span<const std::byte> bytes);
  // Closes the temporary file until the next call, for owners of more files than a process may have
  // open. Meanwhile it is not locked: another process that writes the same target removes it.
  void park();
  // Flushes to the disk and renames.
  Status commit();

 private:
  AtomicFile(std::string path, std::string temporary, int descriptor, PartialSlot* slot);
  Error failure(const char* what) const;
  // Opens the temporary file if it is parked.
  Status reopen();

  std::string path_;
  std::string temporary_;
  int descriptor_;
  bool parked_ = false;
  PartialSlot* slot_;  // where a signal handler finds the temporary file's name
};

// Writes `text` as the whole file.
Status write_file(const std::string& path, std::string_view text);

// A temporary file that a child process writes, and that a fatal signal removes.
class PartialOfChild {
 public:
  PartialOfChild() = default;
  explicit PartialOfChild(const std::string& path);
  PartialOfChild(PartialOfChild&& other) noexcept;
  PartialOfChild& operator=(PartialOfChild&& other) noexcept;
  ~PartialOfChild();

 private:
  PartialSlot* slot_ = nullptr;
};

// Installs handlers that remove the temporary files of all AtomicFiles before a signal ends the
// process: for SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGXCPU, and for others (SIGUSR1,
// SIGALRM, SIGABRT, real-time signals ...) that have no handler; not for SIGKILL. Ignores SIGXFSZ,
// so that a limit on file sizes is an error like a full disk. For programs; a library must not call
// it.
void remove_partial_files_on_signals();

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
