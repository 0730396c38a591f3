#include "precompute/problem/cut_surface.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <spawn.h>
#include <string>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include "common/length_unit.h"
#include "formats/file/os_error.h"
#include "formats/surface/surface_reader.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

constexpr int kAnswerDescriptor = 3;  // file descriptor on which the child writes its answer

// An anonymous file in memory; it is freed when its descriptor closes.
class MemoryFile {
 public:
  MemoryFile() : descriptor_(::memfd_create("tremolo-mesh", MFD_CLOEXEC)) {
    if (descriptor_ < 0) throw Failure(os_error("no file in memory for tremolo-mesh"));
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { ::close(descriptor_); }
  int descriptor() const { return descriptor_; }

  std::vector<std::byte> contents() const {
    struct stat status = {};
    if (::fstat(descriptor_, &status) != 0) throw Failure(os_error("the answer of tremolo-mesh"));
    std::vector<std::byte> bytes(status.st_size);
    for (std::size_t at = 0; at < bytes.size();) {
      const ssize_t count =
          ::pread(descriptor_, bytes.data() + at, bytes.size() - at, static_cast<off_t>(at));
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) throw Failure(os_error("the answer of tremolo-mesh"));
      at += count;
    }
    return bytes;
  }

 private:
  int descriptor_;
};

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof(text), "%.17g", value);
  return text;
}

// Builds the child's command line; options that were not given are left out.
std::vector<std::string> mesher_arguments(const ProblemRequest& request) {
  const SurfaceMeshOptions& meshing = request.meshing;
  std::vector<std::string> arguments = {"tremolo-mesh", request.mesh_path, "--answer",
                                        std::to_string(kAnswerDescriptor)};
  const auto add = [&arguments](const char* flag, const std::string& value) {
    arguments.emplace_back(flag);
    arguments.push_back(value);
  };
  if (meshing.size > 0) add("--size", number(meshing.size));
  if (meshing.tets > 0) add("--tets", std::to_string(meshing.tets));
  if (meshing.error > 0) add("--error", number(meshing.error));
  if (meshing.thicken > 0) add("--thicken", number(meshing.thicken));
  if (!request.unit.empty()) add("--unit", request.unit);
  if (meshing.fill_holes) arguments.emplace_back("--fill-holes");
  if (meshing.keep_crumbs) arguments.emplace_back("--keep-crumbs");
  return arguments;
}

std::string mesher_program(const std::string& path) {
  std::error_code error;
  const std::filesystem::path here = std::filesystem::read_symlink("/proc/self/exe", error);
  std::string program = (here.parent_path() / "tremolo-mesh").string();
  if (::access(program.c_str(), X_OK) != 0)
    throw Failure(system_error(
        path + ": a surface is cut by tremolo-mesh, which is not beside this program (" + program +
        "): build it with `cmake --build --preset release --target tremolo-mesh`"));
  return program;
}

// Returns the child's wait status.
int run_mesher(const ProblemRequest& request, const MemoryFile& answer) {
  const std::string program = mesher_program(request.mesh_path);
  std::vector<std::string> arguments = mesher_arguments(request);
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, answer.descriptor(), kAnswerDescriptor);
  ::posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
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

RenderSurface read_render_surface(const ProblemRequest& request) {
  SurfaceReadOptions reading;
  if (!request.unit.empty()) reading.metres_per_unit = unwrap(metres_per_unit(request.unit));
  return std::move(unwrap(read_surface(request.mesh_path, reading)).surface);
}

}  // namespace

CutSurface cut_surface(const ProblemRequest& request) {
  CutSurface result;
  result.render = read_render_surface(request);
  const MemoryFile answer;
  const int status = run_mesher(request, answer);
  const std::vector<std::byte> bytes = answer.contents();
  if (WIFSIGNALED(status))
    throw Failure(system_error(request.mesh_path + ": tremolo-mesh was ended by signal " +
                               std::to_string(WTERMSIG(status)) + " (" +
                               ::strsignal(WTERMSIG(status)) + ")"));
  if (bytes.empty())
    throw Failure(system_error(request.mesh_path + ": tremolo-mesh ended without an answer, exit " +
                               "code " + std::to_string(WEXITSTATUS(status))));
  result.cut = unwrap(decode_answer(bytes));
  return result;
}

}  // namespace tremolo
