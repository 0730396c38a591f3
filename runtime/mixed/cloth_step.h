// A cloth in a step of an island of bodies of any kind. Its equation is that of
// runtime/step/implicit_solve.h for z = x1 - x0, with a force F on a particle that is constant over
// the step:
//   implicit-euler   M (z - h v0)/h^2 = f(x1, z/h) + F,             v1 = z/h
//   energy           2 M (z - h v0)/h^2 = step_force(x0, x1) + F,   v1 = 2 z/h - v0
// Each receives the momentum h F and the work F.z. energy receives the angular momentum
// h (x0 + x1)/2 x F; implicit-euler damps its angular momentum in any case. A step of midpoint in
// contact is one of energy: midpoint adds energy where stiff springs rotate in long steps, which
// a cloth alone repeats by that rule (NodalOptions, guard).
//
// Contact points are the particles; each stands for an area of the sheet, and the margin is the
// thickness of the cloth. A cloth has no inside, so that points of others do not collide with it.
#pragma once

#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "runtime/bodies/cloth/cloth_body.h"
#include "runtime/contact/solve/contact_surface.h"
#include "runtime/math/sparse/quick_factor.h"
#include "runtime/mixed/guest_step.h"
#include "runtime/mixed/point_law.h"
#include "runtime/step/halved_step.h"
#include "runtime/step/left_out_terms.h"

namespace tremolo {

// Empty: the method's equation has the form above. Otherwise the reason why a cloth with it cannot
// be in contact with other bodies.
std::string cloth_method_problem(std::string_view integrator);

class ClothStep final : public GuestStep {
 public:
  // body: stays in memory; its method has no cloth_method_problem(). options.margin is not used.
  ClothStep(ClothBody& body, const ContactOptions& options);

  // Same as the step of a ClothWorld without obstacles.
  bool step_alone() override;
  ClothBody& body() const { return *body_; }
  Status settle(const Eigen::VectorXd& forces) override { return body_->settle(forces); }
  bool is_fixed(std::size_t point) const override { return is_held(point); }
  double mass_at(std::size_t point) const override { return areas_.masses[point]; }
  bool is_driven() const override { return body_->is_driven(); }
  double mass() const override { return body_->mass(); }
  double kinetic_energy() const override { return body_->kinetic_energy(); }
  Eigen::Vector3d gravity_to_come() const override { return body_->gravity_to_come(); }
  double slow() const override {
    return slow_speed(std::min(law_.margin, ContactOptions{}.margin * areas_.extent));
  }
  void stop() override { body_->stop(); }
  void rest_a_step() override { body_->end_parts(1); }

  std::size_t points() const override { return areas_.areas.size(); }
  bool feels(std::size_t point) const override { return point < points(); }
  Eigen::Vector3d start_of(std::size_t point) const override { return at(body_->state().x, point); }
  ContactLaw area_law() const override { return law_; }
  // Pins carry a pinned cloth. What presses on it is then not its own weight, but that of the other
  // body: it is as stiff as that, if that is stiffer.
  ContactLaw area_law_with(const ContactLaw& theirs) const override;
  double area_of(std::size_t point) const override { return areas_.areas[point]; }
  ContactLaw law_of(std::size_t point, double friction, double restitution) const override {
    return point_law(areas_, law_, point, friction, restitution, rounding());
  }
  double rounding() const override {
    return distance_rounding(areas_.extent, ball().centre.norm());
  }

  Eigen::Index unknowns() const override { return way_.size(); }
  void begin() override;
  void keep() override { kept_ = way_; }
  void go(double length, In direction) override;
  void evaluate(const ContactRenewal& renewal) override;
  SiteMotion motion(std::size_t point) const override;
  void add_force(std::size_t point, const Eigen::Vector3d& force) override;
  double close() override;
  double enough() const override;
  double momentum_of_size() const override { return step_size(); }
  void residual(Out rows) const override { rows = residual_; }
  double work_along(In direction) const override { return residual_.dot(direction); }

  void make_tangent(double heavier, bool follows) override;
  void add_slope(std::size_t point, const Eigen::Matrix3d& by_end,
                 const Eigen::Vector3d& force) override;
  bool factor(bool fresh) override;
  void multiply(In x, Out rows) const override;
  void precondition(In rows, Out x) override;
  Eigen::Vector3d change_at(std::size_t point, In x) const override;
  void add_image(std::size_t point, const Eigen::Vector3d& fall, Out rows) const override;

  bool add_missed() override { return false; }
  void finish(const ContactAccount& account, double start, bool jumped) override;
  int number_of(std::size_t point) const override { return static_cast<int>(point); }
  void end() override { sort_memories(); }
  void give_up() override {}

 protected:
  void prepare() override { body_->begin_step(); }
  StepBall find_ball() override;
  void keep_whole() override { whole_ = body_->moment(); }
  void begin_part() override {}
  void carry_body(StateStream& stream) override { body_->carry(stream); }
  void end_whole(int parts) override;

 private:
  enum class Method { kImplicitEuler, kEnergy };
  struct Slope {
    std::size_t point;
    Eigen::Matrix3d by_end;
  };

  static Eigen::Vector3d at(const Eigen::VectorXd& x, std::size_t point) {
    return x.segment<3>(3 * static_cast<Eigen::Index>(point));
  }
  bool is_held(std::size_t point) const { return body_->model().held()[point] != 0; }
  double step_size() const { return length(body_->options().step); }  // of the present part, s
  // At the end of the present part, s. Moved particles follow their own path through the step.
  double end_time() const { return body_->time() + part().to * body_->options().step; }
  double mass_factor() const;
  void assemble(bool with_contact);
  void invert_diagonal();
  void add_missing_terms() const;

  ClothBody* body_;
  Method method_;
  PointAreas areas_;
  ContactLaw law_;
  bool pinned_ = false;    // some particles are held from the beginning
  double stiffest_ = 0.0;  // largest coefficient of the matrix at rest, N/m
  BlockMatrix matrix_;
  std::optional<QuickFactor> factor_;
  std::vector<Eigen::Matrix3d> inverse_;  // of the diagonal's blocks, without a factor
  StepLedger ledger_;
  double heavier_ = 0.0;
  LeftOutTerms lacks_;
  bool exact_ = false;               // products have the terms that are not symmetric
  bool contact_in_matrix_ = false;   // the symmetric part of contact is in the matrix
  bool known_ = false;               // forces are those at known_way_
  Eigen::VectorXd way_, known_way_;  // z
  Eigen::VectorXd kept_, x1_, v1_, speed_;
  Eigen::VectorXd force_, inertia_, pushed_, residual_;  // N
  StepWork work_;                                        // of step_force(), J
  mutable Eigen::VectorXd in_, out_, missing_;
  std::vector<Slope> slopes_;
  ClothMoment whole_;  // at the start of a step that is taken in parts
};

}  // namespace tremolo
