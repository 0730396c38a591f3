// Thousands of bodies that share a few models: stepped in lanes and on several threads, asleep when
// nothing happens to them, drawn only where they moved.
//
// A group is a model, a method, a step and a level of detail; bodies belong to one. The default
// method, `ep4`, cannot explode: its bodies step each by itself (runtime/body.h), as those of all
// methods but two. Bodies of `verlet` and `imexv-linear` step in lanes
// (runtime/crowd/lane_group.h), in a fortieth of the time and less, but are stable only while the
// step resolves what deformation stiffens: the limit is told in their files (runtime/integrators/),
// take them for motion that you know. What a body does depends on nothing but its own state and
// forces: not on the other bodies, the number of threads, or when others were added, slept or woke,
// bit for bit.
//
// Sleep. A new body is at rest in the rest shape and sleeps. It wakes by a force, set_state() or
// wake(), and falls asleep when its energy T + V has stayed at or below a threshold for a while and
// no force acts on it. Its q and p are then frozen: what energy is left stays in it, neither shown
// as motion nor lost, and when the body wakes it moves on from there. A sleeping body is in no list
// that a step goes through; it costs memory and no time. Time does not pass for it: there is no
// signal in a World that it could miss, forces are given for so many steps.
//
// Failure. A body whose step gave a number that is not finite, whose solve gave up, or whose energy
// a look found out of all proportion to what was put in (runtime/energy_bound.h: its method has
// exploded) is put back to a sound state, its forces are dropped, it is put to sleep and named in
// the report. Sound is the state that was set or, since then, the last that a look found so; a body
// that steps by itself goes back no further than before the step that failed where that is sound.
// When it is woken it tries again from there.
//
// Not thread-safe: one call at a time. step() and update_surfaces() use the world's own threads and
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

// energy: the threshold, J; 0 means the energy with which the model's first mode moves the surface
// vertex that it moves most by `displacement` of the solid's largest extent: what is left moves no
// vertex visibly. displacement: dimensionless; ten times it shows as a jolt when a body stops.
// time: s, how long the energy must stay there; infinity: never asleep. Energies are looked at
// every kStepsBetweenLooks steps.
struct SleepOptions {
  double displacement = 1e-4;
  double energy = 0.0;
  double time = 0.5;
};

// Precision of grad (C + Q) in lanes.
enum class LanePrecision { kDouble, kFloat };

// integrator, options: as make_integrator. modes: level of detail, leading coordinates that move, 0
// for all of the model's; less than all only for methods in lanes (for others load the model with
// fewer). precision: of grad (C + Q) in lanes; other methods are in double.
struct GroupOptions {
  std::string_view integrator = kDefaultIntegrator;
  IntegratorOptions options = {};
  int modes = 0;
  LanePrecision precision = LanePrecision::kDouble;
  SleepOptions sleep = {};
};

// Report of the last step. failed: bodies that were put back and to sleep, in no order to rely on
// across versions. why: of each of these. Both are valid until the next step.
struct WorldReport {
  std::size_t stepped = 0;
  std::size_t fell_asleep = 0;  // by themselves
  std::span<const BodyId> failed;
  std::span<const StepFailure> why;
};

// positions: x y z x y z ..., m, as Body::surface_positions; valid until the world's next call that
// is not const. version: grows with every rebuild, 0 before the first.
struct SurfaceView {
  std::span<const float> positions;
  std::uint64_t version = 0;
};

class World {
 public:
  // threads: how many work in step(), the caller's included; 0: one a core. kSystem if the threads
  // cannot be had.
  static Result<World> create(unsigned threads = 1);
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;
  ~World();

  // Errors: as make_integrator; kUsage for a number of modes or sleep options out of range.
  Result<GroupId> add_group(Model::Pointer model, const GroupOptions& options);

  // A body at rest, asleep. kUsage: no such group.
  Result<BodyId> add_body(GroupId group);

  // Takes the body to another group of the same model: a level of detail, a method. Coordinates
  // that the new group has not are dropped with their energy, those that it has more start at zero.
  // Forces that still act end. kUsage if the models differ.
  Status move_body(BodyId body, GroupId group);

  // Hidden, asleep and gone: its number is not used again, calls with it are kUsage.
  Status remove_body(BodyId body);

  // A force (N) at a vertex, constant over the next `steps` steps of the body. Several add up.
  // Wakes it. Errors as Body::apply_force.
  Status apply_force(BodyId body, VertexId vertex, const Eigen::Vector3d& force, int steps = 1);
  Status clear_forces(BodyId body);  // those that still act; it stays awake

  // q and p: the group's number of modes long, finite; else kUsage. Wakes the body.
  Status set_state(BodyId body, const Eigen::VectorXd& q, const Eigen::VectorXd& p);

  Status wake(BodyId body);
  Status sleep(BodyId body);  // at once, whatever its energy; forces that still act end

  // One step of every body that is awake, each by its group's step.
  const WorldReport& step();
  // The same for one group; others stand still. kUsage: no such group.
  Result<WorldReport> step(GroupId group);

  std::size_t awake() const;  // bodies
  Result<bool> is_awake(BodyId body) const;
  Result<State> state(BodyId body) const;  // as long as the group's number of modes
  // V from the whole potential in double. high_band is that of the group's split.
  Result<Energy> energy(BodyId body) const;

  // A shown body has a buffer for its surface. Hiding frees it.
  Status set_shown(BodyId body, bool shown);
  // Rebuilds the surfaces of the bodies that are shown and have moved since theirs was. Returns how
  // many.
  std::size_t update_surfaces();
  Result<SurfaceView> surface(BodyId body) const;  // kUsage if it is not shown

 private:
  struct Contents;
  explicit World(std::unique_ptr<Contents> contents);
  std::unique_ptr<Contents> contents_;
};

}  // namespace tremolo
