#include "formats/file/limited_child.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <exception>
#include <fcntl.h>
#include <new>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/result.h"
#include "common/text.h"

namespace tremolo {
namespace {

// Exit codes of a child without an answer.
constexpr int kOutOfMemory = 70;
constexpr int kThrew = 71;
constexpr int kNoPipe = 72;

constexpr double kMegabyte = 1e6;

Error system_failure(const char* what) {
  return os_error(std::string("cannot ") + what);
}

// Nothing of the parent's handlers and masks: a blocked SIGTERM would make a child that only
// SIGKILL ends.
void default_signals() {
  struct sigaction action = {};
  action.sa_handler = SIG_DFL;
  for (int signal = 1; signal < NSIG; ++signal) ::sigaction(signal, &action, nullptr);
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
}

// The standard streams lead nowhere, the answer is descriptor 3, and there are no others.
bool keep_only(int answer) {
  const int nowhere = ::open("/dev/null", O_RDWR);
  if (nowhere < 0) return false;
  // Both may be among 0 to 3 already, where one would overwrite the other.
  const int answer_above = ::fcntl(answer, F_DUPFD, 4);
  const int nowhere_above = ::fcntl(nowhere, F_DUPFD, 4);
  if (answer_above < 0 || nowhere_above < 0) return false;
  for (int stream = 0; stream < 3; ++stream)
    if (::dup2(nowhere_above, stream) < 0) return false;
  if (::dup2(answer_above, 3) < 0) return false;
  ::close_range(4, ~0U, 0);
  return true;
}

#if !defined(TREMOLO_SANITIZED)
std::uint64_t address_space_in_use() {
  std::array<char, 64> text = {};
  const int file = ::open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
  if (file < 0) return 0;
  const ssize_t count = ::read(file, text.data(), text.size() - 1);
  ::close(file);
  unsigned long long pages = 0;
  if (count <= 0 || std::sscanf(text.data(), "%llu", &pages) != 1) return 0;
  return pages * ::sysconf(_SC_PAGESIZE);
}
#endif

void set_limit(__rlimit_resource resource, rlim_t value) {
  const struct rlimit limit = {value, value};
  ::setrlimit(resource, &limit);
}

void set_limits(const ChildLimits& limits) {
  set_limit(RLIMIT_CORE, 0);
  set_limit(RLIMIT_FSIZE, 0);
  // The clock ends the child; this is for the case that the parent cannot.
  set_limit(RLIMIT_CPU, static_cast<rlim_t>(std::min(std::ceil(limits.seconds), 1e9)) + 2);
#if !defined(TREMOLO_SANITIZED)  // whose shadow memory alone is 16 TB
  const std::uint64_t used = address_space_in_use();
  if (limits.memory == 0 || used == 0) return;
  struct rlimit space = {};
  ::getrlimit(RLIMIT_AS, &space);
  space.rlim_cur = std::min<rlim_t>(space.rlim_max, used + limits.memory);
  ::setrlimit(RLIMIT_AS, &space);
#endif
}

bool write_all(int file, const std::byte* bytes, std::size_t count) {
  while (count > 0) {
    const ssize_t written = ::write(file, bytes, count);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes += written;
    count -= written;
  }
  return true;
}

[[noreturn]] void be_the_child(const ChildWork& work, const ChildLimits& limits, int pipe,
                               pid_t parent) {
  default_signals();
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(kNoPipe);
  if (!keep_only(pipe)) ::_exit(kNoPipe);
  set_limits(limits);
  std::set_new_handler([] { ::_exit(kOutOfMemory); });
  std::set_terminate([] { ::_exit(kThrew); });
  try {
    const std::vector<std::byte> answer = work();
    ::_exit(write_all(3, answer.data(), answer.size()) ? 0 : kNoPipe);
  } catch (...) {
    ::_exit(kThrew);
  }
}

class Deadline {
 public:
  explicit Deadline(double seconds) : end_(Clock::now() + duration(std::min(seconds, 1e9))) {}
  // For poll(); 0 when it has passed.
  int milliseconds_left() const {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end_ - Clock::now()).count();
    return static_cast<int>(std::clamp<long long>(left, 0, 1'000'000));
  }

 private:
  using Clock = std::chrono::steady_clock;
  static Clock::duration duration(double seconds) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  }
  Clock::time_point end_;
};

enum class Listening { kEnd, kTooLate, kTooMuch, kFailed };

// Reads all bytes from the pipe until the child closes it.
Listening listen(int pipe, const ChildLimits& limits, std::vector<std::byte>& answer) {
  const Deadline deadline(limits.seconds);
  std::vector<std::byte> piece(std::size_t{1} << 18);
  for (;;) {
    struct pollfd event = {pipe, POLLIN, 0};
    const int ready = ::poll(&event, 1, deadline.milliseconds_left());
    if (ready < 0 && errno != EINTR) return Listening::kFailed;
    if (ready <= 0) {
      if (deadline.milliseconds_left() == 0) return Listening::kTooLate;
      continue;
    }
    const ssize_t count = ::read(pipe, piece.data(), piece.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return Listening::kFailed;
    if (count == 0) return Listening::kEnd;
    if (std::cmp_greater(count, limits.answer - answer.size())) return Listening::kTooMuch;
    answer.insert(answer.end(), piece.begin(), piece.begin() + count);
    if (deadline.milliseconds_left() == 0) return Listening::kTooLate;
  }
}

// The child's status; also 0 if it was reaped elsewhere (SIGCHLD ignored): the answer then decides.
int status_of(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return 0;
  return status;
}

Error too_late(const ChildLimits& limits) {
  return content_error("took longer than " + number_text(limits.seconds) + " s");
}

Error too_much(std::uint64_t bytes) {
  return content_error("needs more than " +
                       number_text(std::ceil(static_cast<double>(bytes) / kMegabyte)) +
                       " MB of memory");
}

Status judge(int status, const ChildLimits& limits) {
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    if (signal == SIGXCPU) return too_late(limits);
    return content_error("crashed (signal " + std::to_string(signal) + ")");
  }
  switch (WEXITSTATUS(status)) {
    case 0:
      return Success{};
    case kOutOfMemory:
      return too_much(limits.memory);
    case kNoPipe:
      return system_error("the process that reads the file could not be set up");
    default:
      return content_error("gave up (exit code " + std::to_string(WEXITSTATUS(status)) + ")");
  }
}

}  // namespace

Result<std::vector<std::byte>> answer_of_child(const ChildWork& work, const ChildLimits& limits) {
  std::array<int, 2> ends = {};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return system_failure("make a pipe");
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) {
    const Error error = system_failure("start a process");
    ::close(ends[0]);
    ::close(ends[1]);
    return error;
  }
  if (child == 0) be_the_child(work, limits, ends[1], parent);

  ::close(ends[1]);
  std::vector<std::byte> answer;
  const Listening heard = listen(ends[0], limits, answer);
  const Error broken = system_failure("listen to the process that reads the file");
  ::close(ends[0]);
  if (heard != Listening::kEnd) ::kill(child, SIGKILL);
  const int status = status_of(child);
  if (heard == Listening::kTooLate) return too_late(limits);
  if (heard == Listening::kTooMuch) return too_much(limits.answer);
  if (heard == Listening::kFailed) return broken;
  const Status ended = judge(status, limits);
  if (!ended) return ended.error();
  return answer;
}

}  // namespace tremolo
