// A body of tetrahedra in a step of an island of bodies of any kind. Its equation is that of
// tet_stage.h, with a force F that is constant over the step at x = sum_I B_I x_I:
//   M g^2 (d - d_a) = f(x_v + d, g d) + B_I F.
// implicit-euler and midpoint then receive the momentum h F. bdf2 conserves M (3 v_1 - v_0)/2 plus
// h F: F would be late by half a step and give the body energy. It receives h (3 F - F')/2 instead,
// with F' of the step before, also where F is gone; M v_1 then takes h F in each step.
// newmark takes a step of midpoint in contact. F's work is F.(x_1 - x_0). midpoint receives the
// angular momentum h x~ x F about the mean x~ of the ends; the other methods damp their angular
// momentum in any case.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "runtime/bodies/tets/contact/tet_contact.h"
#include "runtime/bodies/tets/motion/tet_body.h"
#include "runtime/bodies/tets/motion/tet_sums.h"
#include "runtime/contact/solve/contact_surface.h"
#include "runtime/math/sparse/quick_factor.h"
#include "runtime/mixed/guest_step.h"
#include "runtime/mixed/point_law.h"

namespace tremolo {

// The contact points of bodies of tetrahedra of one kind: the vertices of the mesh's boundary and
// the middles of its edges.
struct TetPoints : PointAreas {
  std::vector<TetPoint> points;
};

std::shared_ptr<const TetPoints> make_tet_points(const TetModel& model);

// A position inside the body: its distance from the surface at rest, below 0, m, the gradient of
// that with the position, and the same by a deformation that is continuous between elements.
struct TetDepth {
  double distance = 0.0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero(), normal = gradient;
  std::uint32_t element = 0;
  std::array<double, kMostNodes> values{};  // B_I at the position in the element
};

// A point of an element on which the forces of others act.
struct TetSite {
  std::uint32_t element = 0;
  std::array<double, kMostNodes> values{};            // B_I there
  std::array<double, kMostNodes> shares{};            // the same, condensed
  Eigen::Vector4d weights = Eigen::Vector4d::Zero();  // barycentric
  // The gradients of B_I and of the condensed ones with X, 1/m: find_slopes().
  std::array<Eigen::Vector3d, kMostNodes> slopes{}, slope_shares{};
  // F^-1 of the element there.
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Identity();
  // F there, continuous between elements.
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Identity();
};

class TetStep final : public GuestStep {
 public:
  // body: stays in memory. points: of its model. hull: null, or without distances: points of other
  // bodies pass through.
  TetStep(TetBody& body, std::shared_ptr<const TetPoints> points, const ContactOptions& options,
          TetHullPointer hull);

  // Same as TetBody::step(), with the same bits.
  bool step_alone() override;
  const TetStepReport& report() const { return report_; }
  // Sums since the start. Call add_sums() after each step that succeeded.
  const TetSums& sums() const { return sums_; }
  void add_sums() { sums_.add(*body_, report_); }
  TetBody& body() const { return *body_; }
  Status settle(const Eigen::VectorXd& forces) override;
  bool is_fixed(std::size_t point) const override;
  // The contact point that is a vertex of the mesh; empty: the vertex is inside.
  std::optional<std::size_t> point_of(VertexId vertex) const;
  // Those that are one of these vertices, or the middle of an edge between two of them.
  std::vector<std::size_t> points_on(const std::vector<VertexId>& vertices) const;
  double mass_at(std::size_t point) const override { return points_->masses[point]; }
  bool is_driven() const override { return false; }
  double mass() const override { return body_->model().mass(); }
  double kinetic_energy() const override { return body_->kinetic_energy(); }
  Eigen::Vector3d gravity_to_come() const override { return body_->options().gravity; }
  double slow() const override { return slow_speed(law_.margin); }
  void stop() override { body_->stop(); }
  void rest_a_step() override;

  // The body as an obstacle (hull_contact.h). follow_hull(): positions are needed in this step.
  bool has_hull() const { return hull_ && hull_->grid; }
  void follow_hull() { follows_hull_ = true; }
  const TetTree::Box& box_at_start() const { return boxes_at_start_.front(); }
  // element: where the point was before. Outside of all elements, whose continuations differ, it
  // stays there; if it `stays` also inside of others, until it is far outside of its own. At the
  // start of a step it does, since the step before ended there. Empty: the point is outside.
  std::optional<TetDepth> depth_at_start(const Eigen::Vector3d& place,
                                         std::optional<std::uint32_t> element) const;
  std::optional<TetDepth> depth_at_end(const Eigen::Vector3d& place,
                                       std::optional<std::uint32_t> element, bool stays) const;
  // Finds the point of the element, or of its continuation, that the means of the ends of the step
  // map to `place`. False: there is none.
  bool find_site(const Eigen::Vector3d& place, std::uint32_t element, TetSite& site) const;
  Eigen::Vector3d way_of(const TetSite& site) const;  // its path in the step, m
  void push_site(const TetSite& site, const Eigen::Vector3d& force);
  // Same as add_slope(), change_at() and add_image() for a site, once it is condensed.
  void condense(TetSite& site) const;
  void find_slopes(TetSite& site) const;
  void add_site_slope(const TetSite& site, const Eigen::Matrix3d& by_end);
  Eigen::Vector3d change_of(const TetSite& site, In x) const;
  void add_site_image(const TetSite& site, const Eigen::Vector3d& fall, Out rows) const;
  // Derivative of way_of() with X.
  Eigen::Matrix3d way_slope(const TetSite& site) const;
  // rows += the change of the residual where the site of the force moves by `shift`, m at rest.
  void add_shifted_site(const TetSite& site, const Eigen::Vector3d& force,
                        const Eigen::Vector3d& shift, Out rows) const;

  std::size_t points() const override { return points_->points.size(); }
  bool feels(std::size_t point) const override { return point < points(); }
  Eigen::Vector3d start_of(std::size_t point) const override;
  ContactLaw area_law() const override { return law_; }
  double area_of(std::size_t point) const override { return points_->areas[point]; }
  ContactLaw law_of(std::size_t point, double friction, double restitution) const override {
    return point_law(*points_, law_, point, friction, restitution, rounding());
  }
  double rounding() const override {
    return distance_rounding(points_->extent, ball().centre.norm());
  }

  Eigen::Index unknowns() const override;
  void begin() override;
  void keep() override;
  void go(double length, In direction) override;
  void evaluate(const ContactRenewal& renewal) override;
  SiteMotion motion(std::size_t point) const override;
  void add_force(std::size_t point, const Eigen::Vector3d& force) override;
  double close() override;
  double enough() const override;
  double momentum_of_size() const override { return step_size(); }
  void residual(Out rows) const override;
  double work_along(In direction) const override;

  void make_tangent(double heavier, bool follows) override;
  void add_slope(std::size_t point, const Eigen::Matrix3d& by_end,
                 const Eigen::Vector3d& force) override;
  bool factor(bool fresh) override;
  void multiply(In x, Out rows) const override;
  void precondition(In rows, Out x) override;
  Eigen::Vector3d change_at(std::size_t point, In x) const override;
  void add_image(std::size_t point, const Eigen::Vector3d& fall, Out rows) const override;

  bool add_missed() override { return false; }
  // Where edges change their degree, points on them move at once.
  bool jumped() const override { return jumped_; }
  void finish(const ContactAccount& account, double start, bool jumped) override;
  int number_of(std::size_t point) const override;
  void end() override;
  void give_up() override;

 protected:
  StepBall find_ball() override;
  void keep_whole() override;
  void begin_part() override;
  void carry_body(StateStream& stream) override;
  void end_whole(int parts) override;

 private:
  // The body before the first part of a step.
  struct Whole {
    TetMotion now, before;
    bool has_before = false;
    Eigen::VectorXd pushed_before;
  };

  // The slope of a force on a point, with its condensed weights. Fixed control points have none.
  struct Slope {
    std::span<const std::uint32_t> nodes;
    std::array<double, kMostNodes> shares{};
    Eigen::Matrix3d by_end;
  };

  std::span<const std::uint32_t> nodes_of(std::size_t point) const {
    return {points_->points[point].nodes.data(), points_->points[point].count};
  }
  std::span<const std::uint32_t> nodes_of(const TetSite& site) const {
    return body_->model().elements()[site.element].nodes;
  }
  void condense(std::span<const std::uint32_t> nodes, std::array<double, kMostNodes>& shares) const;
  std::optional<TetDepth> depth_at(const Eigen::VectorXd& x, const std::vector<TetTree::Box>& boxes,
                                   const Eigen::Vector3d& place,
                                   std::optional<std::uint32_t> element, bool stays) const;
  double step_size() const { return length(body_->options().step); }  // of the present part, s
  void assemble(double heavier, TangentKind tangent, bool with_contact);
  void give_before();
  void add_contact(const Slope& slope);

  TetBody* body_;
  std::shared_ptr<const TetPoints> points_;
  ContactLaw law_;
  TetStepReport report_;
  bool jumped_ = false;
  TetSums sums_;
  double ends_ = 1.0;   // dx_1/dd
  double share_ = 1.0;  // of F in the body's equation
  bool known_ = false;
  double heavier_ = 0.0;
  bool contact_in_matrix_ = false;
  // d of the last evaluation; the forces there; F, on control points; F', of bdf2.
  Eigen::VectorXd known_way_, own_, pushed_, pushed_before_, kept_;
  mutable Eigen::VectorXd in_, out_;
  std::vector<Slope> slopes_;
  std::vector<std::array<double, kMostNodes>> shares_;  // condensed, of points with a slope
  TetHullPointer hull_;
  bool follows_hull_ = false;
  std::vector<TetTree::Box> boxes_at_start_, boxes_at_end_;
  Eigen::VectorXd end_, middle_;     // positions at the end and in the middle of the step, m
  std::vector<std::uint8_t> still_;  // a flag for each control point that is not active
  std::optional<QuickFactor> factor_;
  std::vector<Eigen::Matrix3d> inverse_;  // of the diagonal's blocks, without a factor
  Whole whole_;
};

}  // namespace tremolo
