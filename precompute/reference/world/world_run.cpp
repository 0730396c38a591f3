#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>

#include "common/stage_log.h"
#include "common/text.h"
#include "formats/file/atomic_file.h"
#include "formats/file/standard_streams.h"
#include "precompute/fem/control_values.h"
#include "precompute/reference/reference_options.h"
#include "precompute/reference/reference_report.h"
#include "precompute/reference/reference_setup.h"
#include "precompute/reference/world/whole_frame.h"
#include "precompute/reference/world/world_step.h"
#include "precompute/system/blas_threads.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

using Clock = std::chrono::steady_clock;

void require(bool good, ErrorKind kind, const char* message) {
  if (!good) throw Failure({kind, message});
}

bool flies(const ReferenceOptions& options) {
  return options.spin || options.velocity;
}

void check_flags(const ReferenceOptions& options) {
  const ErrorKind usage = ErrorKind::kUsage;
  require(
      !flies(options) || options.support_motion.empty(), usage,
      "--support-motion applies only to a fixed body, --spin and --velocity only to a free one");
  require(!options.statics, usage, "--static applies only to a body at rest in the world");
  require(options.compare.empty(), usage,
          "--compare applies only to a body at rest in the world; move a body of libtremolo in "
          "the same way and compare both tables");
  require(!flies(options) || options.time.alpha == 0, usage,
          "--alpha damps the motion relative to a support, and a body that flies has none");
  for (const auto& vector : {options.spin, options.velocity})
    require(!vector || vector->allFinite(), ErrorKind::kContent,
            "--spin and --velocity must be finite");
}

void check_problem(const ReferenceOptions& options, const Problem& problem) {
  const ErrorKind content = ErrorKind::kContent;
  require(flies(options) == problem.free_body, content,
          flies(options) ? "--spin and --velocity apply only to a free body: use --fix none"
                         : "--support-motion: the body is not fixed anywhere");
  for (const std::vector<VertexId>& along : problem.held)
    require(along.empty(), content,
            "--fix-x, --fix-y and --fix-z hold along axes of the world and do not go with a body "
            "that turns");
}

// The path of the support, which must last as long as the run.
std::optional<PosePath> support_path(const ReferenceOptions& options) {
  if (options.support_motion.empty()) return {};
  PosePath path = read_pose_path(options.support_motion);
  const double slack = 1e-9 * options.time.step;
  if (path.first() > slack || path.last() < options.duration - slack)
    throw Failure(content_error(
        text("%s: the motion lasts from %.9g to %.9g s, the run from 0 to "
             "%.9g s",
             options.support_motion.c_str(), path.first(), path.last(), options.duration)));
  return path;
}

struct WorldLoads {
  Vector point, gravity;
  Signal signal;
};

WorldLoads make_loads(const ReferenceOptions& options, const Problem& problem,
                      const FullOrder& body) {
  WorldLoads loads{options.scale * point_load(body, problem.load),
                   gravity_load(body, options.gravity), unwrap(parse_signal("none"))};
  if (!problem.load.vertices.empty())
    loads.signal = unwrap(parse_signal(options.load.value_or("impulse")));
  return loads;
}

// The first motion of a body that flies. spin: along the world's axes.
RigidMotion first_flight(const ReferenceOptions& options, const WorldBody& world) {
  RigidMotion flight;
  Field ones = Field::Zero(world.body.unknowns.of_dof.size());
  for (Eigen::Index v = 0; v < ones.size(); v += 3) ones[v] = 1.0;
  const Field mass = whole_mass_times(world, ones);
  for (std::size_t v = 0; v < world.body.solid.mesh.vertices.size(); ++v)
    flight.position +=
        mass[3 * static_cast<Eigen::Index>(v)] / mass.sum() * world.body.solid.mesh.vertices[v];
  flight.speed = options.velocity.value_or(Eigen::Vector3d::Zero());
  flight.spin = options.spin.value_or(Eigen::Vector3d::Zero());
  return flight;
}

struct WorldCourse {
  Motion motion;
  DriftMeter drift;
  std::string table;
  Field relative;  // displacements in the frame, 3n
  double seconds = 0;
};

void record(const ReferenceOptions& options, const WorldBody& world,
            const std::vector<VertexId>& probes, WorldCourse& course) {
  const Motion& motion = course.motion;
  const Field displacement = whole_displacement(world, motion);
  const WholeFrame frame =
      whole_frame(world, motion.time, displacement, whole_velocity(world, motion));
  BasisRows relative = displacement_in(frame, world, displacement);
  to_displacements(world.body.solid.mesh, relative);
  course.relative = relative.col(0);
  if (!options.out.empty()) course.table += world_table_row(motion, frame, probes, course.relative);
}

void move(const ReferenceOptions& options, WorldBody& world, const WorldLoads& loads,
          const std::vector<VertexId>& probes, WorldCourse& course) {
  const std::int64_t steps = std::llround(options.duration / options.time.step);
  const LoadHistory load = [&](double time, double step) -> Vector {
    return sample_signal(loads.signal, time, step).average * loads.point + loads.gravity;
  };
  const Clock::time_point start = Clock::now();
  double last_report = 0;
  Motion& motion = course.motion;
  for (;;) {
    const bool loaded = world.path != nullptr || !loads.gravity.isZero(0.0) ||
                        motion.time < signal_end(loads.signal) - 1e-9 * options.time.step;
    course.drift.observe(motion.total(), motion.work, motion.dissipated, loaded);
    if (motion.steps % options.every == 0 || motion.steps == steps)
      record(options, world, probes, course);
    if (motion.steps == steps) break;
    advance_in_world(world, options.time, load, motion);
    course.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    if (course.seconds < last_report + 5.0) continue;
    last_report = course.seconds;
    print_progress(motion, steps, last_report);
  }
  print_progress(motion, steps, course.seconds);
}

Json first_json(const ReferenceOptions& options, const Problem& problem, const FullOrder& body) {
  Json json;
  json["mesh"] = options.solid.files.mesh;
  json["n"] = problem.mesh.vertices.size();
  json["m"] = problem.mesh.tetrahedra.size();
  json["order"] = problem.order;
  json["dofs"] = body.size();
  json["integrator"] = options.time.scheme == TimeScheme::kMidpoint ? "midpoint" : "avf";
  json["step"] = options.time.step;
  json["duration"] = options.duration;
  return json;
}

Problem load(const ReferenceOptions& options, StageLog& log) {
  log.begin("mesh");
  Problem problem = load_problem(options.solid);
  log.end(text("%zu vertices, %zu tetrahedra, %zu fixed vertices", problem.mesh.vertices.size(),
               problem.mesh.tetrahedra.size(), problem.fixed.size()));
  for (const std::string& note : problem.notes) log.note(note);
  check_problem(options, problem);
  problem.free_body = false;  // the rigid motion of a body that flies is part of its motion
  require_output(options);
  return problem;
}

}  // namespace

bool moves_in_world(const ReferenceOptions& options) {
  return flies(options) || !options.support_motion.empty();
}

void run_in_world(const ReferenceOptions& options) {
  check_reference(options);
  check_flags(options);
  const std::optional<PosePath> path = support_path(options);
  StageLog log(false);
  const Problem problem = load(options, log);
  const std::vector<VertexId> probes = probe_vertices(options, problem.mesh);
  log.begin("matrices");
  FullOrder body = make_full_order(problem, options.solid.elements.mass, options.solid.threads);
  log.end(text("%d dofs, %.6g kg", static_cast<int>(body.size()), total_mass(body.solid)));

  const BlasThreads blas(1);
  FullOrderSolver solver;
  solver.body = &body;
  solver.options = {options.tolerance, options.max_iterations};
  WorldBody world{body, solver, options.solid.elements.mass, path ? &*path : nullptr};
  WorldCourse course;
  course.motion = start_in_world(world, first_flight(options, world));
  course.table = world_table_head(probes);
  std::optional<Failure> broken;
  try {
    move(options, world, make_loads(options, problem, body), probes, course);
  } catch (const Failure& failure) {
    broken = failure;
  }
  Json json = first_json(options, problem, body);
  report_motion(course.motion, course.drift, course.seconds, json);
  json["probes"] = probe_json(probes, course.relative);
  if (!options.out.empty())
    if (const Status written = write_file(table_path(options), course.table); !written && !broken)
      broken = Failure(written.error());
  json["exit_code"] = broken ? exit_code(broken->error()) : 0;
  json["reason"] = broken ? Json(broken->error().message) : Json(nullptr);
  if (options.json) print_json(json);
  unwrap(flush_standard_output());
  if (broken) throw Failure(*broken);
}

}  // namespace tremolo
