// A cloth as point masses: the forces of its springs, of the wind and of gravity on its particles.
//
// M x'' = f(x, v) = f_structural + f_shear + f_bend + f_wind + M g. Structural springs are the
// stiff part (ForcePart::kStiff), all else is the soft one.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/bodies/cloth/cloth_parts.h"
#include "runtime/bodies/cloth/spring_set.h"
#include "runtime/bodies/cloth/wind_drag.h"
#include "runtime/math/motion.h"
#include "runtime/step/nodal_system.h"

namespace tremolo {

class ClothModel : public NodalSystem {
 public:
  // Errors (kContent): no particle, a mass that is not positive and finite, a value that is not
  // finite, springs and triangles of particles that do not exist, a negative spring law.
  static Result<ClothModel> create(ClothParts parts);

  // Gravity, m/s^2, and wind, m/s. They are constant through a step.
  void set_gravity(const Eigen::Vector3d& gravity) {
    if (gravity != gravity_) ++potential_version_;
    gravity_ = gravity;
  }
  void set_wind(const Eigen::Vector3d& wind) { wind_ = wind; }
  const Eigen::Vector3d& gravity() const { return gravity_; }
  const Eigen::Vector3d& wind() const { return wind_; }

  // Fixes particles, which move from their rest positions as the path maps the world, until a time,
  // s. Error (kContent): a particle that does not exist.
  Status pin(std::span<const std::size_t> particles, MotionPath path, double until);
  // Releases particles that are fixed until `time` or before; true if there were any.
  bool release_pins(double time);
  // True if no pin that holds moves, or is to be released.
  bool pins_stay() const;
  // Reserves memory for one more hold, which then allocates nothing; there is room for sixteen.
  void expect_hold() { hands_.reserve(hands_.capacity() + 1); }
  // A grab of one particle; it has priority over pins. particle: below size().
  void hold(std::size_t particle, const Eigen::Vector3d& at);
  // Starts the step from `time`, s, with the length `h` at positions x: grabbed particles move from
  // there to their targets on straight paths at constant speed. A grab that no step has started is
  // at its target at once.
  void begin_holds(double time, double h, const Eigen::VectorXd& x);
  // Releases a grab. True if there was one; a pin may still fix the particle.
  bool let_go(std::size_t particle);

  // Sets the contact of its particles in implicit steps; null: none. It must outlive its use.
  void set_contact(NodalContact* contact) { contact_ = contact; }

  const ClothParts& parts() const { return parts_; }
  std::size_t springs() const { return structural_.size() + shear_.size() + bend_.size(); }
  const SpringSet& structural() const { return structural_; }
  const SpringSet& shear() const { return shear_; }
  const SpringSet& bend() const { return bend_; }
  // Energy of the springs alone, J.
  double elastic_energy(const Eigen::VectorXd& x) const;

  std::size_t size() const override { return held_.size(); }
  const Eigen::VectorXd& mass() const override { return parts_.mass; }
  std::span<const std::uint8_t> held() const override { return held_; }
  const BlockPatternPointer& pattern() const override { return pattern_; }
  double load_size() const override;
  void put_held(double time, Eigen::VectorXd& x) const override;
  void force(const Eigen::VectorXd& x, const Eigen::VectorXd& v, ForcePart part,
             Eigen::VectorXd& f) const override;
  void add_tangent(const Eigen::VectorXd& x, const Eigen::VectorXd& v, ForcePart part,
                   double position, double velocity, double share, BlockMatrix& a) const override;
  double potential(const Eigen::VectorXd& x) const override;
  std::optional<std::uint64_t> potential_version() const override { return potential_version_; }
  StepWork power(const Eigen::VectorXd& x, const Eigen::VectorXd& v) const override;
  StepWork step_force(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double h,
                      Eigen::VectorXd& f) const override;
  void add_step_tangent(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double h,
                        double share, BlockMatrix& a) const override;
  // y += the product with u of the springs' terms that the tangents with all indefinite ones do not
  // have, because they are not symmetric (spring_set.h).
  void add_missing_product(const Eigen::VectorXd& x, const Eigen::VectorXd& v, double position,
                           const Eigen::VectorXd& u, Eigen::VectorXd& y) const;
  void add_missing_step_product(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double h,
                                const Eigen::VectorXd& u, Eigen::VectorXd& y) const;
  NodalContact* contact() const override { return contact_; }

  // Saves or restores which pins hold, gravity and wind, of a cloth without grabs.
  void carry(StateStream& stream);

 private:
  struct Pin {
    std::vector<std::size_t> particles;
    MotionPath path;
    double until = 0.0;
    bool active = true;
  };
  struct Hand {
    std::size_t particle = 0;
    Eigen::Vector3d at = Eigen::Vector3d::Zero(), from = Eigen::Vector3d::Zero();
    double begun = 0.0, length = 0.0;  // time and length of the step, s

    Eigen::Vector3d place(double time) const;
  };

  explicit ClothModel(ClothParts parts);
  void count_holds();

  ClothParts parts_;
  SpringSet structural_, shear_, bend_;
  WindDrag drag_;
  BlockPatternPointer pattern_;
  Eigen::Vector3d gravity_ = Eigen::Vector3d::Zero(), wind_ = Eigen::Vector3d::Zero();
  std::vector<Pin> pins_;
  std::vector<Hand> hands_;
  std::vector<std::uint8_t> held_;
  std::uint64_t potential_version_ = 0;
  NodalContact* contact_ = nullptr;
};

// The largest h omega for which the method `name` keeps x'' = -omega^2 x - 2 zeta omega x' from
// growing; infinity for a method without a limit.
double damped_stability_number(std::string_view name, double zeta);

// The largest stable step, s, for the sheet's largest frequency at x with the dampers of its
// springs: the smaller of the steps for the most and the least damped kind of spring. Infinity for
// methods without a limit. The frequencies of a loaded or folded sheet are slightly higher.
double stable_step(std::string_view name, const ClothModel& model, const Eigen::VectorXd& x);

// The equilibrium of a cloth (cloth_rest.cpp): positions, 3n, m, at which springs, gravity and
// `forces` (3n, N) balance; fixed particles stay where they are at `start`, 3n, where the search
// begins. The model has no wind. Errors: kContent without fixed particles; kSolver if no
// equilibrium is found, or if the one that is found is not stable or moves without resistance, so
// that it is not the only one.
Result<Eigen::VectorXd> cloth_at_rest(const ClothModel& model, const Eigen::VectorXd& forces,
                                      const Eigen::VectorXd& start);

}  // namespace tremolo
