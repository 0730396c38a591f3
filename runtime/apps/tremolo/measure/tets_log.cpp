#include "runtime/apps/tremolo/measure/tets_log.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "formats/file/atomic_file.h"
#include "formats/surface/surface_writer.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/output/text_values.h"
#include "runtime/apps/tremolo/run/run_files.h"

namespace tremolo {
namespace {

constexpr const char* kTetsColumns =
    "t,kinetic,elastic,gravity,energy,switched_energy,quadratic_share,iterations,x,y,z,px,py,pz,"
    "lx,ly,lz,displacement";

constexpr std::size_t kMostTables = 64;  // open at a time

RenderSurface drawn_surface(const TetSurface& surface, const std::vector<Eigen::Vector3d>& vertices,
                            const std::vector<Eigen::Vector3f>& normals) {
  RenderSurface drawn;
  drawn.vertices = vertices;
  drawn.normals = normals;
  drawn.triangles = surface.rest().triangles;
  drawn.uvs = surface.rest().uvs;
  drawn.sources = surface.rest().sources;
  drawn.object_of.assign(drawn.triangles.size(), 0);
  drawn.material_of.assign(drawn.triangles.size(), 0);
  drawn.objects = {"body"};
  drawn.materials = {"body"};
  return drawn;
}

}  // namespace

void MomentumLoss::note(const TetBody& body, bool alone) {
  // A body that moves by less than this part of its size in a step has no momentum to lose.
  constexpr double kLeastWay = 1e-9;
  const TetModel& model = body.model();
  const Momenta before = now_;
  const Eigen::Vector3d centre = body.system().momentum(body.positions()) / model.mass();
  pushed_.resize(body.velocities().size());
  model.mass_times(body.velocities(), pushed_);
  now_ = {body.momentum(), Eigen::Vector3d::Zero()};
  double linear = 0.0, angular = 0.0;
  for (Eigen::Index i = 0; i < pushed_.size(); i += 3) {
    const Eigen::Vector3d arm = body.positions().segment<3>(i) - centre;
    now_.angular += arm.cross(pushed_.segment<3>(i));
    linear += pushed_.segment<3>(i).norm();
    angular += arm.norm() * pushed_.segment<3>(i).norm();
  }
  const double size = model.rest_box().diagonal(), step = body.options().step;
  const double least = kLeastWay * model.mass() * size / step;
  linear_size_ = std::max({linear_size_, linear, least});
  angular_size_ = std::max({angular_size_, angular, least * size});
  if (known_ && alone) {
    linear_ += now_.linear - before.linear - model.mass() * step * body.options().gravity;
    angular_ += now_.angular - before.angular;
    most_linear_ = std::max(most_linear_, linear_.norm());
    most_angular_ = std::max(most_angular_, angular_.norm());
  }
  known_ = true;
}

TetsLog::TetsLog(const TetScene& scene, const TetsKind& kind, std::size_t body, std::int64_t first)
    : outputs_(outputs_of_body(scene.outputs, scene.bodies[body].name)),
      steps_(std::llround(scene.duration / scene.step)),
      surface_(kind.surface),
      held_(kind.held),
      forces_(kind.model, scene.bodies[body].options.law),
      frames_(outputs_, {first, steps_}) {
  force_.resize(kind.model->rest().size());
}

Result<TetsLog> TetsLog::create(const TetScene& scene, const TetsKind& kind, std::size_t body,
                                std::int64_t first, const std::string& further) {
  TetsLog log(scene, kind, body, first);
  if (Status s = make_run_folder(log.outputs_.out); !s) return s.error();
  if (Status s = take(log.table_, CsvTable::create(table_path(log.outputs_), kTetsColumns + further,
                                                   scene.bodies.size() > kMostTables));
      !s)
    return s.error();
  return log;
}

// The sums of the elastic forces and of their torques, which are to be zero.
void TetsLog::note_forces(const TetBody& body) {
  forces_.set_degrees(body.system().degrees());
  forces_.evaluate(body.positions());
  report_.inverted = forces_.inverted();
  report_.inverted_most = std::max(report_.inverted_most, report_.inverted);
  force_.setZero();
  forces_.add_force(force_);
  const Eigen::Vector3d centre =
      Eigen::Map<const Eigen::Matrix3Xd>(body.positions().data(), 3, body.positions().size() / 3)
          .rowwise()
          .mean();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
  double size = 0.0, torque_size = 0.0;
  for (Eigen::Index i = 0; i < force_.size(); i += 3) {
    const Eigen::Vector3d f = force_.segment<3>(i);
    const Eigen::Vector3d turn = (body.positions().segment<3>(i) - centre).cross(f);
    sum += f;
    torque += turn;
    size += f.norm();
    torque_size += turn.norm();
  }
  force_sum_ = std::max(force_sum_, sum.norm());
  torque_sum_ = std::max(torque_sum_, torque.norm());
  force_size_ = std::max(force_size_, size);
  torque_size_ = std::max(torque_size_, torque_size);
  if (force_size_ > 0.0 && torque_size_ > 0.0)
    report_.elastic_error = std::max(force_sum_ / force_size_, torque_sum_ / torque_size_);
}

void TetsLog::look(TetBody& body) {
  const TetsEnergies now{body.kinetic_energy(), body.elastic_energy(), body.gravity_energy(),
                         report_.end.switches};
  if (!started_) report_.start = now;
  started_ = true;
  report_.end = now;
  note_forces(body);
}

Status TetsLog::write_row(const TetBody& body, const TetStepReport& step,
                          std::span<const double> further) {
  const TetsEnergies& e = report_.end;
  const Eigen::Vector3d p = body.momentum(), l = body.angular_momentum();
  // The first moment of mass about the origin gives the centre.
  const Eigen::Vector3d centre = body.system().momentum(body.positions()) / body.model().mass();
  table_.row() += fmt::format(
      "{:.9g},{:.12g},{:.12g},{:.12g},{:.12g},{:.6g},{:.6g},{},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},"
      "{:.9g},{:.9g},{:.9g},{:.9g},{:.9g}",
      body.time(), e.kinetic, e.elastic, e.gravity, e.total(), e.switches,
      body.system().quadratic_share(), step.iterations, centre.x(), centre.y(), centre.z(), p.x(),
      p.y(), p.z(), l.x(), l.y(), l.z(), report_.displacement);
  for (const double value : further) table_.row() += fmt::format(",{:.12g}", value);
  return table_.end_row();
}

void TetsLog::note_momenta(const TetBody& body, bool touched) {
  loss_.note(body, !held_ && !touched && !(body.options().drag > 0.0));
  if (!started_) report_.momenta_start = loss_.now();
  report_.momenta_end = loss_.now();
  report_.linear_lost = loss_.linear();
  report_.angular_lost = loss_.angular();
}

Status TetsLog::observe(TetBody& body, const TetStepReport& step, const TetSums& sums,
                        const std::vector<Eigen::Vector3d>& vertices,
                        const std::vector<Eigen::Vector3f>& normals, bool touched,
                        std::span<const double> further) {
  note_momenta(body, touched);
  report_.guarded = sums.guarded();
  report_.iterations = sums.iterations();
  report_.switched = sums.switched();
  report_.in_parts = sums.in_parts();
  report_.linearised = sums.linearised();
  report_.unsolved = sums.unsolved();
  report_.end.switches = sums.energy_of_switches();
  report_.jump = sums.jump();
  report_.share = sums.share();
  report_.displacement = sums.displacement();
  if (body.steps() % outputs_.every == 0 || body.steps() == steps_) {
    look(body);
    if (table_.is_written())
      if (Status s = write_row(body, step, further); !s) return s;
  }
  if (!frames_.due(body.steps())) return Success{};
  return frames_.write(body.time(), [&](const std::string& path) {
    return write_render_surface(path, drawn_surface(*surface_, vertices, normals));
  });
}

Status TetsLog::finish() {
  return finish_files(outputs_, frames_, table_, report_.files);
}

nlohmann::ordered_json energies_json(const TetsEnergies& e) {
  return {{"kinetic", number_or_null(e.kinetic)},
          {"elastic", number_or_null(e.elastic)},
          {"gravity", number_or_null(e.gravity)},
          {"total", number_or_null(e.total())}};
}

const char* degree_name(DegreeKind kind) {
  if (kind == DegreeKind::kLinear) return "linear";
  return kind == DegreeKind::kQuadratic ? "quadratic" : "adaptive";
}

nlohmann::ordered_json tets_report_json(const TetSceneBody& wanted, const TetBody& body,
                                        const TetsReport& report) {
  return {{"body", wanted.name},
          {"model", wanted.model},
          {"integrator", tet_method_name(wanted.options.method)},
          {"degree", degree_name(wanted.options.degree.kind)},
          {"elements", body.model().elements().size()},
          {"edges", body.model().edges()},
          {"mass", body.model().mass()},
          {"steps", body.steps()},
          {"reached", body.time()},
          {"quadratic_edges_share", number_or_null(report.share)},
          {"edges_switched", report.switched},
          {"energy_of_switches", number_or_null(report.end.switches)},
          {"largest_jump_of_switches", number_or_null(report.jump)},
          {"iterations_per_step", number_or_null(static_cast<double>(report.iterations) /
                                                 static_cast<double>(body.steps()))},
          {"steps_in_parts", report.in_parts},
          {"steps_linearised", report.linearised},
          {"steps_unsolved", report.unsolved},
          {"steps_guarded", report.guarded},
          {"elements_inverted_most", report.inverted_most},
          {"elements_inverted_final", report.inverted},
          {"momentum_error", number_or_null(report.momentum_error())},
          {"elastic_momentum_error", number_or_null(report.elastic_error)},
          {"linear_momentum_lost", number_or_null(report.linear_lost)},
          {"angular_momentum_lost", number_or_null(report.angular_lost)},
          {"linear_momentum_initial", vector_json(report.momenta_start.linear)},
          {"linear_momentum_final", vector_json(report.momenta_end.linear)},
          {"angular_momentum_initial", vector_json(report.momenta_start.angular)},
          {"angular_momentum_final", vector_json(report.momenta_end.angular)},
          {"speed_final", number_or_null(body.momentum().norm() / body.model().mass())},
          {"largest_displacement", number_or_null(report.displacement)},
          {"energies_initial", energies_json(report.start)},
          {"energies_final", energies_json(report.end)},
          {"files", report.files}};
}

PlacedBody placed_tets(const TetSceneBody& wanted, const TetSurface& surface, const TetBody& body) {
  PlacedBody place{wanted.name, "tets", wanted.model, wanted.pose, {}, {}};
  place.surface.resize(surface.rest().vertices.size());
  std::vector<Eigen::Vector3f> normals(place.surface.size());
  surface.place(body.positions(), place.surface, normals);
  return place;
}

}  // namespace tremolo
