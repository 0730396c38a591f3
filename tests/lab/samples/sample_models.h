// The sample models that `tremolo reproduce` runs.
#pragma once

#include <string>
#include <vector>

#include "runtime/model.h"

namespace tremolo::reproduce {

// checksum: of the file's bytes, 16 hexadecimal digits.
struct SampleModel {
  std::string name;
  std::string checksum;
  Model::Pointer model;
  std::vector<double> strain_gram = {};  // as BasisData has it
};

// names: of thesis::kModels, in any order; empty for all six. own: others are taken too,
// NAME.tremolo in the folder or the path of a basis file; they come last. The result is in the
// thesis's order. Throws a Failure: kUsage for an unknown or a repeated name (the message lists the
// known), kSystem for a missing file, what Model::load gives, kContent for a model without a
// default load.
std::vector<SampleModel> load_sample_models(const std::string& directory,
                                            const std::vector<std::string>& names,
                                            bool own = false);

// Throws a Failure (kUsage) if a report would overwrite one of the models: if a file in the folder
// `out` is, through any links, one of load_sample_models' arguments or in the folder `published`.
// Call it before anything is written.
void keep_models_apart(const std::string& out, const std::string& directory,
                       const std::vector<std::string>& names, const std::string& published = "");

}  // namespace tremolo::reproduce
