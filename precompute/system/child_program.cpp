#include "precompute/system/child_program.h"

#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/result.h"
#include "precompute/system/failure.h"

namespace tremolo {

std::string program_beside(const std::string& name, std::string& looked_at) {
  std::error_code error;
  const std::filesystem::path here = std::filesystem::read_symlink("/proc/self/exe", error);
  looked_at = (here.parent_path() / name).string();
  return ::access(looked_at.c_str(), X_OK) == 0 ? looked_at : std::string();
}

int run_child(const std::string& program, std::vector<std::string> arguments,
              const std::optional<PassedDescriptor>& passed, bool silent) {
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  if (passed) ::posix_spawn_file_actions_adddup2(&actions, passed->here, passed->there);
  ::posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  if (silent) ::posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  const int error =
      ::posix_spawn(&child, program.c_str(), &actions, nullptr, pointers.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    errno = error;
    throw Failure(os_error(program + ": cannot be started"));
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) throw Failure(os_error(program + ": cannot be waited for"));
  return status;
}

}  // namespace tremolo
