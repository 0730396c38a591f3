#include "runtime/program/cloth/cloth_files.h"

#include <cmath>
#include <filesystem>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "formats/surface/surface_writer.h"
#include "runtime/cloth/cloth_model.h"
#include "runtime/program/run/run_files.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kTablePiece = std::size_t{1} << 16;  // bytes; a write some hundred rows

SurfaceMesh shape_of(const ClothWorld& world, std::size_t cloth) {
  SurfaceMesh surface;
  const Eigen::VectorXd& x = world.positions(cloth);
  surface.vertices.resize(world.particles(cloth));
  for (std::size_t i = 0; i < surface.vertices.size(); ++i)
    surface.vertices[i] = x.segment<3>(3 * i);
  surface.triangles = world.triangles(cloth);
  return surface;
}

// The author's surface; its normals are those of the triangles now.
RenderSurface file_shape_of(const ClothParts& parts, const Eigen::VectorXd& x) {
  RenderSurface surface = drawn_at(parts, x);
  if (surface.normals.empty()) return surface;
  const std::vector<Eigen::Vector3d> normals =
      vertex_normals(SurfaceMesh{surface.vertices, surface.triangles});
  for (std::size_t v = 0; v < normals.size(); ++v)
    if (!normals[v].isZero()) surface.normals[v] = normals[v].cast<float>();
  return surface;
}

}  // namespace

Result<ClothTable> ClothTable::create(const std::string& path, const ClothScene& scene) {
  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file) return file.error();
  ClothTable table(std::move(*file));
  table.text_ =
      "t,kinetic,elastic,gravity,total,damped,wind,pins,contact,numerical,px,py,pz,lx,ly,lz,"
      "penetration";
  for (const SceneBall& ball : scene.balls)
    table.text_ += fmt::format(",{0}x,{0}y,{0}z", ball.name);
  table.text_ += '\n';
  return table;
}

Status ClothTable::write(const ClothWorld& world, const ClothEnergy& energy) {
  const Eigen::Vector3d p = world.linear_momentum(), l = world.angular_momentum();
  auto out = std::back_inserter(text_);
  fmt::format_to(out, "{:.9g}", world.time());
  for (const double value :
       {energy.kinetic, energy.elastic, energy.gravity, energy.total(), energy.damped, energy.wind,
        energy.pins, energy.contact, energy.numerical, p.x(), p.y(), p.z(), l.x(), l.y(), l.z(),
        world.penetration_max()})
    fmt::format_to(out, ",{:.12g}", value);
  for (const ClothWorld::Ball& ball : world.balls())
    for (const double value : ball.position) fmt::format_to(out, ",{:.9g}", value);
  text_ += '\n';
  if (text_.size() < kTablePiece) return Success{};
  const Status status = file_.write(text_);
  text_.clear();
  return status;
}

Status ClothTable::finish() {
  if (Status s = file_.write(text_); !s) return s;
  return file_.commit();
}

bool ClothFrames::due(std::int64_t steps) const {
  if (written_ >= count_) return false;
  return steps >= std::llround(static_cast<double>(steps_) * (written_ + 1) / count_);
}

Status ClothFrames::write(const ClothWorld& world, std::size_t cloth) {
  const std::string name = frame_name(written_, world.time(), format_);
  const std::string path = (fs::path(folder_) / name).string();
  list_ += fmt::format("{},{:.9g},{}\n", written_, world.time(), name);
  ++written_;
  const ClothParts& parts = world.model(cloth).parts();
  if (parts.drawn != nullptr) {
    const RenderSurface surface = file_shape_of(parts, world.positions(cloth));
    if (Status s = write_render_surface(path, surface); !s) return s;
  } else if (Status s = write_surface(path, shape_of(world, cloth)); !s) {
    return s;
  }
  files_.push_back(path);
  return Success{};
}

Status ClothFrames::finish() {
  if (written_ > 0) {
    const std::string list = (fs::path(folder_) / kFramesName).string();
    if (Status s = write_file(list, list_); !s) return s;
    files_.push_back(list);
  }
  return Success{};
}

}  // namespace tremolo
