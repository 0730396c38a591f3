// Cloths in a run of a world: measurements, output files, report.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/result.h"
#include "runtime/apps/tremolo/measure/energy_balance.h"
#include "runtime/apps/tremolo/run/log_files.h"
#include "runtime/apps/tremolo/run/scene_ending.h"
#include "runtime/apps/tremolo/world/guest_report.h"
#include "runtime/io/scenes/nodal_readers.h"
#include "runtime/world/world_guests.h"

namespace tremolo {

class WorldClothRun {
 public:
  // Makes the folders of the cloths. mixed: may have no cloth; it and guests must outlive this
  // object. first: the step at which the run begins. Errors: kSystem.
  static Result<WorldClothRun> create(const MixedFile& mixed, const WorldGuests& guests,
                                      std::int64_t first);

  // Takes the start and then every step.
  Status observe();
  // Sets the ending of the first cloth whose step failed or whose energy left its bound.
  void ended(RunEnding& ending) const;
  // Renames the files from their temporary names.
  Status finish();

  nlohmann::ordered_json body_json(std::size_t i) const;
  std::size_t size() const { return watched_.size(); }
  void print() const;
  std::vector<std::string> files() const;  // paths of all that was written

 private:
  // Energies of a cloth, J. Work is that since the start.
  struct Account {
    double kinetic = 0.0, elastic = 0.0, contact = 0.0;
    ClothWork work;
    double given = 0.0, restitution = 0.0, friction = 0.0;  // by contact; the last two not positive
    double hand = 0.0, joint = 0.0, load = 0.0;

    double total() const { return kinetic + elastic + contact; }
    // Without the method itself.
    double by_causes() const {
      return work.gravity + work.wind + work.pins - work.damped + given + restitution + friction +
             hand + joint + load;
    }
    // Sum of the sizes of all energy exchanged.
    double turnover() const;
  };
  struct Watched : RunEnding {
    double at_start = 0.0;  // energy at t = 0, J
    Account now;
    EnergyBalance balance;
    Momenta momenta_start, momenta_now;
    SceneOutputs outputs;  // in the cloth's own folder
    CsvTable table;
    GuestProbes probes;
    Frames frames;
    std::vector<std::string> files;
  };

  const ClothStep& step_of(std::size_t i) const { return *guests_->guests->cloth(number(i)); }
  std::size_t number(std::size_t i) const { return guests_->of_cloth(i); }
  Account account_of(std::size_t i) const;
  void watch(std::size_t i, bool first);
  Status write(std::size_t i);

  const MixedFile* mixed_ = nullptr;
  const WorldGuests* guests_ = nullptr;
  std::vector<Watched> watched_;
  bool started_ = false;
};

}  // namespace tremolo
