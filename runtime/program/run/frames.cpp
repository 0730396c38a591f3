#include "runtime/program/run/frames.h"

#include <cmath>
#include <filesystem>
#include <span>

#include <fmt/format.h>

#include "formats/file/atomic_file.h"
#include "formats/surface/surface_writer.h"
#include "runtime/program/run/run_files.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

// The author's surface where the body is now.
Status write_render_shape(const Body& body, const std::string& path, const std::string& materials) {
  RenderSurface surface = body.model().render()->surface;
  const std::size_t count = 3 * surface.vertices.size();
  surface.normals.resize(surface.vertices.size());
  std::vector<float> positions(count);  // of the normals; those that are written are exact
  const Status normals = body.surface(positions, std::span(surface.normals[0].data(), count));
  if (!normals) return normals;
  const Status exact = body.surface_positions(std::span<double>(surface.vertices[0].data(), count));
  if (!exact) return exact;
  return write_render_surface(path, surface, materials);
}

}  // namespace

Status write_shape(const Body& body, const std::string& path, const std::string& materials) {
  if (body.model().render() != nullptr) return write_render_shape(body, path, materials);
  SurfaceMesh surface;
  surface.vertices.resize(body.model().surface().vertex_ids.size());
  surface.triangles = body.model().triangles();
  // Eigen's fixed-size vectors are contiguous.
  const std::span<double> flat(surface.vertices.empty() ? nullptr : surface.vertices[0].data(),
                               3 * surface.vertices.size());
  if (Status status = body.surface_positions(flat); !status) return status;
  return write_surface(path, surface);
}

bool Frames::due(std::int64_t steps) const {
  if (written_ >= options_.surfaces) return false;
  return steps >= std::llround(static_cast<double>(steps_) * (written_ + 1) / options_.surfaces);
}

Status Frames::keep(const std::string& path, Status status) {
  if (status) files_.push_back(path);
  return status;
}

Status Frames::write(const Body& body, double time) {
  const std::string name = frame_name(written_, time, options_.surface_format);
  const std::string path = (fs::path(options_.out) / name).string();
  list_ += fmt::format("{},{:.9g},{}\n", written_, time, name);
  ++written_;
  return keep(path, write_shape(body, path, kMaterialsName));
}

Status Frames::finish(const Model& model) {
  if (written_ == 0) return Success{};
  const std::string list = (fs::path(options_.out) / kFramesName).string();
  if (Status status = keep(list, write_file(list, list_)); !status) return status;
  if (options_.surface_format != "obj" || model.render() == nullptr) return Success{};
  const std::string materials = (fs::path(options_.out) / kMaterialsName).string();
  return keep(materials, write_file(materials, material_library(model.render()->surface)));
}

}  // namespace tremolo
