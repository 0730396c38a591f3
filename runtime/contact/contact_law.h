// The force between a point of a body and a collider, over one step (docs/theory.md, section
// "Contact").
//
// Nearer than the margin M, a point at the distance d has the energy psi(d) = k/3 (M - d)^3, a
// convex function with two continuous derivatives. Over a step from x0 to x1, in the collider's
// frame, the force is the discrete gradient
//
//     f = -s n,   s = (psi(d1) - psi(d0)) / (d1 - d0),   n.(x1 - x0) = d1 - d0
//
// in closed form, with n the normal in the middle, corrected along x1 - x0: its work is exactly
// psi(d0) - psi(d1). Where what is touched bends as well, by w, while the point goes by p along it,
// the correction is shared: n + c p pushes the point, n - c w the bending, and
// (n + c p).p - (n - c w).w = d1 - d0. Along p - w alone it would grow without bound where the
// point sticks to what bends. On the way out only the share e^2 of it pushes: a point mass leaves
// with e times the speed of its arrival. Friction is mu |s| g(|t|) against the tangential part t of
// x1 - x0, g(l) = l/w (2 - l/w) where l is below the way w of a small speed, else 1, so that it
// only takes. All of it has a continuous derivative by x1.
#pragma once

#include <Eigen/Core>

#include "runtime/contact/collider.h"
#include "runtime/frames/pose.h"

namespace tremolo {

// margin: M, m. stiffness: k, N/m^2. restitution: e, 0 to 1. friction: mu. rebound_speed: m/s, at
// which the share that pushes on the way out has fallen to e^2. slip_speed: m/s, at which friction
// is whole.
struct ContactLaw {
  double margin = 0.0;
  double stiffness = 0.0;
  double restitution = 0.5;
  double friction = 0.3;
  double rebound_speed = 0.0;
  double slip_speed = 0.0;

  double energy(double distance) const {
    const double depth = margin - distance;
    return depth > 0.0 ? stiffness / 3.0 * depth * depth * depth : 0.0;
  }
};

// A collider in the world, in one step. Its frame moves from `start` to `end`. friction,
// restitution: of the pair with whatever touches it.
struct PlacedCollider {
  Collider shape;
  Pose start, end;
  double friction = 0.3;
  double restitution = 0.5;
};

// A point near a collider at the start of a step. place: x0 in the collider's frame then, m.
struct ContactStart {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // there
  double distance = 0.0;                              // d0, m
  double energy = 0.0;                                // psi(d0), J
};

// By how much a force falls with the distance d1, N/m, with p and with w, N/m.
struct ContactSlope {
  Eigen::Vector3d by_distance;
  Eigen::Matrix3d by_path;
  Eigen::Matrix3d by_bend;
};

// Slopes of the force on the point and of what bends that which is touched.
struct ContactSlopes {
  ContactSlope point, bend;
};

// Over the step. acts: there is a force. force: on the point, N, world; the opposite of bend_force
// is what bends that which is touched. pressure: s n's length before restitution's share and
// friction, N. grinding: mu |s| |n| as it is, N. energy: psi(d1), J. lost: what restitution took,
// rubbed: what friction took, J. distance: d1, m.
struct ContactForce {
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), bend_force = force;
  bool acts = false;
  double pressure = 0.0;
  double grinding = 0.0;
  double energy = 0.0;
  double lost = 0.0;
  double rubbed = 0.0;
  double distance = 0.0;

  // Nothing acts. What is of the force itself is left as it is.
  void clear(double at) {
    acts = false;
    pressure = grinding = energy = lost = rubbed = 0.0;
    distance = at;
  }
};

// What a solver holds while it looks for the end of the step, and renews at first: the normal of
// the middle, and friction's mu |s| |n|, N. With both held the force has a symmetric derivative but
// for curvature, which a line search needs; friction takes only, whatever is held.
struct ContactHeld {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double grinding = 0.0;
};

// p, by which the point goes along what it touches as if that did not bend, and w, by which that
// bends there, m. The point's way over it is p - w.
struct ContactWay {
  Eigen::Vector3d path = Eigen::Vector3d::Zero();
  Eigen::Vector3d bend = Eigen::Vector3d::Zero();
};

// A distance that goes from d0, with the energy e0, to d1 in a step, m and J.
struct ContactGap {
  double d0 = 0.0, e0 = 0.0, d1 = 0.0;
};

// The force of a contact. h: the step, s. renew: by this share what friction is held at goes to
// what it is, 0 to 1. Vectors in any one frame.
ContactForce contact_force(const ContactLaw& law, const ContactGap& gap, const ContactWay& way,
                           double h, double renew, ContactHeld& held);

// How that force, which acts, falls with what is held as it is.
ContactSlopes contact_slopes(const ContactLaw& law, const ContactGap& gap, const ContactWay& way,
                             double h, const ContactHeld& held);

// x: world, m.
ContactStart contact_start(const ContactLaw& law, const PlacedCollider& collider,
                           const Eigen::Vector3d& x);

// x1: where the point ends, world, m. h: the step, s. renew: 0: `held` stays; else it is renewed,
// its friction by that share.
ContactForce contact_force(const ContactLaw& law, const PlacedCollider& collider,
                           const ContactStart& start, const Eigen::Vector3d& x1, double h,
                           double renew, ContactHeld& held);

// How far the point went relative to the collider, m; through: whether it went through it
// (passage.h). A plane has no other side.
double contact_passage(const PlacedCollider& collider, const ContactStart& start,
                       const Eigen::Vector3d& x1, bool& through);

// By how much that force, which acts, falls with x1, N/m.
Eigen::Matrix3d contact_stiffness(const ContactLaw& law, const PlacedCollider& collider,
                                  const ContactStart& start, const Eigen::Vector3d& x1, double h,
                                  const ContactHeld& held);

}  // namespace tremolo
