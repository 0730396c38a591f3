// Points of a body of any kind on the surface of a body of tetrahedra, under the law of
// contact_law.h.
//
// d is the distance at rest at the point X that the deformed elements map to the contact point p
// (tet_tree.h). It is known inside only, so that contact begins at d = 0. The force on the point is
// constant over the step; its opposite acts on the control points of the element with the weights
// B_I at the point that the means of the ends map to the mean of p. The path of the point along the
// body is then w = p1 - p0 - sum_I B_I (x_I1 - x_I0): momentum and angular momentum of the pair are
// kept, and the work on both is F.w = psi(d0) - psi(d1). Where the point begins outside, d0 = d1 -
// n.w; where it ends outside, d1 = d0 + n.w.
//
// The gradient of d jumps where a point passes from one element to the next, because F does. The
// normal n is therefore that of a continuous F (TetTree::smooth_gradient), and m = d1 - d0 - n.w is
// not of second order in w. The correction of contact_law.h along w, which closes the energy, would
// grow without bound as w vanishes. Only its part l = w^2/(w^2 + delta^2) is made: the law has the
// distance d1 - (1 - l) m instead of d1. The rest shifts the surface, for this point alone: B -> B
// + (1 - l) m, so that the next step begins with the same energy. The surface is never shifted
// outwards: what is beyond counts as lost.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "runtime/mixed/pair_forces.h"
#include "runtime/mixed/tet_step.h"

namespace tremolo {

class HullContact final : public PairForces {
 public:
  // Finds the points that may come inside in the step of h, s. obstacle: the number of the body of
  // tetrahedra, for memories. Both bodies have started their steps. False: there are none, or the
  // body has no distances.
  bool gather(StepBody& points, TetStep& shape, std::size_t obstacle, double h);

  void begin() override;
  void approach(const ContactRenewal& renewal) override;
  void press(const ContactRenewal& renewal) override;
  void make_slopes(bool follows) override;
  void add_growth(StepBody::In first_x, StepBody::In second_x) override;
  void multiply(StepBody::In first_x, StepBody::In second_x, StepBody::Out first_rows,
                StepBody::Out second_rows) const override;
  // Points are found in a box around the body: those that go farther than predicted begin in the
  // next step, inside and without energy.
  bool add_missed() override { return false; }
  void settle(ContactAccount& first_account, ContactAccount& second_account, double& first_start,
              double& second_start) const override;
  void remember() override;
  std::size_t acting() const override;

 private:
  struct Touch {
    std::size_t point = 0;
    ContactLaw law;
    ContactMemory memory;  // along the axes of the element
    ContactHeld held;
    ContactForce now;
    ContactGap gap;     // with the distance of the law at the end
    double end = 0.0;   // d1, m
    double part = 1.0;  // l
    Eigen::Vector3d part_slope = Eigen::Vector3d::Zero();  // slope of the law's distance with w
    double begins = 0.0;                                   // B of the next step, m
    ContactWay way;
    SiteMotion motion;
    bool inside = false;                                                    // at the start
    std::uint32_t element = 0, end_element = 0;                             // there, and at the end
    double distance = 0.0, energy = 0.0;                                    // at the start, m and J
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero(), normal = gradient;  // there, if inside
    bool near = false;  // it is inside at an end of the step
    Eigen::Vector3d end_gradient = Eigen::Vector3d::Zero(), end_normal = end_gradient;
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  // of the element, in the middle
    TetSite site;
    TetSite end_site;  // the point of the body that is at the contact point at the end
    std::optional<std::uint32_t> kept_element;  // at the end, since the last renewal
    // Slopes of the force on the point: its fall with w, the effect of the pair's rate, growth of
    // the part that restitution takes with the distance, and the fall with that.
    Eigen::Matrix3d by_way;
    Eigen::Matrix3d by_shift;  // fall of the force where its site moves along the body, N/m at rest
    Eigen::Vector3d link, growth, by_distance;
  };

  void find_end(Touch& touch, bool renews);
  void find_gap(Touch& touch, double d0, double d1);
  void hold_normal_of(Touch& touch);
  static void close_energy(Touch& touch);
  // Change of the body's path at the end's point beyond that at the point of the force, along the
  // gradient of the distance, m.
  double change_beyond(const Touch& touch, StepBody::In second_x) const;
  ContactTime time() const { return {h_, shared->rate}; }

  StepBody* points_ = nullptr;
  TetStep* shape_ = nullptr;
  std::size_t obstacle_ = 0;
  double h_ = 0.0;
  std::vector<Touch> touches_;
};

}  // namespace tremolo
