#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <spawn.h>
#include <string_view>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>

#include "runtime/apps/tremolo/output/plot.h"

extern char** environ;

namespace tremolo {
namespace {

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { close(); }
  int number() const { return number_; }
  void close() {
    if (number_ >= 0) ::close(std::exchange(number_, -1));
  }

 private:
  int number_;
};

Error failure(const char* what) {
  return system_error(std::string("gnuplot cannot be started: ") + what + ": " +
                      std::strerror(errno));
}

bool write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    text.remove_prefix(written);
  }
  return true;
}

bool read_all(int descriptor, std::string& text) {
  char buffer[1 << 16];
  for (;;) {
    const ssize_t got = ::read(descriptor, buffer, sizeof(buffer));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return got == 0;
    text.append(buffer, got);
  }
}

int wait_for(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return -1;
  return status;
}

// Starts gnuplot between the two; an errno, or 0.
int start(int input, int output, pid_t& child) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
  char name[] = "gnuplot";
  char* words[] = {name, nullptr};
  const int code = ::posix_spawnp(&child, name, &actions, nullptr, words, environ);
  posix_spawn_file_actions_destroy(&actions);
  return code;
}

}  // namespace

std::string gnuplot_quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) {
    if (c == '\'') result += '\'';
    result += c == '\n' || c == '\r' ? ' ' : c;
  }
  return result + "'";
}

bool has_gnuplot() {
  const char* folders = std::getenv("PATH");
  for (std::string_view rest = folders == nullptr ? "" : folders; !rest.empty();) {
    const std::string_view folder = rest.substr(0, rest.find(':'));
    rest.remove_prefix(std::min(rest.size(), folder.size() + 1));
    if (::access((std::string(folder) + "/gnuplot").c_str(), X_OK) == 0) return true;
  }
  return false;
}

Result<std::string> run_gnuplot(const std::string& script) {
  // A file in memory: gnuplot may read it at its own pace while its picture fills the pipe.
  const Descriptor input(::memfd_create("tremolo-gnuplot", MFD_CLOEXEC));
  if (input.number() < 0 || !write_all(input.number(), script) ||
      ::lseek(input.number(), 0, SEEK_SET) != 0)
    return failure("its script cannot be stored");
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return failure("no pipe");
  Descriptor from(ends[0]), to(ends[1]);
  pid_t child = 0;
  if (const int code = start(input.number(), to.number(), child); code != 0) {
    errno = code;
    if (code == ENOENT)
      return system_error("gnuplot is not installed (Debian: apt-get install gnuplot-nox)");
    return failure("no process");
  }
  to.close();
  std::string picture;
  const bool whole = read_all(from.number(), picture);
  const int status = wait_for(child);
  if (!whole || status != 0) return system_error("gnuplot failed");
  if (picture.empty()) return system_error("gnuplot drew nothing");
  return picture;
}

}  // namespace tremolo
