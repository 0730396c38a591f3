// Results that survive being stopped: one small file for each piece of work, so that a second start
// skips what has been done.
#pragma once

#include <functional>
#include <limits>
#include <string>

#include <nlohmann/json.hpp>

#include "common/result.h"

namespace tremolo {

// A number that was stored; `otherwise` for null, which is how one that is not finite comes back.
double to_number(const nlohmann::json& value,
                 double otherwise = std::numeric_limits<double>::quiet_NaN());

class Store {
 public:
  // directory: made if missing. Errors: kSystem.
  static Result<Store> open(const std::string& directory);

  // The result of the piece of work `name` (letters, digits, '-', '+', '.'), made by `work` unless
  // a file from an earlier start holds it under the same key. key: everything the result depends on
  // (model checksum, options, version of the computation); a file with another key is made anew. A
  // damaged file is made anew. Numbers that are not finite come back as null. Threads may ask at
  // once for different names. Errors: those of `work`, kSystem for an unwritable file, kUsage for a
  // name with other letters.
  Result<nlohmann::json> get(const std::string& name, const nlohmann::json& key,
                             const std::function<Result<nlohmann::json>()>& work) const;

 private:
  std::string directory_;
};

}  // namespace tremolo
