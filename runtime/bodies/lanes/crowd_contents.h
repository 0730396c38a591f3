// The members of a Crowd; internal to runtime/bodies/lanes/.
#pragma once

#include <optional>
#include <string>

#include "runtime/bodies/lanes/lane_group.h"
#include "runtime/bodies/reduced/surface/surface.h"
#include "runtime/crowd.h"
#include "runtime/math/kernels/lanes.h"
#include "runtime/math/thread_pool.h"

namespace tremolo {

inline constexpr std::size_t kAsleep = static_cast<std::size_t>(-1);

// A force that still acts on a body in lanes.
struct WorldForce {
  BodyId body = 0;
  int steps = 0;
  Eigen::VectorXd force;  // reduced
};

// A body of the crowd.
struct CrowdBody {
  GroupId group = 0;
  std::size_t index = 0;       // of its saved state or its Body in the group
  std::size_t slot = kAsleep;  // in the group's list of awake bodies, or kAsleep
  int forces = 0;              // WorldForces that still act
  bool alive = true;
  bool shown = false;
  bool dirty = false;         // it has moved since its surface was built, other than by being awake
  std::int64_t built_at = 0;  // the group's steps at that time
  std::uint64_t version = 0;  // of the surface
  AlignedFloats surface;      // whole blocks
};

// Either `lanes` and `saved_states`, or `bodies`.
struct CrowdGroup {
  Model::Pointer model;
  std::string integrator;
  IntegratorOptions options;
  std::size_t modes = 0;
  Eigen::Index low = 0;     // where the high band begins
  double threshold = 0.0;   // J
  double quiet_time = 0.0;  // s
  std::int64_t steps = 0;

  std::optional<LaneGroup> lanes;
  std::vector<double> saved_states;  // of LaneGroup::save while a body sleeps, 4 x modes per index
  std::vector<EnergyBound> saved_bounds;     // one per index
  std::vector<LaneGroup::Outcome> outcomes;  // one per block, of the last step
  std::vector<WorldForce> forces;

  std::vector<std::unique_ptr<Body>> bodies;
  std::vector<double> quiet;        // s, one per index
  std::vector<StepFailure> failed;  // one per slot, of the last step

  std::size_t indices = 0;  // used and free
  std::vector<std::size_t> free_indices;
  std::vector<BodyId> awake;  // by slot

  std::size_t shown = 0;
  std::vector<BodyId> dirty;  // of the shown bodies, see CrowdBody

  double* saved_state(const CrowdBody& body) {
    return saved_states.data() + 4 * modes * body.index;
  }
  std::size_t tasks() const { return lanes ? lanes->blocks() : awake.size(); }
  // Steps since the last check of energies if the next step is followed by a check, else 0.
  int look() const { return (steps + 1) % kStepsBetweenLooks == 0 ? kStepsBetweenLooks : 0; }
};

// Shown bodies of one group that are rebuilt together: dirty_bodies[first, first + count).
struct SurfaceBatch {
  GroupId group = 0;
  std::size_t first = 0;
  std::size_t count = 0;
};

// Buffers of one thread.
struct CrowdScratch {
  LaneScratch lanes;
  std::vector<double> q, p;    // the largest number of modes
  std::vector<float> q_float;  // kSurfaceBodies of them
};

struct Crowd::Contents {
  std::unique_ptr<ThreadPool> pool;
  std::vector<CrowdScratch> scratch;  // one per thread
  std::vector<CrowdGroup> groups;
  std::vector<CrowdBody> bodies;
  std::vector<BodyId> failed;
  std::vector<StepFailure> failures;  // of those
  CrowdReport report;
  std::vector<std::size_t> task_ends;  // one per group
  std::vector<BodyId> dirty_bodies;
  std::vector<SurfaceBatch> batches;

  Status check_body(BodyId body) const;
  Status check_group(GroupId group) const;
  void read_state(const CrowdBody& body, double* q, double* p) const;
  void write_state(BodyId id, const double* q, const double* p);  // q, p: of the group's modes
  void wake(BodyId id);
  void sleep(BodyId id);
  void mark_dirty(BodyId id);  // its surface must be built again
  void show(BodyId id, bool shown);
  Status reserve_index(GroupId group);  // before join()
  void join(BodyId id, GroupId group);  // at rest, asleep
  void leave(BodyId id);                // removes it from its group; asleep and hidden

  // Steps the groups [first, end).
  void step(GroupId first, GroupId end);
  void add_forces(CrowdGroup& group);
  void run_task(CrowdGroup& group, std::size_t task, CrowdScratch& scratch);
  void finish(CrowdGroup& group);
  void finish_body(CrowdGroup& group, std::size_t slot, StepFailure failure, bool quiet);
  void clear_forces(BodyId id);

  void list_dirty();
  void build(const SurfaceBatch& batch, CrowdScratch& scratch);
};

}  // namespace tremolo
