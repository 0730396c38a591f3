#include "formats/file/atomic_file.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <mutex>
#include <unistd.h>
#include <utility>
#include <vector>

#include "common/result.h"
#include "formats/file/output_guard.h"

namespace tremolo {

// A temporary file during writing, readable from a signal handler. Slots are linked once and stay;
// a free slot is used for the next file.
struct PartialSlot {
  std::atomic<int> state{0};  // kFree, kTaken, kNamed
  const char* path =
      nullptr;           // of a named slot; a handler may read it at any time, so none is freed
  std::size_t room = 0;  // bytes at `path`
  PartialSlot* next = nullptr;
};

namespace {

constexpr int kFree = 0, kTaken = 1, kNamed = 2;
std::atomic<PartialSlot*> all_slots{nullptr};
std::mutex free_mutex;
std::vector<PartialSlot*> free_slots;

// Signals that end a process unless they are handled.
constexpr std::array kFatal = {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGXCPU};
constexpr std::array kSeldom = {SIGUSR1, SIGUSR2, SIGALRM, SIGVTALRM, SIGPROF,  SIGIO,
                                SIGPWR,  SIGABRT, SIGTRAP, SIGSYS,    SIGSTKFLT};

// A slot for a file that is about to be created.
PartialSlot* take_slot() {
  const std::lock_guard hold(free_mutex);
  if (!free_slots.empty()) {
    PartialSlot* slot = free_slots.back();
    free_slots.pop_back();
    slot->state = kTaken;
    return slot;
  }
  auto* slot = new PartialSlot;  // NOLINT: it stays for the handler
  slot->state = kTaken;
  slot->next = all_slots;
  all_slots = slot;
  return slot;
}

void forget_partial(PartialSlot* slot) {
  if (slot == nullptr) return;
  const std::lock_guard hold(free_mutex);
  slot->state = kFree;
  free_slots.push_back(slot);
}

void name_slot(PartialSlot* slot, const std::string& path) {
  if (slot->room < path.size() + 1) {
    slot->room = std::max<std::size_t>(2 * path.size(), 128);
    slot->path = new char[slot->room];  // NOLINT: as above
  }
  std::memcpy(const_cast<char*>(slot->path), path.c_str(), path.size() + 1);
  slot->state = kNamed;
}

// Holds the fatal signals back from this thread. Between the creation of a file and the naming of
// its slot the handler must not run here: it would miss the file.
class FatalSignalsHeldBack {
 public:
  FatalSignalsHeldBack() {
    sigset_t fatal;
    sigemptyset(&fatal);
    for (int signal : kFatal) sigaddset(&fatal, signal);
    for (int signal : kSeldom) sigaddset(&fatal, signal);
    for (int signal = SIGRTMIN; signal <= SIGRTMAX; ++signal) sigaddset(&fatal, signal);
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
  for (const PartialSlot* slot = all_slots; slot != nullptr; slot = slot->next) {
    for (; slot->state == kTaken && patience > 0; --patience) ::nanosleep(&kMillisecond, nullptr);
    if (slot->state == kNamed) ::unlink(slot->path);
  }
  // The parent shall see death by this signal. Not by SA_RESETHAND: METIS puts the handler back
  // without its flags.
  ::signal(signal, SIG_DFL);
  ::raise(signal);
}
}

}  // namespace

AtomicFile::AtomicFile(std::string path, std::string temporary, int descriptor, PartialSlot* slot)
    : path_(std::move(path)),
      temporary_(std::move(temporary)),
      descriptor_(descriptor),
      slot_(slot) {}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_(std::move(other.temporary_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      parked_(std::exchange(other.parked_, false)),
      slot_(std::exchange(other.slot_, nullptr)) {}

AtomicFile::~AtomicFile() {
  if (descriptor_ < 0 && !parked_) return;
  if (descriptor_ >= 0) ::close(descriptor_);
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
  if (const Status kept = check_replaceable(path); !kept) return kept.error();
  // Through a symbolic link, so that rename replaces the file and not the link.
  const fs::path target = fs::weakly_canonical(path, ignored);
  const std::string final_path = target.empty() ? path : target.string();
  remove_stale_partials(final_path);
  const FatalSignalsHeldBack held_back;
  PartialSlot* slot = take_slot();
  PartialFile partial = create_partial(final_path);
  if (partial.descriptor < 0) {
    const Error error = os_error(path + ": cannot create a file there");
    forget_partial(slot);
    return error;
  }
  name_slot(slot, partial.path);
  return AtomicFile(final_path, std::move(partial.path), partial.descriptor, slot);
}

void AtomicFile::park() {
  if (descriptor_ < 0) return;
  ::close(std::exchange(descriptor_, -1));
  parked_ = true;
}

Status AtomicFile::reopen() {
  if (!parked_) return Success{};
  descriptor_ = open_partial(temporary_);
  if (descriptor_ < 0) return failure("go on with its temporary file");
  parked_ = false;
  return Success{};
}

Status AtomicFile::write(std::span<const std::byte> bytes) {
  if (Status s = reopen(); !s) return s;
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
  if (Status s = reopen(); !s) return s;
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
  if (Status s = reopen(); !s) return s;
  while (::fsync(descriptor_) != 0)
    if (errno != EINTR) return failure("flush");
  // Everything is on the disk: a signal during close() loses nothing.
  const int closed = ::close(std::exchange(descriptor_, -1)) == 0 || errno == EINTR ? 0 : -1;
  if (closed != 0 || ::rename(temporary_.c_str(), path_.c_str()) != 0) {
    const Error error = failure("finish");
    ::unlink(temporary_.c_str());
    forget_partial(std::exchange(slot_, nullptr));
    return error;
  }
  forget_partial(std::exchange(slot_, nullptr));
  return Success{};
}

Status write_file(const std::string& path, std::string_view text) {
  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file) return file.error();
  if (Status status = file->write(text); !status) return status;
  return file->commit();
}

PartialOfChild::PartialOfChild(const std::string& path) : slot_(take_slot()) {
  name_slot(slot_, path);
}

PartialOfChild::PartialOfChild(PartialOfChild&& other) noexcept
    : slot_(std::exchange(other.slot_, nullptr)) {}

PartialOfChild& PartialOfChild::operator=(PartialOfChild&& other) noexcept {
  std::swap(slot_, other.slot_);
  return *this;
}

PartialOfChild::~PartialOfChild() {
  forget_partial(slot_);
}

void remove_partial_files_on_signals() {
  struct sigaction action = {};
  action.sa_handler = on_fatal_signal;
  const auto handle = [&action](int signal, bool of_others) {
    struct sigaction before = {};
    ::sigaction(signal, nullptr, &before);
    // A signal that was ignored before, as under nohup, stays ignored.
    const bool ours = of_others ? before.sa_handler != SIG_IGN : before.sa_handler == SIG_DFL;
    if (ours) ::sigaction(signal, &action, nullptr);
  };
  for (const int signal : kFatal) handle(signal, true);
  for (const int signal : kSeldom) handle(signal, false);
  for (int signal = SIGRTMIN; signal <= SIGRTMAX; ++signal) handle(signal, false);
  // A file above the limit (ulimit -f) is then an error of write(), with a message and a path.
  ::signal(SIGXFSZ, SIG_IGN);
}

}  // namespace tremolo
