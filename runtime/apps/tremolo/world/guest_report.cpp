#include "runtime/apps/tremolo/world/guest_report.h"

#include <fmt/format.h>

#include "runtime/apps/tremolo/output/text_values.h"
#include "runtime/world/guest_points.h"

namespace tremolo {

void add_guest_contacts(const MixedGuests& guests, std::size_t guest, double h,
                        nlohmann::ordered_json& json) {
  const ContactAccount& account = guests.account(guest);
  json["contacts"] = guests.contacts(guest);
  json["contact_points_final"] = account.active;
  json["contact_force_final"] = vector_json(account.impulse_vector / h);
  json["contact_energy"] = number_or_null(account.energy);
  json["contact_error"] = number_or_null(guests.sums(guest).error);
  json["penetration_max"] = number_or_null(guests.penetration_max(guest));
  json["slip_max"] = number_or_null(guests.slip_max(guest));
  json["asleep"] = guests.asleep(guest);
}

std::array<double, 6> held_values(const MixedGuests& guests, std::size_t guest) {
  const ContactSums& sums = guests.sums(guest);
  const Eigen::Vector3d force = guests.hands_force(guest);
  return {sums.hand, sums.joint, force.x(), force.y(), force.z(), guests.load_work(guest)};
}

Result<GuestProbes> GuestProbes::create(const MixedGuests& guests, std::size_t guest,
                                        const std::vector<std::string>& probes, const Pose& pose) {
  GuestProbes made;
  made.guest_ = guest;
  for (const std::string& text : probes) {
    const Result<std::size_t> point = guest_point(guests, guest, text, "probe", "probe");
    if (!point) return point.error();
    Probe& probe = made.probes_.emplace_back();
    probe.point = *point;
    probe.number = guests.number_of(guest, *point);
    if (const TetStep* tets = guests.tets(guest))
      probe.start =
          pose * tets->body().model().mesh().vertices[static_cast<std::size_t>(probe.number)];
    else
      probe.start = guests.cloth(guest)->body().model().parts().x.segment<3>(
          static_cast<Eigen::Index>(3 * *point));
  }
  return made;
}

std::string GuestProbes::columns() const {
  std::string names;
  for (const Probe& probe : probes_)
    for (const char axis : {'x', 'y', 'z'}) names += fmt::format(",u{}{}", probe.number, axis);
  return names;
}

void GuestProbes::append_now(const MixedGuests& guests, std::vector<double>& values) const {
  for (const Probe& probe : probes_)
    for (const double way : guests.point_at(guest_, probe.point) - probe.start)
      values.push_back(way);
}

std::vector<double> further_values(const MixedGuests& guests, std::size_t guest,
                                   const GuestProbes& probes) {
  const std::array<double, 6> held = held_values(guests, guest);
  std::vector<double> values(held.begin(), held.end());
  probes.append_now(guests, values);
  return values;
}

std::vector<std::string> guest_names(const MixedFile& mixed) {
  std::vector<std::string> names;
  for (const TetSceneBody& body : mixed.tets) names.push_back(body.name);
  for (const ClothSceneBody& body : mixed.cloths) names.push_back(body.name());
  return names;
}

}  // namespace tremolo
