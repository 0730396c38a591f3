// A body: a model, where it is, how it moves, and what pushes it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/display/surface.h"
#include "runtime/energy.h"
#include "runtime/energy_bound.h"
#include "runtime/integrator.h"
#include "runtime/load.h"
#include "runtime/model.h"

namespace tremolo {

// kUsage unless q and p have `modes` finite entries each.
Status check_state(Eigen::Index modes, const Eigen::VectorXd& q, const Eigen::VectorXd& p);

// Energies are looked at every so many steps: a look costs at most a force.
inline constexpr int kStepsBetweenLooks = 8;

// Starts at rest in the rest shape at time 0. Not thread-safe; different bodies of one model may
// step on different threads.
class Body {
 public:
  // Errors as make_integrator.
  static Result<Body> create(Model::Pointer model, std::string_view integrator = kDefaultIntegrator,
                             const IntegratorOptions& options = {});

  const Model& model() const { return *model_; }
  const Model::Pointer& model_pointer() const { return model_; }
  const Integrator& integrator() const { return *integrator_; }
  const State& state() const { return state_; }
  double step_size() const { return options_.step; }                           // s
  std::int64_t steps() const { return steps_; }                                // done so far
  double time() const { return static_cast<double>(steps_) * options_.step; }  // s

  // Sets q and p (each r long, finite); what the integrator carried is forgotten, time goes on.
  // kUsage otherwise, and nothing is changed.
  Status set_state(const Eigen::VectorXd& q, const Eigen::VectorXd& p);

  // Adds a load in time; its signal's clock is time().
  Status add_load(const Load& load);  // kUsage if its force is not r long and finite
  Status add_load(const Signal& signal, VertexId vertex, const Eigen::Vector3d& force);  // N
  // The model's default load, times scale. kUsage if the model has none.
  Status add_default_load(const Signal& signal, double scale = 1.0);
  void clear_loads();

  // A force (N) at a vertex, constant over the next `steps` steps. Several add up. Errors as
  // reduce_force.
  Status apply_force(VertexId vertex, const Eigen::Vector3d& force, int steps = 1);
  void clear_forces();  // those of apply_force() that still act

  // One step. If the report says not converged, the time and the pending loads are as before, and
  // so is the state if its energy is sound. If it is not, because the method has exploded, or if
  // this step's is far out (StepFailure::kEnergy), the state, work() and dissipated() are those of
  // the last sound look, and what the integrator carried is forgotten. Looks are at the start, when
  // a state is set and every kStepsBetweenLooks steps; what is sound says runtime/energy_bound.h.
  // Nothing is allocated.
  StepReport step();
  const EnergyBound& energy_bound() const { return bound_; }

  // True if a load can still act on a step to come.
  bool load_to_come() const;

  // Since the start, J: work of the loads, average . (q1 - q0) a step plus what the method adds to
  // it (exact for midpoint-type and energy-preserving methods, second order for the others), and
  // what damping took.
  double work() const { return work_; }
  double dissipated() const { return dissipated_; }
  std::int64_t iterations() const { return iterations_; }      // of all steps
  std::int64_t halved_steps() const { return halved_steps_; }  // steps that were taken in parts

  // Evaluates V. The high band is that of the integrator's split, or, for a method that does not
  // split, of the one that options.split would give.
  Energy energy() const { return energy(low_); }
  // The same with the high band from coordinate `low` on, 0 <= low <= r.
  Energy energy(Eigen::Index low) const;

  // U_vertex q, m. Errors as Model::vertex.
  Result<Eigen::Vector3d> displacement(VertexId vertex) const;

  // X + U q of the drawn surface's vertices, x y z x y z ..., m. out: 3 *
  // model().drawn().rest.size() long, else kUsage. The double variant allocates nothing. The float
  // variant reads rows that the model makes for it when they are first asked for
  // (runtime/display/surface.h, where its error is told), and allocates nothing after that.
  Status surface_positions(std::span<double> out) const;
  Status surface_positions(std::span<float> out) const;
  // Those of the solid's boundary, whatever is drawn: 3 * model().surface().rest.size() long.
  Status boundary_positions(std::span<double> out) const;

  // The same with the unit normals of its vertices, each triangle counting with its area: zero
  // where a vertex's triangles have none. Both 3 * model().drawn().rest.size() long, else kUsage.
  // Nothing is allocated after a body's first call.
  Status surface(std::span<float> positions, std::span<float> normals) const;

 private:
  struct AppliedForce {
    Eigen::VectorXd force;
    int steps = 0;
  };

  Body(Model::Pointer model, std::unique_ptr<Integrator> integrator,
       const IntegratorOptions& options, Eigen::Index low);
  void gather_loads();
  void age_applied_forces();
  double kick() const;
  double total_energy() const;
  double harmonic_energy() const;
  bool look();
  void keep_sound_state();
  void put_back();
  StepReport explain(StepReport report);

  Model::Pointer model_;
  std::unique_ptr<Integrator> integrator_;
  IntegratorOptions options_;
  Eigen::Index low_;  // where the high band begins
  State state_;
  std::vector<Load> loads_;
  std::vector<AppliedForce> applied_;
  StepLoad step_load_;
  Eigen::VectorXd q_before_;
  std::int64_t steps_ = 0;
  std::int64_t iterations_ = 0;
  std::int64_t halved_steps_ = 0;
  double work_ = 0.0;
  double dissipated_ = 0.0;
  EnergyBound bound_;
  int steps_since_look_ = 0;
  State sound_;  // at the last sound look; work and dissipation then
  double sound_work_ = 0.0;
  double sound_dissipated_ = 0.0;
  mutable PotentialWorkspace workspace_;
  mutable Evaluation evaluation_;
  mutable Eigen::VectorXd momentum_;
  mutable SurfaceWorkspace surface_;
};

// kBound for kEnergy, else kSolver.
ErrorKind error_kind(StepFailure failure);

// Why the step from `time` (s) was not made, a sentence without a full stop.
std::string why_not_made(const StepReport& report, double time);

}  // namespace tremolo
