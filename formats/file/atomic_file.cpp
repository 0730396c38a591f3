#include "formats/file/atomic_file.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <iterator>
#include <unistd.h>
#include <utility>

#include "formats/file/os_error.h"
#include "formats/file/partial_file.h"

namespace tremolo {
namespace {

// The temporary files under way, readable from a signal handler: one for each thread that writes.
struct Slot {
  std::atomic<int> state{0};  // kFree, kTaken, kNamed
  char path[4096] = {};
};
constexpr int kFree = 0, kTaken = 1, kNamed = 2;
Slot slots[16];

constexpr std::array kFatal = {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGXCPU};

// A slot for a file that is about to be created; -1 if there is none left: a signal then leaves the
// file behind.
int take_slot() {
  for (int i = 0; i < std::ssize(slots); ++i) {
    int expected = kFree;
    if (slots[i].state.compare_exchange_strong(expected, kTaken)) return i;
  }
  return -1;
}

void forget_partial(int slot) {
  if (slot >= 0) slots[slot].state = kFree;
}

// False if the slot has no room for the path.
bool name_slot(int slot, const std::string& path) {
  if (slot < 0 || path.size() >= sizeof(Slot::path)) return false;
  std::memcpy(slots[slot].path, path.c_str(), path.size() + 1);
  slots[slot].state = kNamed;
  return true;
}

// Holds the fatal signals back from this thread. Between the creation of a file and the naming of
// its slot the handler must not run here: it would miss the file.
class FatalSignalsHeldBack {
 public:
  FatalSignalsHeldBack() {
    sigset_t fatal;
    sigemptyset(&fatal);
    for (int signal : kFatal) sigaddset(&fatal, signal);
    pthread_sigmask(SIG_BLOCK, &fatal, &before_);
  }
  ~FatalSignalsHeldBack() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  FatalSignalsHeldBack(const FatalSignalsHeldBack&) = delete;
  FatalSignalsHeldBack& operator=(const FatalSignalsHeldBack&) = delete;

 private:
  sigset_t before_ = {};
};

extern "C" {
static void on_fatal_signal(int signal) {
  // A slot that is taken belongs to another thread, which is about to create its file: up to a
  // second for that.
  constexpr timespec kMillisecond = {0, 1'000'000};
  int patience = 1000;
  for (const Slot& slot : slots) {
    for (; slot.state == kTaken && patience > 0; --patience) ::nanosleep(&kMillisecond, nullptr);
    if (slot.state == kNamed) ::unlink(slot.path);
  }
  // The parent shall see death by this signal. Not by SA_RESETHAND: METIS puts the handler back
  // without its flags.
  ::signal(signal, SIG_DFL);
  ::raise(signal);
}
}

}  // namespace

AtomicFile::AtomicFile(std::string path, std::string temporary, int descriptor, int slot)
    : path_(std::move(path)),
      temporary_(std::move(temporary)),
      descriptor_(descriptor),
      slot_(slot) {}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_(std::move(other.temporary_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      slot_(std::exchange(other.slot_, -1)) {}

AtomicFile::~AtomicFile() {
  if (descriptor_ < 0) return;
  ::close(descriptor_);
  ::unlink(temporary_.c_str());
  forget_partial(slot_);
}

Error AtomicFile::failure(const char* what) const {
  return os_error(path_ + ": cannot " + what);
}

Result<AtomicFile> AtomicFile::create(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (fs::exists(status) && !fs::is_regular_file(status))
    return system_error(path + ": cannot write: it exists and is not a regular file");
  // Through a symbolic link, so that rename replaces the file and not the link.
  const fs::path target = fs::weakly_canonical(path, ignored);
  const std::string final_path = target.empty() ? path : target.string();
  remove_stale_partials(final_path);
  const FatalSignalsHeldBack held_back;
  int slot = take_slot();
  PartialFile partial = create_partial(final_path);
  if (partial.descriptor < 0) {
    const Error error = os_error(path + ": cannot create a file there");
    forget_partial(slot);
    return error;
  }
  if (!name_slot(slot, partial.path)) forget_partial(std::exchange(slot, -1));
  return AtomicFile(final_path, std::move(partial.path), partial.descriptor, slot);
}

Status AtomicFile::write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return failure("write");
    }
    bytes = bytes.subspan(written);
  }
  return Success{};
}

Status AtomicFile::write(std::string_view text) {
  return write(std::as_bytes(std::span(text.data(), text.size())));
}

Status AtomicFile::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written =
        ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0) {
      if (errno == EINTR) continue;
      return failure("write");
    }
    offset += written;
    bytes = bytes.subspan(written);
  }
  return Success{};
}

Status AtomicFile::commit() {
  while (::fsync(descriptor_) != 0)
    if (errno != EINTR) return failure("flush");
  // Everything is on the disk: a signal during close() takes nothing away.
  const int closed = ::close(std::exchange(descriptor_, -1)) == 0 || errno == EINTR ? 0 : -1;
  if (closed != 0 || ::rename(temporary_.c_str(), path_.c_str()) != 0) {
    const Error error = failure("finish");
    ::unlink(temporary_.c_str());
    forget_partial(std::exchange(slot_, -1));
    return error;
  }
  forget_partial(std::exchange(slot_, -1));
  return Success{};
}

Status write_file(const std::string& path, std::string_view text) {
  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file) return file.error();
  if (Status status = file->write(text); !status) return status;
  return file->commit();
}

void remove_partial_files_on_signals() {
  struct sigaction action = {};
  action.sa_handler = on_fatal_signal;
  for (int signal : kFatal) {
    struct sigaction before = {};
    ::sigaction(signal, nullptr, &before);
    // What is ignored, as under nohup, stays ignored.
    if (before.sa_handler != SIG_IGN) ::sigaction(signal, &action, nullptr);
  }
  // A file above the limit (ulimit -f) is then an error of write(), with a message and a path.
  ::signal(SIGXFSZ, SIG_IGN);
}

}  // namespace tremolo
