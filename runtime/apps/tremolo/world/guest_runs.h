// All guests in a run of a world: bodies of tetrahedra, then cloths.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime/apps/tremolo/world/world_cloth_run.h"
#include "runtime/apps/tremolo/world/world_tets_run.h"

namespace tremolo {

class GuestRuns {
 public:
  // mixed, guests: must outlive this object. first: the step at which the run begins. Errors: those
  // of WorldTetsRun and WorldClothRun.
  static Result<GuestRuns> create(const MixedFile& mixed, const WorldGuests& guests,
                                  std::int64_t first);

  // Takes the start and then every step.
  Status observe();
  // Sets the ending of the first body whose step failed or whose energy left its bound.
  void ended(RunEnding& ending) const;
  // Renames the files from their temporary names.
  Status finish();

  const MixedGuests* guests() const { return guests_; }  // null: none
  std::size_t size() const { return tets_.size() + cloths_.size(); }
  std::vector<nlohmann::ordered_json> json() const;  // one per body
  std::string inverted_text() const { return tets_.inverted_text(); }
  void print() const;
  std::vector<std::string> files() const;  // paths of all that was written

 private:
  const MixedGuests* guests_ = nullptr;
  WorldTetsRun tets_;
  WorldClothRun cloths_;
};

}  // namespace tremolo
