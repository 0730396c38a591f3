// Waiting times of a user who holds a body: for the force on the hand, which a device requests a
// thousand times a second, and for the hit of a ray.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <optional>
#include <random>

#include <fmt/format.h>

#include "common/processor.h"
#include "runtime/contact/solve/contact_step.h"
#include "runtime/contact_body.h"
#include "tests/lab/speed/speed.h"
#include "tests/lab/work/failure.h"

namespace tremolo::bench {
namespace {

using Eigen::Vector3d;

constexpr double kHandStep = 1e-3;  // s
constexpr int kHandSteps = 100'000;
constexpr int kHandModes = 20;
constexpr double kMedianBound = 100.0;  // us
constexpr double kTailBound = 300.0;    // us, of 99.9 %

Eigen::AlignedBox3d box_of(const Model& model) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& x : model.surface().rest) box.extend(x);
  return box;
}

// The boundary's vertex that is highest.
VertexId highest(const Model& model) {
  const VertexBlock& surface = model.surface();
  const auto top = std::max_element(surface.rest.begin(), surface.rest.end(),
                                    [](const auto& a, const auto& b) { return a.z() < b.z(); });
  return surface.vertex_ids[top - surface.rest.begin()];
}

// A collider in contact with the body's lowest point.
PlacedCollider below(const Model& model, bool sphere) {
  const Eigen::AlignedBox3d box = box_of(model);
  PlacedCollider placed;
  Vector3d place(box.center().x(), box.center().y(), box.min().z());
  if (sphere) {
    const double radius = 0.3 * box.sizes().maxCoeff();
    placed.shape = SphereShape{radius};
    place.z() -= radius;
  }
  placed.start.position = placed.end.position = place;
  return placed;
}

struct HandRun {
  std::vector<double> times;  // us, ascending
  double touching = 0.0;      // fraction of the steps
  double largest = 0.0;       // N, of the force on the hand
};

// The hand goes round in a circle and up and down, so that the body is pressed on the collider,
// slides over it and leaves it.
HandRun run_hand(const Model::Pointer& model, FrameKind frame, const PlacedCollider& collider) {
  ContactBody body = or_fail(
      ContactBody::create(model, kDefaultIntegrator, {.step = kHandStep, .beta = 1e-3}, frame));
  or_fail(body.set_contact());
  or_fail(body.set_gravity({0.0, 0.0, -9.81}));
  const double size = box_of(*model).sizes().maxCoeff();
  const double weight = 9.81 * body.contact()->surface().mass;
  const VertexId vertex = highest(*model);
  const std::size_t hand = or_fail(body.grab(vertex, 100.0 * weight / size, weight / size));
  const Vector3d at = or_fail(body.position(vertex));
  body.reserve_contact(std::span(&collider, 1), 1);
  HandRun run;
  run.times.reserve(kHandSteps);
  int touching = 0;
  for (int k = 0; k < kHandSteps; ++k) {
    const double t = kHandStep * (k + 1);
    const double round = 2.0 * std::numbers::pi * 0.7 * t;
    const Vector3d way(std::sin(round), 1.0 - std::cos(round),
                       0.5 - 2.0 * std::sin(2.0 * std::numbers::pi * 1.1 * t));
    const double before = processor_time();
    or_fail(body.move_hand(hand, at + 0.03 * size * way));
    const StepReport report = body.step(std::span(&collider, 1));
    const double force = body.hand_force(hand).norm();
    run.times.push_back(1e6 * (processor_time() - before));
    if (!report.converged)
      throw Failure({ErrorKind::kSolver, failure_message(report, body.time())});
    if (body.contact_account().active > 0) ++touching;
    run.largest = std::max(run.largest, force);
  }
  std::sort(run.times.begin(), run.times.end());
  run.touching = static_cast<double>(touching) / kHandSteps;
  return run;
}

void add_hand(const Model::Pointer& model, FrameKind frame, bool sphere, SpeedSection& section) {
  const std::string what = fmt::format("force on the hand, {} on a {}, r = {}",
                                       frame == FrameKind::kFree ? "free heart" : "heart",
                                       sphere ? "sphere" : "plane", model->modes());
  const HandRun run = run_hand(model, frame, below(*model, sphere));
  const auto part = [&run](double share) {
    return run.times[static_cast<std::size_t>(share * (kHandSteps - 1))];
  };
  section.rows.push_back(
      {.what = what + ": median",
       .value = part(0.5),
       .note = fmt::format("touches in {:.0f} % of the steps", 100.0 * run.touching)});
  section.rows.push_back({.what = what + ": 99.9 %", .value = part(0.999), .note = {}});
  section.rows.push_back(
      {.what = what + ": slowest",
       .value = run.times.back(),
       .note = fmt::format("of {}; force to {:.3g} N", kHandSteps, run.largest)});
  for (Criterion criterion : {at_most(what + ", median, us", part(0.5), kMedianBound),
                              at_most(what + ", 99.9 %, us", part(0.999), kTailBound)}) {
    criterion.decides = false;
    section.criteria.push_back(std::move(criterion));
  }
}

// Rays from a ball around the solid to points in it, at a random bend of a tenth of its size;
// compared with testing each triangle.
void add_rays(const std::string& name, const Options& options, SpeedSection& section) {
  constexpr int kRays = 400;
  const Model::Pointer model =
      or_fail(Model::load(fmt::format("{}/{}.tremolo", options.models_dir, name)));
  ContactBody body = or_fail(ContactBody::create(model));
  const Eigen::AlignedBox3d box = box_of(*model);
  std::mt19937 engine(7);
  std::normal_distribution<double> normal;
  Eigen::VectorXd q = Eigen::VectorXd::NullaryExpr(model->modes(), [&] { return normal(engine); });
  q.array() /= model->lambda().array().sqrt();
  double most = 0.0;
  const Eigen::VectorXd u = model->surface().rows * q;
  for (Eigen::Index row = 0; row + 2 < u.size(); row += 3)
    most = std::max(most, u.segment<3>(row).norm());
  or_fail(body.set_state(0.1 * box.sizes().maxCoeff() / most * q, 0.0 * q));
  std::vector<Vector3d> from, along;
  const double before = processor_time();
  const SurfaceTree& tree = model->surface_tree(SurfaceKind::kDrawn);
  const double made = processor_time() - before;
  int hits = 0;
  for (int k = 0; k < kRays; ++k) {
    const Vector3d way = Vector3d(normal(engine), normal(engine), normal(engine)).normalized();
    from.push_back(box.center() + 2.0 * box.sizes().maxCoeff() * way);
    along.push_back((box.sample() - from.back()).normalized());
    hits += or_fail(body.pick(from.back(), along.back())).has_value() ? 1 : 0;
  }
  std::size_t ray = 0;
  const auto next = [&ray] { return ray = (ray + 1) % kRays; };
  const std::vector<double> seconds =
      by_turns({[&] {
                  const std::size_t k = next();
                  (void)body.pick(from[k], along[k]);
                },
                [&] {
                  const std::size_t k = next();
                  double nearest = std::numeric_limits<double>::infinity();
                  for (std::size_t t = 0; t < model->drawn().triangles.size(); ++t)
                    if (const auto hit = tree.meet(t, from[k], along[k], body.state().q, nearest))
                      nearest = hit->distance;
                }},
               kRays, 5);
  section.rows.push_back(microseconds(
      fmt::format("a ray on {}, {} triangles, r = {}", name, model->drawn().triangles.size(),
                  model->modes()),
      seconds[0], seconds[1],
      fmt::format("{} of {} hit; the tree takes {:.0f} ms once", hits, kRays, 1e3 * made)));
}

}  // namespace

SpeedSection measure_hand_speed(const Options& options, const MachineProbe&) {
  SpeedSection section;
  section.title = "A body in the hand";
  section.text = fmt::format(
      "The force on a hand that holds the first {} coordinates of the heart, presses them on a "
      "collider and slides over it: {} steps of {} ms, each timed by itself with the processor "
      "time of its thread, the force on the hand read in it. Free: nothing else holds the body. A "
      "ray on a surface that is bent by a tenth of its size, the mean of many from all sides; the "
      "textbook looks at each triangle.",
      kHandModes, kHandSteps, 1e3 * kHandStep);
  for (const auto& [name, frame] :
       {std::pair{"heart", FrameKind::kFixed}, {"heart-free", FrameKind::kFree}}) {
    const std::string path = fmt::format("{}/{}.tremolo", options.models_dir, name);
    if (frame == FrameKind::kFree && !std::filesystem::exists(path)) continue;
    const Model::Pointer model = or_fail(Model::load(path, {.modes = kHandModes}));
    for (const bool sphere : {false, true}) add_hand(model, frame, sphere, section);
  }
  for (const char* name : {"horse", "heart"}) add_rays(name, options, section);
  return section;
}

}  // namespace tremolo::bench
