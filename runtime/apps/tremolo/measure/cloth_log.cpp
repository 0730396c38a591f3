#include "runtime/apps/tremolo/measure/cloth_log.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "formats/surface/surface_writer.h"
#include "runtime/apps/tremolo/output/plot.h"
#include "runtime/apps/tremolo/run/run_files.h"
#include "runtime/bodies/cloth/cloth_model.h"
#include "runtime/energy_bound.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

SurfaceMesh shape_of(const ClothParts& parts, const Eigen::VectorXd& x) {
  SurfaceMesh surface;
  surface.vertices.resize(parts.particles());
  for (std::size_t i = 0; i < surface.vertices.size(); ++i)
    surface.vertices[i] = x.segment<3>(3 * i);
  surface.triangles = parts.triangles;
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

Status write_cloth_surface(const ClothParts& parts, const Eigen::VectorXd& x,
                           const std::string& path) {
  if (parts.drawn == nullptr) return write_surface(path, shape_of(parts, x));
  return write_render_surface(path, file_shape_of(parts, x));
}

Result<ClothTable> ClothTable::create(const std::string& path, const ClothScene& scene) {
  std::string head =
      "t,kinetic,elastic,gravity,total,damped,wind,pins,contact,numerical,px,py,pz,lx,ly,lz,"
      "penetration";
  for (const SceneBall& ball : scene.balls) head += fmt::format(",{0}x,{0}y,{0}z", ball.name);
  Result<CsvTable> table = CsvTable::create(path, std::move(head));
  if (!table) return table.error();
  return ClothTable(std::move(*table));
}

Status ClothTable::write(const ClothWorld& world, const ClothEnergy& energy) {
  const Eigen::Vector3d p = world.linear_momentum(), l = world.angular_momentum();
  auto out = std::back_inserter(table_.row());
  fmt::format_to(out, "{:.9g}", world.time());
  for (const double value :
       {energy.kinetic, energy.elastic, energy.gravity, energy.total(), energy.damped, energy.wind,
        energy.pins, energy.contact, energy.numerical, p.x(), p.y(), p.z(), l.x(), l.y(), l.z(),
        world.penetration_max()})
    fmt::format_to(out, ",{:.12g}", value);
  for (const ClothWorld::Ball& ball : world.balls())
    for (const double value : ball.position) fmt::format_to(out, ",{:.9g}", value);
  return table_.end_row();
}

namespace {

Momenta momenta_of(const ClothWorld& world) {
  return {world.linear_momentum(), world.angular_momentum()};
}

// Energy given by wind, pins and contact less that taken by dampers, J.
double external_energy(const ClothEnergy& energy) {
  return energy.wind + energy.pins + energy.contact - energy.damped;
}

double cloth_turnover(const ClothEnergy& energy) {
  return std::abs(energy.wind) + std::abs(energy.pins) + std::abs(energy.contact) +
         std::abs(energy.damped);
}

}  // namespace

ClothLog::ClothLog(const ClothFile& file, const ClothWorld& world) : file_(&file) {
  report_.start = world.energy();
  report_.momenta_start = momenta_of(world);
}

Result<ClothLog> ClothLog::create(const ClothFile& file, const ClothWorld& world) {
  ClothLog log(file, world);
  if (file.outputs.out.empty()) return log;
  const std::int64_t steps = std::llround(file.scene.duration / file.scene.options.step);
  for (const SceneCloth& cloth : file.scene.cloths) {
    const SceneOutputs outputs = outputs_of_body(file.outputs, cloth.name);
    if (Status s = make_run_folder(outputs.out); !s) return s.error();
    log.frames_.emplace_back(outputs, StepRange{0, steps});
  }
  Result<ClothTable> table = ClothTable::create(table_path(file.outputs), file.scene);
  if (!table) return table.error();
  log.table_.emplace(std::move(*table));
  return log;
}

void ClothLog::note_energy(const ClothEnergy& now) {
  const double remainder = now.total() - report_.start.total() - external_energy(now);
  const double moved = now.kinetic + now.elastic + std::abs(now.gravity - report_.start.gravity);
  report_.end = now;
  report_.balance.observe(moved, remainder, cloth_turnover(now));
}

Result<bool> ClothLog::observe(const ClothWorld& world) {
  const ClothEnergy now = world.energy();
  note_energy(now);
  if (!file_->outputs.out.empty()) {
    if (world.steps() % file_->outputs.every == 0)
      if (Status s = table_->write(world, now); !s) return s.error();
    for (std::size_t i = 0; i < frames_.size(); ++i)
      if (frames_[i].due(world.steps()))
        if (Status s = frames_[i].write(world.time(),
                                        [&](const std::string& path) {
                                          return write_cloth_surface(world.model(i).parts(),
                                                                     world.positions(i), path);
                                        });
            !s)
          return s.error();
  }
  // Upper bound: the initial energy plus the sizes of all energy exchanged with gravity and others.
  const double given = report_.start.kinetic + report_.start.elastic +
                       std::abs(report_.start.gravity - now.gravity) + cloth_turnover(now);
  const double present = now.kinetic + now.elastic;
  if (std::isfinite(present) && present <= kEnergyBound * given) return true;
  report_.leave_bound(present, world.time());
  return false;
}

void ClothLog::give_up(const Error& why) {
  report_.exit_code = exit_code(why);
  report_.reason = why.message;
}

Status ClothLog::finish(const ClothWorld& world) {
  report_.momenta_end = momenta_of(world);
  const SceneOutputs& outputs = file_->outputs;
  if (outputs.out.empty()) return Success{};
  if (Status s = table_->finish(); !s) return s;
  report_.files.push_back(table_path(outputs));
  const std::string label = fs::path(file_->path).stem().string();
  if (outputs.plot)
    if (Status s = plot_run({label, report_.files[0]}, outputs.out, report_.files); !s) return s;
  for (Frames& frames : frames_) {
    if (Status s = frames.finish(); !s) return s;
    report_.files.insert(report_.files.end(), frames.files().begin(), frames.files().end());
  }
  return Success{};
}

}  // namespace tremolo
