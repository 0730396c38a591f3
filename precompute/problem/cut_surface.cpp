#include "precompute/problem/cut_surface.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include "formats/file/os_error.h"
#include "formats/surface/surface_reader.h"
#include "precompute/system/child_program.h"
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
std::vector<std::string> mesher_arguments(const SolidFiles& files) {
  const SurfaceMeshOptions& meshing = files.meshing;
  std::vector<std::string> arguments = {"tremolo-mesh", files.mesh, "--answer",
                                        std::to_string(kAnswerDescriptor)};
  const auto add = [&arguments](const char* flag, const std::string& value) {
    arguments.emplace_back(flag);
    arguments.push_back(value);
  };
  if (meshing.size > 0) add("--size", number(meshing.size));
  if (meshing.tets > 0) add("--tets", std::to_string(meshing.tets));
  if (meshing.error > 0) add("--error", number(meshing.error));
  if (meshing.thicken > 0) add("--thicken", number(meshing.thicken));
  if (files.unit) add("--unit", files.unit->text);
  if (meshing.fill_holes) arguments.emplace_back("--fill-holes");
  if (meshing.keep_crumbs) arguments.emplace_back("--keep-crumbs");
  return arguments;
}

// Returns the child's wait status.
int run_mesher(const SolidFiles& files, const MemoryFile& answer) {
  std::string looked_at;
  const std::string program = program_beside("tremolo-mesh", looked_at);
  if (program.empty())
    throw Failure(system_error(
        files.mesh + ": a surface is cut by tremolo-mesh, which is not beside this program (" +
        looked_at + "): build it with `cmake --build --preset release --target tremolo-mesh`"));
  return run_child(program, mesher_arguments(files),
                   PassedDescriptor{answer.descriptor(), kAnswerDescriptor}, false);
}

}  // namespace

CutSurface cut_surface(const SolidFiles& files) {
  CutSurface result;
  result.render =
      std::move(unwrap(read_surface(files.mesh, {files.unit ? files.unit->metres : 0.0})).surface);
  const MemoryFile answer;
  const int status = run_mesher(files, answer);
  const std::vector<std::byte> bytes = answer.contents();
  if (WIFSIGNALED(status))
    throw Failure(system_error(files.mesh + ": tremolo-mesh was ended by signal " +
                               std::to_string(WTERMSIG(status)) + " (" +
                               ::strsignal(WTERMSIG(status)) + ")"));
  if (bytes.empty())
    throw Failure(system_error(files.mesh + ": tremolo-mesh ended without an answer, exit " +
                               "code " + std::to_string(WEXITSTATUS(status))));
  result.cut = unwrap(decode_answer(bytes));
  return result;
}

}  // namespace tremolo
