#include "runtime/apps/tremolo/world/guest_report.h"

#include "runtime/apps/tremolo/output/text_values.h"

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
  json["asleep"] = false;
}

std::array<double, 5> held_values(const MixedGuests& guests, std::size_t guest) {
  const ContactSums& sums = guests.sums(guest);
  const Eigen::Vector3d force = guests.hands_force(guest);
  return {sums.hand, sums.joint, force.x(), force.y(), force.z()};
}

std::vector<std::string> guest_names(const MixedFile& mixed) {
  std::vector<std::string> names;
  for (const TetSceneBody& body : mixed.tets) names.push_back(body.name);
  for (const ClothSceneBody& body : mixed.cloths) names.push_back(body.name());
  return names;
}

}  // namespace tremolo
