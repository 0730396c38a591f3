// Bodies of tetrahedra in a run of a world: measurements, output files, report.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/result.h"
#include "runtime/apps/tremolo/measure/tets_log.h"
#include "runtime/apps/tremolo/run/scene_ending.h"
#include "runtime/apps/tremolo/world/guest_report.h"
#include "runtime/world/guest_bound.h"
#include "runtime/world/world_guests.h"

namespace tremolo {

class WorldTetsRun {
 public:
  // Makes the folders of the bodies. mixed: may have no bodies of tetrahedra; it and guests must
  // outlive this object. first: the step at which the run begins. Errors: those of
  // TetsLog::create().
  static Result<WorldTetsRun> create(const MixedFile& mixed, const WorldGuests& guests,
                                     std::int64_t first);

  // Takes the start and then every step.
  Status observe();
  // Sets the ending of the first body whose step failed or whose energy left its bound.
  void ended(RunEnding& ending) const;
  // Renames the files from their temporary names.
  Status finish();

  nlohmann::ordered_json body_json(std::size_t i) const;
  std::size_t size() const { return logs_.size(); }
  // "; 2 elements of 'cube' are inside out ..." for each body whose step failed; else empty.
  std::string inverted_text() const;
  void print() const;
  std::vector<std::string> files() const;  // paths of all that was written

 private:
  // Energies of a body, J. method: given by damping and by the method itself.
  struct Account {
    double kinetic = 0.0, elastic = 0.0, gravity = 0.0, contact = 0.0;
    double total() const { return kinetic + elastic + contact; }
  };
  struct Watched : RunEnding {
    Account start, now;
    double energy_max = 0.0;
    GuestBound bound;
    Momenta momenta_start, momenta_now;

    void leave_bound(double own, TetMethod method, double time);  // own: energy, J
  };

  void watch(std::size_t i, bool first);

  const MixedFile* mixed_ = nullptr;
  const WorldGuests* tets_ = nullptr;
  std::vector<TetsLog> logs_;
  std::vector<Watched> watched_;
  bool started_ = false;
  std::vector<Eigen::Vector3d> vertices_;
  std::vector<GuestProbes> probes_;
  std::vector<Eigen::Vector3f> normals_;
};

}  // namespace tremolo
