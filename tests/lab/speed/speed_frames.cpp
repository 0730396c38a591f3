// The cost that a moving frame, free motion and contact add to a step.
#include <cmath>
#include <filesystem>
#include <numbers>

#include <fmt/format.h>

#include "runtime/contact/solve/contact_step.h"
#include "runtime/contact_body.h"
#include "tests/lab/speed/speed.h"
#include "tests/lab/work/failure.h"

namespace tremolo::bench {
namespace {

using Eigen::Vector3d;

constexpr double kStep = 3e-3;  // s
constexpr int kWindow = 200;    // steps, from the same state each time
constexpr int kWindows = 15;
constexpr int kPoints = 300, kTouching = 20;

// Every coordinate moves: its size at rest is that of equal energies, and the largest displacement
// of the boundary is 3 % of the size.
State moving_state(const Model& model) {
  State state;
  state.q = model.lambda().array().rsqrt();
  for (Eigen::Index i = 1; i < state.q.size(); i += 2) state.q[i] = -state.q[i];
  const Eigen::VectorXd u = model.surface().rows * state.q;
  Eigen::AlignedBox3d box;
  for (const Vector3d& x : model.surface().rest) box.extend(x);
  double most = 0.0;
  for (Eigen::Index row = 0; row + 2 < u.size(); row += 3)
    most = std::max(most, u.segment<3>(row).norm());
  state.q *= 0.03 * box.sizes().maxCoeff() / most;
  state.p = Eigen::VectorXd::Zero(state.q.size());
  return state;
}

void start(ContactBody& body, const State& state) {
  or_fail(body.set_state(state.q, state.p));
}

void step_once(ContactBody& body, std::span<const PlacedCollider> colliders = {}) {
  const StepReport report = body.step(colliders);
  if (!report.converged) throw Failure({ErrorKind::kSolver, failure_message(report, body.time())});
}

// Moves a support that shakes, and rotates by `spin` (rad/s); its motion is known with it.
void drive(ContactBody& body, double size, const Vector3d& spin) {
  const double t = body.time() + 0.5 * kStep, rate = 2.0 * std::numbers::pi * 2.0;
  const double far = 0.02 * size;
  FrameMotion motion;
  motion.acceleration = Vector3d(-far * rate * rate * std::sin(rate * t), 0.0, 0.0);
  motion.spin = spin;
  Pose pose;
  pose.position.x() = far * std::sin(rate * (t + 0.5 * kStep));
  pose.rotation = turn_by((t + 0.5 * kStep) * spin);
  or_fail(body.move_to(pose, motion));
}

std::string row_name(const std::string& model, const char* what, Eigen::Index modes) {
  return fmt::format("a step of {}, r = {}, {}", model, modes, what);
}

void add_row(const std::string& what, double seconds, double fixed, double bound,
             SpeedSection& section) {
  section.rows.push_back(microseconds(what, seconds, fixed));
  Criterion criterion = at_most(what + ", over the fixed one's", seconds / fixed, bound);
  criterion.decides = false;
  section.criteria.push_back(std::move(criterion));
}

// A fixed body alternately with a driven one whose frame moves, and moves and rotates.
void add_driven(const std::string& name, const Options& options, SpeedSection& section) {
  const Model::Pointer model =
      or_fail(Model::load(fmt::format("{}/{}.tremolo", options.models_dir, name)));
  const State state = moving_state(*model);
  Eigen::AlignedBox3d box;
  for (const Vector3d& x : model->surface().rest) box.extend(x);
  const double size = box.sizes().maxCoeff();
  ContactBody fixed = or_fail(ContactBody::create(model, "ep4", {.step = kStep}));
  ContactBody moved =
      or_fail(ContactBody::create(model, "ep4", {.step = kStep}, FrameKind::kDriven));
  ContactBody turned =
      or_fail(ContactBody::create(model, "ep4", {.step = kStep}, FrameKind::kDriven));
  const Vector3d none = Vector3d::Zero(), spin(0.6, 0.4, 2.0);
  const auto run_driven = [&](ContactBody& body, const Vector3d& about) {
    start(body, state);
    for (int k = 0; k < kWindow; ++k) {
      drive(body, size, about);
      step_once(body);
    }
  };
  const std::vector<double> seconds =
      by_turns({[&] {
                  start(fixed, state);
                  for (int k = 0; k < kWindow; ++k) step_once(fixed);
                },
                [&] { run_driven(moved, none); }, [&] { run_driven(turned, spin); }},
               1, kWindows);
  const double each = 1.0 / kWindow;
  const Eigen::Index r = model->modes();
  section.rows.push_back(microseconds(row_name(name, "fixed", r), each * seconds[0]));
  add_row(row_name(name, "driven: its frame shakes", r), each * seconds[1], each * seconds[0], 1.15,
          section);
  add_row(row_name(name, "driven: its frame shakes and turns", r), each * seconds[2],
          each * seconds[0], 1.15, section);
}

// The same basis free, tumbling, and with a fixed frame.
void add_free(const std::string& name, const Options& options, SpeedSection& section) {
  const std::string path = fmt::format("{}/{}.tremolo", options.models_dir, name);
  if (!std::filesystem::exists(path)) return;
  const Model::Pointer model = or_fail(Model::load(path));
  const State state = moving_state(*model);
  ContactBody fixed = or_fail(ContactBody::create(model, "ep4", {.step = kStep}));
  ContactBody free = or_fail(ContactBody::create(model, "ep4", {.step = kStep}, FrameKind::kFree));
  const auto run = [&](ContactBody& body) {
    start(body, state);
    if (body.frame() == FrameKind::kFree)
      or_fail(body.set_motion({0.1, 0.2, 0.3}, {2.0, 1.0, 3.0}));
    for (int k = 0; k < kWindow; ++k) step_once(body);
  };
  const std::vector<double> seconds =
      by_turns({[&] { run(fixed); }, [&] { run(free); }}, 1, kWindows);
  const double each = 1.0 / kWindow;
  const Eigen::Index r = model->modes();
  section.rows.push_back(microseconds(row_name(name, "as if it were fixed", r), each * seconds[0]));
  add_row(row_name(name, "free, tumbling", r), each * seconds[1], each * seconds[0], 1.5, section);
}

constexpr double kCalm = 2e-2;  // beta of a body that comes to rest soon, s

// A new body with that damping, s, that has come to rest on the plane, which rose to its place from
// `below`, m: a body that begins in a plane is not pushed out of it.
template <class Make>
ContactBody settled(const Make& make, double beta, const PlacedCollider& plane, double below) {
  constexpr int kRise = 200, kRest = 200;
  ContactBody body = make(true, beta);
  PlacedCollider now = plane;
  const double way = plane.start.position.z() - below;
  for (int k = 0; k < kRise + kRest; ++k) {
    now.start.position.z() = below + way * std::min(k, kRise) / kRise;
    now.end.position.z() = below + way * std::min(k + 1, kRise) / kRise;
    step_once(body, std::span(&now, 1));
  }
  return body;
}

// A plane that holds the body at rest at about kTouching of its points, found by bisection.
template <class Make>
PlacedCollider plane_below(const Eigen::AlignedBox3d& box, const Make& make) {
  PlacedCollider plane;
  plane.friction = 0.3;
  const double below = box.min().z() - 0.1 * box.sizes().z();
  double low = below, high = box.min().z() + 0.05 * box.sizes().z();
  for (int k = 0; k < 20; ++k) {
    const double middle = 0.5 * (low + high);
    plane.start.position.z() = plane.end.position.z() = middle;
    (settled(make, kCalm, plane, below).contact_account().active < kTouching ? low : high) = middle;
  }
  plane.start.position.z() = plane.end.position.z() = high;
  return plane;
}

// A body that rests on a plane which rises and sinks a little, compared with the same that is in
// contact with nothing.
void add_contact(const std::string& name, const Options& options, SpeedSection& section) {
  const Model::Pointer model =
      or_fail(Model::load(fmt::format("{}/{}.tremolo", options.models_dir, name)));
  const auto make = [&](bool contact, double beta) {
    ContactBody body = or_fail(ContactBody::create(model, "ep4", {.step = kStep, .beta = beta}));
    if (contact) or_fail(body.set_contact({.points = kPoints}));
    return body;
  };
  Eigen::AlignedBox3d box;
  for (const Vector3d& x : model->surface().rest) box.extend(x);
  const PlacedCollider near = plane_below(box, make);
  ContactBody alone = make(false, 1e-3), away = make(true, 1e-3);
  // A state in contact has its memories: the body continues from window to window.
  ContactBody touching = settled(make, 1e-3, near, box.min().z() - 0.1 * box.sizes().z());
  const State state = touching.state();
  const double depth = ContactOptions{}.margin * box.sizes().maxCoeff();
  double active = 0.0;
  // lower: m, of the plane.
  const auto run = [&](ContactBody& body, double lower) {
    active = 0.0;
    PlacedCollider plane = near;
    const double at = near.start.position.z() - lower;
    for (int k = 0; k < kWindow; ++k) {
      plane.start.position.z() = at + 0.2 * depth * std::sin(0.1 * k);
      plane.end.position.z() = at + 0.2 * depth * std::sin(0.1 * (k + 1));
      step_once(body, std::span(&plane, 1));
      active += body.contact_account().active;
    }
    active /= kWindow;
  };
  const std::vector<double> seconds = by_turns({[&] {
                                                  start(alone, state);
                                                  for (int k = 0; k < kWindow; ++k)
                                                    step_once(alone);
                                                },
                                                [&] {
                                                  start(away, state);
                                                  run(away, 100.0);
                                                },
                                                [&] { run(touching, 0.0); }},
                                               1, kWindows);
  const double each = 1.0 / kWindow;
  const Eigen::Index r = model->modes();
  section.rows.push_back(microseconds(row_name(name, "alone", r), each * seconds[0]));
  section.rows.push_back(microseconds(row_name(name, "a plane far away", r), each * seconds[1],
                                      each * seconds[0], fmt::format("{} points", kPoints)));
  const std::string what = row_name(name, "on a plane", r);
  section.rows.push_back(microseconds(what, each * seconds[2], each * seconds[0],
                                      fmt::format("{:.1f} of {} points push", active, kPoints)));
  Criterion criterion =
      at_most(what + ", more than alone, us", 1e6 * each * (seconds[2] - seconds[0]), 15.0);
  criterion.decides = false;
  section.criteria.push_back(std::move(criterion));
}

}  // namespace

SpeedSection measure_frames_speed(const Options& options, const MachineProbe&) {
  SpeedSection section;
  section.title = "Bodies in a world";
  section.text = fmt::format(
      "Steps of `ep4` of {:g} ms, {} from the same bent state, by turns; the baseline is the same "
      "basis with its frame bolted to the world. Contact: a body at rest on a plane that rises and "
      "sinks a little, held at about {} of {} points.",
      1e3 * kStep, kWindow, kTouching, kPoints);
  for (const char* name : {"basket", "tower"}) add_driven(name, options, section);
  for (const char* name : {"basket-free", "heart-free"}) add_free(name, options, section);
  for (const char* name : {"basket", "tower"}) add_contact(name, options, section);
  return section;
}

}  // namespace tremolo::bench
