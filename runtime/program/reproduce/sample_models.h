// The sample models that `tremolo reproduce` runs.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/model.h"

namespace tremolo::reproduce {

// checksum: of the file's bytes, 16 hexadecimal digits.
struct SampleModel {
  std::string name;
  std::string checksum;
  Model::Pointer model;
};

// names: of thesis::kModels, in any order; empty for all six. The result is in the thesis's order.
// Errors: kUsage for an unknown or a repeated name (the message lists the known), kSystem for a
// missing file, what Model::load gives, kContent for a model without a default load.
Result<std::vector<SampleModel>> load_sample_models(const std::string& directory,
                                                    const std::vector<std::string>& names);

}  // namespace tremolo::reproduce
