#include "runtime/contact/solve/contact_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tremolo {
namespace {

using Eigen::Index;

// About half of critical damping for the effective mass of a point: c = (k m)^1/2.
std::vector<double> find_dampers(const Model& model, const ContactSurface& surface) {
  const Index r = model.modes();
  const Eigen::ArrayXd give =
      1.0 / (1.0 + (0.25 * kContactTime * kContactTime) * model.lambda().array());
  std::vector<double> dampers;
  for (std::size_t i = 0; i < surface.points->size(); ++i) {
    const auto rows = surface.points->rows.middleCols<3>(static_cast<Index>(3 * i));
    double lightness = surface.can_move ? 1.0 / surface.mass : 0.0;
    for (Index k = 0; k < r; ++k) lightness += rows.row(k).squaredNorm() * give[k] / 3.0;
    dampers.push_back(lightness > 0.0 ? std::sqrt(1.0 / lightness) : 0.0);
  }
  return dampers;
}

// The friction spring is as stiff as the contact at half the margin, or where it is linear.
double shear_of(const ContactLaw& law) {
  return law.stiffness * std::min(law.margin, 2.0 * law.linear_from);
}

}  // namespace

ContactSurface make_contact_surface(const Model::Pointer& model, const ContactOptions& contact,
                                    double mass, bool free) {
  ContactSurface surface;
  surface.points = shared_contact_points(model, static_cast<std::size_t>(contact.points),
                                         contact.shape ? &*contact.shape : nullptr);
  surface.shape = contact.shape;
  surface.mass = mass;
  surface.can_move = free;
  surface.feels = contact.colliders;
  ContactLaw& law = surface.law;
  law.margin = law.begins = contact.margin * surface.points->extent;
  law.friction = contact.friction;
  law.restitution = contact.restitution;
  law.rebound_speed = 0.05 * law.margin / kContactTime;
  if (contact.modulus) {
    law.linear_from = 0.1 * law.margin;
    law.stiffness = *contact.modulus / (2.0 * law.linear_from * surface.points->extent);
  } else {
    law.stiffness = contact.stiffness * mass /
                    (2.0 * kContactTime * kContactTime * surface.points->area * law.margin);
  }
  surface.dampers = find_dampers(*model, surface);
  return surface;
}

double distance_rounding(const ContactSurface& surface, const ContactBall& ball) {
  return distance_rounding(surface.points->extent, ball.centre.norm());
}

double distance_rounding(double extent, double far) {
  constexpr double kRoundings = 32.0;
  return kRoundings * std::numeric_limits<double>::epsilon() * (extent + far);
}

ContactLaw law_of(const ContactSurface& surface, std::size_t point, double friction,
                  double restitution, double rounding) {
  ContactLaw law = surface.law;
  law.friction = friction;
  law.restitution = restitution;
  law.stiffness *= surface.points->areas[point];
  law.shear = shear_of(law);
  law.shear_damping = surface.dampers[point] * std::sqrt(law.shear);
  law.radius = surface.points->radius_of(point);
  law.rounding = rounding;
  return law;
}

// Friction and restitution of two bodies are geometric means.
ContactLaw law_between(const ContactSurface& first, std::size_t point, const ContactSurface& second,
                       double rounding) {
  const ContactLaw &ours = first.law, &theirs = second.law;
  ContactLaw law = law_in_series(law_of(first, point, std::sqrt(ours.friction * theirs.friction),
                                        std::sqrt(ours.restitution * theirs.restitution), rounding),
                                 ours, theirs, first.points->areas[point]);
  return law;
}

}  // namespace tremolo
