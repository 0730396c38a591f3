// A reduced body, fixed, driven or free, in a step of an island of bodies of any kind: the step of
// runtime/contact/solve/contact_step.h. Its colliders and grabs are its own.
#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "runtime/contact/islands/contact_island.h"
#include "runtime/contact/solve/contact_equations.h"
#include "runtime/contact/solve/contact_step.h"
#include "runtime/math/dense/dense_lu.h"
#include "runtime/mixed/step_body.h"

namespace tremolo {

class ReducedStep final : public StepBody {
 public:
  // The body of the next step, which has gathered.
  void set(const IslandMember& member) { member_ = member; }
  // The report of a step that succeeded.
  const StepReport& report() const { return report_; }
  // Its number in its group.
  std::size_t number() const { return member_.number; }

  ContactEquations& equations() const { return member_.contact->equations(); }
  ContactStep& contact() const { return *member_.contact; }

  StepBall ball() const override;
  std::size_t points() const override { return surface_points().size(); }
  bool feels(std::size_t point) const override { return surface_points().meets(point, false); }
  Eigen::Vector3d start_of(std::size_t point) const override;
  ContactLaw area_law() const override { return contact().surface().law; }
  double area_of(std::size_t point) const override { return surface_points().areas[point]; }
  ContactLaw law_of(std::size_t point, double friction, double restitution) const override {
    return tremolo::law_of(contact().surface(), point, friction, restitution, rounding());
  }
  double rounding() const override {
    return distance_rounding(contact().surface(), contact().gathered().ball);
  }
  const ContactMemory* memory(std::size_t obstacle, std::size_t point) const override {
    return contact().pair_memories().find(obstacle, point);
  }
  double reach_of_sides(std::size_t obstacle) const override {
    return contact().pair_memories().reach_of_sides(obstacle);
  }

  Eigen::Index unknowns() const override { return equations().unknowns(); }
  void begin() override;
  void keep() override { kept_ = equations().z; }
  void go(double length, In direction) override;
  void evaluate(const ContactRenewal& renewal) override { contact().evaluate(renewal); }
  SiteMotion motion(std::size_t point) const override;
  void add_force(std::size_t point, const Eigen::Vector3d& force) override;
  double close() override { return contact().close(); }
  double enough() const override { return contact().enough(); }
  double momentum_of_size() const override { return std::sqrt(contact().surface().mass); }
  void residual(Out rows) const override;
  double work_along(In direction) const override { return equations().work_along(direction); }

  void make_tangent(double heavier, bool follows) override;
  void add_slope(std::size_t point, const Eigen::Matrix3d& by_end,
                 const Eigen::Vector3d& force) override;
  bool factor(bool fresh) override;
  void multiply(In x, Out rows) const override;
  void precondition(In rows, Out x) override;
  Eigen::Vector3d change_at(std::size_t point, In x) const override;
  void add_image(std::size_t point, const Eigen::Vector3d& fall, Out rows) const override;
  // The same for any position, whose force has the effect push, n x 3, on the residual.
  void add_scaled(const Eigen::MatrixXd& push, const Eigen::Vector3d& fall, Out rows) const;

  bool add_missed() override { return contact().add_missed(); }
  void finish(const ContactAccount& account, double start, bool jumped) override;
  void remember(const ContactMemory& memory) override { contact().pair_memories().add(memory); }
  void note(const ContactedPoint& point) override { contact().record().contacted.push_back(point); }
  int number_of(std::size_t point) const override { return surface_points().ids[point]; }
  void end() override { contact().pair_memories().sort(); }
  void give_up() override {}

 private:
  const ContactPoints& surface_points() const { return *contact().surface().points; }
  auto scale() const { return equations().row_scale.head(unknowns()); }

  // Derivatives of a point's motion and of the effect of its force.
  struct PointLever {
    Eigen::MatrixXd push;  // n x 3
    Eigen::Matrix3Xd way;  // 3 x n
  };

  IslandMember member_;
  StepReport report_;
  Eigen::VectorXd kept_, rows_;
  std::vector<PointLever> levers_;  // one a point, once it has a slope
  DenseLu factor_;
};

}  // namespace tremolo
