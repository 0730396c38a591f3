// Friction of a contact point over one step: an elastic displacement with memory, and a slider
// (docs/theory.md, section "Contact").
//
// xi is the elastic tangential displacement, E = k/2 |xi|^2 its energy. A step moves the point by t
// in the tangent plane, and friction is at most L. With l = L/k and clip(x) = x min(1, l/|x|):
//
//     xi0 <- clip(xi0)                            the loss of E is friction's
//     x = xi0 + t,  xi1 = clip(x)                 t = te + tp,  te = xi1 - xi0,  tp = x - xi1
//     a = |te|/(|te| + |tp|)                      the elastic fraction of the path
//     F = -k (xi1 - a te/2) - g c te/h            g: the largest in [0, 1] that leaves |F| <= L,
//                                                 by the triangle inequality
//
// The first term is the exact mean of the force along a straight path that is parallel to xi0. Its
// energy balance is E0 - E1 + F.t <= 0: with F = -k (xi1 - a te/2) the loss is k a (xi0 + xi1).tp/2
// + k (1 - a) (xi1.tp + |te|^2/2). No term of that is negative, because tp is parallel to xi1
// wherever it is not zero and |xi0| <= l. The damper c takes g c te.t/h >= 0.
#pragma once

#include <Eigen/Core>

namespace tremolo {

// Friction of a point in a step.
struct FrictionLaw {
  double stiffness = 0.0;  // k, N/m
  double damping = 0.0;    // c/h, N/m
};

struct Friction {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // F, N
  Eigen::Vector3d slip = Eigen::Vector3d::Zero();   // xi1, m
  double energy = 0.0;                              // E1, J
  double lost = 0.0;                                // friction loss, J
};

// The derivatives of F by the path t, N/m, and by the limit L.
struct FrictionSlopes {
  Eigen::Matrix3d by_path = Eigen::Matrix3d::Zero();
  Eigen::Vector3d by_limit = Eigen::Vector3d::Zero();
};

// limit: L, N, at least 0. slip: xi0, m. path: t, m. Both vectors are in the tangent plane.
Friction friction_force(const FrictionLaw& law, double limit, const Eigen::Vector3d& slip,
                        const Eigen::Vector3d& path);

// The derivatives of that force. normal: of the tangent plane, of length 1.
FrictionSlopes friction_slopes(const FrictionLaw& law, double limit, const Eigen::Vector3d& slip,
                               const Eigen::Vector3d& path, const Eigen::Vector3d& normal);

// Rotates a vector of the plane of the unit normal `from` into the plane of the unit normal `to` by
// the smallest rotation; its length is unchanged. Zero for opposite normals.
Eigen::Vector3d turn_to_plane(const Eigen::Vector3d& vector, const Eigen::Vector3d& from,
                              const Eigen::Vector3d& to);

}  // namespace tremolo
