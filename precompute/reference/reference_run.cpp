#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "common/stage_log.h"
#include "common/text.h"
#include "formats/basis/basis_reader.h"
#include "formats/basis/selector_reader.h"
#include "formats/file/atomic_file.h"
#include "formats/file/standard_streams.h"
#include "precompute/fem/control_values.h"
#include "precompute/problem/wall_layers.h"
#include "precompute/reference/reference_report.h"
#include "precompute/reference/reference_setup.h"
#include "precompute/system/blas_threads.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

using Clock = std::chrono::steady_clock;

// A reduced model compared alongside, until its solve fails.
struct Companion {
  std::string file;
  ReducedBody body;
  Vector response = {};  // W f to the load without gravity, of the unknowns
  std::vector<Moment> moments = {};
  double seconds = 0;
  std::optional<Failure> broken = {};
};

struct Work {
  const ReferenceOptions& options;
  const FullOrder& body;
  FullOrderSolver& solver;
  BodyLoads loads;
  std::vector<VertexId> probes;
  std::vector<VertexId> watched;  // the probes, else the loaded vertices
  std::vector<Companion> companions;
  Vector response = {};  // K^-1 f to the whole load
  Json json = {};
  std::optional<Failure> broken = {};  // why the run ended early

  SolveOptions solving() const { return {options.tolerance, options.max_iterations}; }
};

std::vector<Companion> load_companions(const ReferenceOptions& options, const Problem& problem,
                                       const FullOrder& body) {
  std::vector<Companion> companions;
  for (const std::string& file : options.compare) {
    const BasisData data = unwrap(read_basis(file));
    companions.push_back(
        {file, make_reduced_body(body, data, problem.mesh_hash, options.modes, file)});
  }
  return companions;
}

// Results are still reported if the table cannot be written.
void write_table(Work& work, const ReferenceTable& table) {
  if (work.options.out.empty()) return;
  const Status written = write_file(table_path(work.options), table.text);
  if (!written && !work.broken) work.broken = Failure(written.error());
}

// Its results are informative only, so a failure must not discard the others.
Vector response_to(Work& work, const Vector& load) {
  try {
    return linear_response(work.solver, load);
  } catch (const Failure& failure) {
    std::fprintf(stderr, "  the share of the load that the basis leaves out is unknown: %s\n",
                 failure.error().message.c_str());
    return Vector::Zero(work.body.size());
  }
}

void report_comparisons(Work& work) {
  if (work.companions.empty()) return;
  const Vector load = work.loads.all();
  Json list = Json::array();
  for (const Companion& companion : work.companions) {
    const ComparisonSummary summary = summarise(companion.moments);
    const double unseen = unseen_load(companion.body, load, work.response);
    Json json = comparison_json(companion.file, companion.body, summary, unseen, companion.seconds);
    json["reason"] = companion.broken ? Json(companion.broken->error().message) : Json(nullptr);
    list.push_back(std::move(json));
    print_comparison(companion.file, companion.body, summary, unseen);
    if (companion.broken && !work.broken)
      work.broken = Failure({companion.broken->error().kind,
                             companion.file + ": " + companion.broken->error().message});
  }
  if (list.size() == 1)
    work.json["comparison"] = list.front();
  else if (list.size() > 1)
    work.json["comparisons"] = list;
}

void find_responses(Work& work) {
  if (work.companions.empty()) return;
  work.response = response_to(work, work.loads.all());
  const Vector& point = work.loads.point;
  const Vector to_point = work.loads.gravity.isZero(0.0) ? work.response : response_to(work, point);
  for (Companion& companion : work.companions)
    companion.response = response_beyond(companion.body, point, to_point);
}

// reduced: one motion per companion; ignored if the companion is broken. share: of the load that
// acts.
void record(Work& work, const Motion& motion, const std::vector<const Motion*>& reduced,
            double share, ReferenceTable& table) {
  const bool writing = !work.options.out.empty();
  Vector mass_u;
  if (!work.companions.empty()) mass_u = multiply(work.body, work.body.mass, motion.u);
  std::vector<std::optional<ReducedRow>> rows;
  for (std::size_t i = 0; i < work.companions.size(); ++i) {
    Companion& companion = work.companions[i];
    rows.emplace_back();
    if (companion.broken) continue;
    Moment moment =
        compare(work.body, companion.body, motion.u, mass_u, reduced[i]->u, work.watched);
    moment.energy_difference = reduced[i]->total() - motion.total();
    compare_shown(work.body, companion.body, motion.u, reduced[i]->u, share * companion.response,
                  work.watched, moment);
    companion.moments.push_back(moment);
    if (writing)
      rows.back() = {moment, reduced[i]->total(),
                     expand(work.body.unknowns, companion.body.basis * reduced[i]->u)};
  }
  if (writing) add_row(motion, expand(work.body.unknowns, motion.u), rows, table);
}

// Returns an equilibrium as a motion with zero velocity.
Motion at_rest(const StaticSolution& solution) {
  Motion motion;
  motion.u = solution.u;
  motion.potential = solution.energy;
  motion.work = solution.work;
  return motion;
}

// Runs `part`; stores a Failure in `broken`. Returns the elapsed time, s.
template <class Part>
double attempt(const Part& part, std::optional<Failure>& broken) {
  const Clock::time_point start = Clock::now();
  try {
    part();
  } catch (const Failure& failure) {
    broken = failure;
  }
  return seconds_since(start);
}

void run_statics(Work& work) {
  StaticSolution solution;
  const double seconds = attempt(
      [&] { solution = static_solution(make_system(work.solver), work.loads.all()); }, work.broken);
  if (work.broken) return;
  const Vector field = expand(work.body.unknowns, solution.u);
  report_statics(solution, seconds, work.json);
  BasisRows displacements = field;
  to_displacements(work.body.solid.mesh, displacements);
  work.json["largest"] = largest_json(displacements.col(0));
  work.json["probes"] = probe_json(work.probes, field);
  std::fprintf(stderr, "  largest displacement %.6g m\n",
               work.json["largest"]["displacement"].get<double>());
  ReferenceTable table = begin_table(work.probes, work.companions.size());
  std::vector<Motion> reduced(work.companions.size());
  std::vector<const Motion*> motions;
  for (std::size_t i = 0; i < reduced.size(); ++i) {
    Companion& companion = work.companions[i];
    companion.seconds = attempt(
        [&] {
          reduced[i] =
              at_rest(static_solution(make_system(companion.body.model, work.solving()),
                                      companion.body.basis.transpose() * work.loads.all()));
        },
        companion.broken);
    motions.push_back(&reduced[i]);
  }
  record(work, at_rest(solution), motions, 1.0, table);
  report_comparisons(work);
  write_table(work, table);
}

// System, load and motion of a reduced model.
struct Follower {
  SecondOrderSystem system;
  LoadHistory load;
  Motion motion;
};

Follower make_follower(const Work& work, const ReducedBody& body) {
  Follower follower;
  follower.system = make_system(body.model, work.solving());
  follower.load = [&work, &body](double time, double step) -> Vector {
    return body.basis.transpose() * work.loads.mean(time, step);
  };
  const Vector zero = Vector::Zero(follower.system.size);
  follower.motion = start_motion(follower.system, zero, zero);
  return follower;
}

// The energy may not exceed ten times the work put in so far; `tremolo run` has the same bound.
void require_bounded(const Motion& motion, double& most_input) {
  constexpr double kBound = 10.0;
  most_input = std::max(most_input, motion.work);
  const bool finite = std::isfinite(motion.total());
  if (finite && (most_input <= 0 || motion.total() <= kBound * most_input)) return;
  throw Failure({ErrorKind::kBound,
                 finite ? text("at t = %.6g s the energy, %.3g J, is more than %g times all that "
                               "the load put in",
                               motion.time, motion.total(), kBound)
                        : text("at t = %.6g s the energy is not a number", motion.time)});
}

struct Course {
  Motion motion;
  std::vector<Follower> followers;
  DriftMeter drift;
  ReferenceTable table;
  double seconds = 0;  // time of the full body's steps, s
};

void move(Work& work, const SecondOrderSystem& system, std::int64_t steps, Course& course) {
  const ReferenceOptions& options = work.options;
  const LoadHistory load = [&](double t, double h) { return work.loads.mean(t, h); };
  const Clock::time_point start = Clock::now();
  Motion& motion = course.motion;
  std::vector<const Motion*> reduced;
  for (const Follower& follower : course.followers) reduced.push_back(&follower.motion);
  double last_report = 0, most_input = 0;  // seconds; J
  for (;;) {
    course.drift.observe(motion.total(), motion.work, motion.dissipated,
                         work.loads.to_come(motion.time, options.time.step));
    if (motion.steps % options.every == 0 || motion.steps == steps)
      record(work, motion, reduced, work.loads.share_at(motion.time, options.time.step),
             course.table);
    if (motion.steps == steps) break;
    const Clock::time_point begin = Clock::now();
    advance(system, options.time, load, motion);
    course.seconds += seconds_since(begin);
    require_bounded(motion, most_input);
    for (std::size_t i = 0; i < course.followers.size(); ++i) {
      Companion& companion = work.companions[i];
      Follower& follower = course.followers[i];
      if (companion.broken) continue;
      companion.seconds +=
          attempt([&] { advance(follower.system, options.time, follower.load, follower.motion); },
                  companion.broken);
    }
    if (seconds_since(start) < last_report + 5.0) continue;
    last_report = seconds_since(start);
    print_progress(motion, steps, last_report);
  }
  print_progress(motion, steps, seconds_since(start));
}

void run_motion(Work& work) {
  const ReferenceOptions& options = work.options;
  const SecondOrderSystem system = make_system(work.solver);
  const double step = options.time.step;
  const Vector zero = Vector::Zero(system.size);
  Course course{
      start_motion(system, zero, zero), {}, {}, begin_table(work.probes, work.companions.size())};
  for (const Companion& companion : work.companions)
    course.followers.push_back(make_follower(work, companion.body));
  try {
    move(work, system, std::llround(options.duration / step), course);
  } catch (const Failure& failure) {
    work.broken = failure;
  }
  const Motion& motion = course.motion;
  work.json["integrator"] = options.time.scheme == TimeScheme::kMidpoint ? "midpoint" : "avf";
  work.json["step"] = step;
  work.json["duration"] = options.duration;
  report_motion(motion, course.drift, course.seconds, work.json);
  work.json["probes"] = probe_json(work.probes, expand(work.body.unknowns, motion.u));
  report_comparisons(work);
  write_table(work, course.table);
}

}  // namespace

void run_reference(const ReferenceOptions& options) {
  check_reference(options);
  StageLog log(mpi_rank() != 0);
  log.begin("mesh");
  for (const std::string& text : options.probes) unwrap(parse_selector(text));
  const Problem problem = load_problem(options.solid);
  const std::vector<VertexId> probes = probe_vertices(options, problem.mesh);
  log.end(text("%zu vertices, %zu tetrahedra, %zu fixed vertices", problem.mesh.vertices.size(),
               problem.mesh.tetrahedra.size(), problem.fixed.size()));
  for (const std::string& note : problem.notes) log.note(note);
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!problem.held[axis].empty())
      log.note(text("%zu vertices are held along %c", problem.held[axis].size(),
                    static_cast<char>('x' + axis)));
  const Locking locking = find_locking(problem);
  for (const std::string& note : describe(locking)) log.note(note);
  require_output(options);

  log.begin("matrices");
  const FullOrder body =
      make_full_order(problem, options.solid.elements.mass, options.solid.threads);
  log.end(text("%d dofs, %.6g kg", static_cast<int>(body.size()), total_mass(body.solid)));
  if (problem.free_body)
    log.note(
        "a free body: its rigid motion is left out, and so is the share of the load that would set "
        "it in motion");

  constexpr Eigen::Index kSmall = 50'000;  // dofs; as in the precompute
  const BlasThreads blas(body.size() < kSmall ? 1 : static_cast<int>(options.solid.threads));
  FullOrderSolver solver;
  solver.body = &body;
  solver.options = {options.tolerance, options.max_iterations};
  Work work{options,
            body,
            solver,
            make_body_loads(options, problem, body),
            probes,
            probes.empty() ? problem.load.vertices : probes,
            load_companions(options, problem, body),
            {}};
  work.json["mesh"] = options.solid.files.mesh;
  work.json["n"] = problem.mesh.vertices.size();
  work.json["m"] = problem.mesh.tetrahedra.size();
  work.json["order"] = problem.order;
  work.json["dofs"] = body.size();
  work.json["locking"] = to_json(locking);
  find_responses(work);
  if (options.statics)
    run_statics(work);
  else
    run_motion(work);
  work.json["exit_code"] = work.broken ? exit_code(work.broken->error()) : 0;
  work.json["reason"] = work.broken ? Json(work.broken->error().message) : Json(nullptr);
  if (options.json) print_json(work.json);
  unwrap(flush_standard_output());
  if (work.broken) throw Failure(*work.broken);
}

}  // namespace tremolo
