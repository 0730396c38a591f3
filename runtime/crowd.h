// Thousands of bodies that share a few models: they step in lanes and on several threads, sleep
// while nothing acts on them, and are drawn only where they moved.
//
// A group is a model, a method, a step and a level of detail; each body belongs to one. Bodies of
// the default method `ep4`, of `ep2`, `avf`, `verlet` and `imexv-linear` step in lanes
// (runtime/bodies/lanes/lane_group.h), those of other methods one by one (runtime/body.h). The
// first three cannot explode. The last two are ten times faster, but stable only while the step
// resolves the stiffening by deformation: their files (runtime/bodies/reduced/integrators/) give
// the limit; use them for motion that you know. With stiffness damping, on a model that is not
// linear, all bodies step one by one; so do those of the first three on a linear model.
//
// The motion of a body depends on its own state and forces only: not on the other bodies, the
// number of threads, or the steps in which others were added, slept or woke, bit for bit.
//
// Sleep. A new body is at rest in the rest shape and sleeps. A force, set_state() or wake() wakes
// it. It falls asleep when its energy T + V has been at or below a threshold for some time and no
// force acts on it. Its q and p are then frozen: the remaining energy is neither shown as motion
// nor lost, and when the body wakes it continues from there. No step visits a sleeping body: it
// costs memory and no time. Its time does not advance. It misses no signal, because forces in a
// Crowd are given for a number of steps.
//
// Failure. A step fails if it gives a number that is not finite, its solve gives up, or a check
// finds an energy far above the energy put in (runtime/energy_bound.h: its method has exploded).
// The body is then returned to a valid state, its forces are dropped, it sleeps, and the report
// names it. The valid state is the one that was set or, since then, the last one found by a check;
// a body that steps by itself returns at most to the state before the failed step if that is valid.
// When it is woken it continues from there.
//
// Not thread-safe: one call at a time. step() and update_surfaces() use the crowd's own threads and
// allocate nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/body.h"
#include "runtime/model.h"

namespace tremolo {

using GroupId = std::uint32_t;
using BodyId = std::uint32_t;

// Conditions for sleep. Energies are checked every kStepsBetweenLooks steps.
struct SleepOptions {
  // Sets the threshold where energy is 0, dimensionless: the energy with which the model's first
  // mode moves the surface vertex that it moves most by this fraction of the solid's largest
  // extent. The remaining motion is then invisible; ten times the value shows as a jolt when a body
  // stops.
  double displacement = 1e-4;
  double energy = 0.0;  // the threshold, J; 0: it follows from displacement
  double time = 0.5;    // time below the threshold, s; infinity: the body never sleeps
};

// Precision of grad (C + Q) in lanes.
enum class LanePrecision { kDouble, kFloat };

// Options of a group.
struct GroupOptions {
  std::string_view integrator = kDefaultIntegrator;  // as for make_integrator
  IntegratorOptions options = {};
  // Level of detail: number of leading coordinates that move, 0 for all of the model's. Fewer than
  // all are only for verlet and imexv-linear (for others load the model with fewer).
  int modes = 0;
  // Of grad (C + Q) and its tangent in lanes; other methods use double. In float the methods that
  // preserve energy keep it to float rounding.
  LanePrecision precision = LanePrecision::kDouble;
  SleepOptions sleep = {};
};

// Report of the last step. The spans are valid until the next step.
struct CrowdReport {
  std::size_t stepped = 0;
  std::size_t fell_asleep = 0;  // by themselves
  // Returned to a valid state and asleep; the order may change between versions.
  std::span<const BodyId> failed;
  std::span<const StepFailure> why;  // reason for each of these
};

// The surface of a shown body.
struct SurfaceView {
  // x y z x y z ..., m, same as Body::surface; valid until the crowd's next non-const
  // call.
  std::span<const float> positions;
  std::uint64_t version = 0;  // grows with every rebuild; 0 before the first
};

class Crowd {
 public:
  // threads: number of threads in step(), the caller's included; 0: one for each core. Error
  // kSystem: the threads cannot be started.
  static Result<Crowd> create(unsigned threads = 1);
  Crowd(Crowd&&) noexcept;
  Crowd& operator=(Crowd&&) noexcept;
  ~Crowd();

  // Errors: as make_integrator; kUsage for a number of modes or sleep options out of range.
  Result<GroupId> add_group(Model::Pointer model, const GroupOptions& options);

  // A body at rest, asleep. kUsage: no such group.
  Result<BodyId> add_body(GroupId group);

  // Moves the body to another group of the same model: a level of detail, a method. Coordinates
  // that the new group lacks are dropped with their energy; additional ones start at zero. Forces
  // that still act end. Error kUsage: the models differ.
  Status move_body(BodyId body, GroupId group);

  // Hides the body and removes it: its number is not used again, calls with it are kUsage.
  Status remove_body(BodyId body);

  // A force (N) at a vertex, constant over the next `steps` steps of the body. Several add up.
  // Wakes it. Errors as Body::apply_force.
  Status apply_force(BodyId body, VertexId vertex, const Eigen::Vector3d& force, int steps = 1);
  Status clear_forces(BodyId body);  // those that still act; it stays awake

  // q and p: the group's number of modes long, finite; else kUsage. Wakes the body.
  Status set_state(BodyId body, const Eigen::VectorXd& q, const Eigen::VectorXd& p);

  Status wake(BodyId body);
  Status sleep(BodyId body);  // at once, at any energy; forces that still act end

  // One step of every body that is awake, each by its group's step.
  const CrowdReport& step();
  // The same for one group; the other groups do not move. Error kUsage: no such group.
  Result<CrowdReport> step(GroupId group);

  std::size_t awake() const;  // bodies
  Result<bool> is_awake(BodyId body) const;
  Result<State> state(BodyId body) const;  // as long as the group's number of modes
  // V from the whole potential in double. high_band is that of the group's split.
  Result<Energy> energy(BodyId body) const;

  // A shown body has a buffer for its surface. Hiding frees it.
  Status set_shown(BodyId body, bool shown);
  // Rebuilds the surfaces of the shown bodies that have moved since the last rebuild. Returns their
  // number.
  std::size_t update_surfaces();
  Result<SurfaceView> surface(BodyId body) const;  // kUsage if it is not shown

 private:
  struct Contents;
  explicit Crowd(std::unique_ptr<Contents> contents);
  std::unique_ptr<Contents> contents_;
};

}  // namespace tremolo
