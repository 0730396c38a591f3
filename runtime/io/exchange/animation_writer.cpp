#include "runtime/io/exchange/animation_writer.h"

#include <filesystem>

#include "runtime/io/exchange/glb_writer.h"

namespace tremolo {

Result<std::vector<WrittenFile>> write_animation(const std::string& path,
                                                 const Animation& animation) {
  const std::string ending = std::filesystem::path(path).extension().string();
  if (ending == ".glb") {
    const Result<GlbReport> report = write_glb(path, animation);
    if (!report) return report.error();
    return std::vector<WrittenFile>{{path, report->bytes}};
  }
  if (ending == ".usda") {
    const Result<WrittenFile> written = write_usda(path, animation);
    if (!written) return written.error();
    return std::vector<WrittenFile>{*written};
  }
  if (ending == ".pc2" || ending == ".mdd") return write_point_caches(path, animation);
  if (ending == ".pvd") return write_pvd(path, animation);
  if (ending == ".ply" || ending == ".obj") return write_surface_series(path, animation);
  return usage_error(path + ": an animation ends in .glb, .usda, .pvd, .pc2, .mdd, .ply or .obj");
}

}  // namespace tremolo
