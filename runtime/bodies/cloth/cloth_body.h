// A cloth as one body of a world with bodies of other kinds: its particles, its method and its
// energy balance. Its contact is in runtime/mixed/cloth_step.h.
#pragma once

#include <cstdint>
#include <memory>

#include <Eigen/Core>

#include "common/overflow.h"
#include "common/result.h"
#include "common/state_stream.h"
#include "runtime/bodies/cloth/cloth_model.h"
#include "runtime/bodies/cloth/cloth_scene.h"
#include "runtime/math/state.h"

namespace tremolo {

// The model of a cloth of a scene, with its pins. Errors: those of make_cloth_parts() and
// ClothModel::create(); kContent for a pin of a vertex that does not exist.
Result<ClothModel> make_cloth_model(const SceneCloth& cloth);

// Wind of a scene at a time, m/s.
Eigen::Vector3d wind_at(const ClothScene& scene, double time);

// Sizes of a cloth in a state, for check_scale(). step: s.
BodyScale scale_of(const SceneCloth& cloth, const ClothModel& model, const NodalState& state,
                   double step);

// Work on a cloth and its losses since the start, J.
struct ClothWork {
  double gravity = 0.0;
  double wind = 0.0;
  double pins = 0.0;       // by particles that are fixed or moved, and by their release
  double damped = 0.0;     // taken by dampers; not negative
  double numerical = 0.0;  // added by the method itself

  void carry(StateStream& stream) { stream(gravity, wind, pins, damped, numerical); }
};

// A cloth's motion and its balance at a time.
struct ClothMoment {
  NodalState state;
  ClothWork work;
  std::int64_t iterations = 0;
};

class ClothBody {
 public:
  // scene: with one cloth; its balls, colliders and hands are not used. velocity: of all particles
  // at the start, m/s; spin: of the cloth about its centre of mass, rad/s. A `settled` cloth is not
  // in equilibrium before settle(). Errors: kContent for a spin of a cloth with pins, a velocity or
  // spin of a `settled` one; those of check_scene() and make_cloth_model(); kUsage for a step
  // beyond the method's stability.
  static Result<ClothBody> create(const ClothScene& scene,
                                  const Eigen::Vector3d& velocity = Eigen::Vector3d::Zero(),
                                  const Eigen::Vector3d& spin = Eigen::Vector3d::Zero());

  const SceneCloth& cloth() const { return scene_.cloths.front(); }
  const std::string& integrator() const { return scene_.integrator; }
  const NodalOptions& options() const { return scene_.options; }
  const ClothModel& model() const { return *model_; }
  const NodalState& state() const { return state_; }
  std::int64_t steps() const { return steps_; }
  double time() const { return static_cast<double>(steps_) * scene_.options.step; }  // s
  double mass() const { return model_->mass().sum(); }                               // kg

  // Replaces positions and velocities, 3n. Error kUsage: other sizes or a value that is not finite.
  Status set_state(const Eigen::VectorXd& x, const Eigen::VectorXd& v);

  // Sets all velocities to zero.
  void stop();
  // True if the wind moves the cloth, or its pins may move or release it later.
  bool is_driven() const;
  Eigen::Vector3d gravity_to_come() const {  // of the next step, m/s^2
    return scene_.gravity.at(time() + 0.5 * scene_.options.step);
  }

  // Puts the cloth at rest in its equilibrium under its pins, gravity at t = 0 and constant forces
  // on its particles, 3n, N. Call it before the first step. Errors, with nothing changed: those of
  // cloth_at_rest().
  Status settle(const Eigen::VectorXd& forces);

  // Gravity of all steps from the next one on, m/s^2, instead of that of the scene.
  void set_gravity(const Eigen::Vector3d& gravity);
  // Prepares the next step, before step() or end_step(): pins whose time is over are released;
  // gravity and wind become those of the middle of the step.
  void begin_step();
  // Takes the step without contact. If it fails, the state is unchanged.
  NodalReport step();
  // Takes the end of a step that others solved: x1, v1 receive the state at its start. Reported
  // work is added to the balance.
  void end_step(Eigen::VectorXd& x1, Eigen::VectorXd& v1);
  void add_work(const NodalReport& report);
  // The same for a step that others solve in parts: end_part() takes the end of each part, then
  // end_parts() counts the step. put_back() undoes parts; moment: of the start of the step.
  void end_part(Eigen::VectorXd& x1, Eigen::VectorXd& v1);
  void end_parts(int parts);
  ClothMoment moment() const { return {state_, work_, iterations_}; }
  void put_back(const ClothMoment& moment);

  double kinetic_energy() const;  // of the particles that are not fixed, J
  double elastic_energy() const { return model_->elastic_energy(state_.x); }
  const ClothWork& work() const { return work_; }
  Momenta momenta() const;  // of all particles, about the origin
  std::int64_t iterations() const { return iterations_; }
  std::int64_t cut_steps() const { return cut_steps_; }  // steps that were taken in parts

  // Saves or restores the state between steps, to the bit.
  void carry(StateStream& stream);

 private:
  explicit ClothBody(const ClothScene& scene) : scene_(scene) {}

  ClothScene scene_;
  std::unique_ptr<ClothModel> model_;  // the integrator has its address
  std::unique_ptr<NodalIntegrator> integrator_;
  NodalState state_;
  ClothWork work_;
  Eigen::VectorXd before_;  // positions at the start of the step, m
  std::int64_t steps_ = 0, iterations_ = 0, cut_steps_ = 0;
};

}  // namespace tremolo
