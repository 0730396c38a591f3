#include "runtime/apps/tremolo/world/guest_runs.h"

#include <utility>

namespace tremolo {

Result<GuestRuns> GuestRuns::create(const MixedFile& mixed, const WorldGuests& guests,
                                    std::int64_t first) {
  GuestRuns runs;
  runs.guests_ = guests.guests;
  if (Status s = take(runs.tets_, WorldTetsRun::create(mixed, guests, first)); !s) return s.error();
  if (Status s = take(runs.cloths_, WorldClothRun::create(mixed, guests, first)); !s)
    return s.error();
  return runs;
}

Status GuestRuns::observe() {
  if (Status s = tets_.observe(); !s) return s;
  return cloths_.observe();
}

void GuestRuns::ended(RunEnding& ending) const {
  tets_.ended(ending);
  cloths_.ended(ending);
}

Status GuestRuns::finish() {
  if (Status s = tets_.finish(); !s) return s;
  return cloths_.finish();
}

std::vector<nlohmann::ordered_json> GuestRuns::json() const {
  std::vector<nlohmann::ordered_json> json;
  for (std::size_t i = 0; i < tets_.size(); ++i) json.push_back(tets_.body_json(i));
  for (std::size_t i = 0; i < cloths_.size(); ++i) json.push_back(cloths_.body_json(i));
  return json;
}

void GuestRuns::print() const {
  tets_.print();
  cloths_.print();
}

std::vector<std::string> GuestRuns::files() const {
  std::vector<std::string> files = tets_.files();
  for (const std::string& file : cloths_.files()) files.push_back(file);
  return files;
}

}  // namespace tremolo
