// Parts of a run's report and files that all kinds of guests of a world have: bodies of tetrahedra
// and cloths.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime/io/scenes/nodal_readers.h"
#include "runtime/mixed/mixed_guests.h"

namespace tremolo {

// Adds the contacts of a guest. h: the step, s.
void add_guest_contacts(const MixedGuests& guests, std::size_t guest, double h,
                        nlohmann::ordered_json& json);

// Columns of a guest's hands, joints and loads: their energies, J; the force of all hands, N.
inline constexpr const char* kHeldColumns = ",hand,joint,hand_fx,hand_fy,hand_fz,load";
std::array<double, 6> held_values(const MixedGuests& guests, std::size_t guest);

// The motion of vertices of a guest's surface, or of particles.
class GuestProbes {
 public:
  // probes: each names one, as a hand's `at` does. pose: of a body of tetrahedra at t = 0. Errors:
  // those of guest_point().
  static Result<GuestProbes> create(const MixedGuests& guests, std::size_t guest,
                                    const std::vector<std::string>& probes, const Pose& pose = {});

  std::string columns() const;  // ",u5x,u5y,u5z" for vertex 5
  // Appends the distances from where the points were at t = 0, m, along the world's axes.
  void append_now(const MixedGuests& guests, std::vector<double>& values) const;

 private:
  struct Probe {
    std::size_t point = 0;
    Eigen::Vector3d start;  // m, world
    VertexId number = 0;
  };

  std::size_t guest_ = 0;
  std::vector<Probe> probes_;
};

// Values of the columns behind those of a guest's kind.
std::vector<double> further_values(const MixedGuests& guests, std::size_t guest,
                                   const GuestProbes& probes);

// Names of bodies of tetrahedra, then of cloths.
std::vector<std::string> guest_names(const MixedFile& mixed);

}  // namespace tremolo
