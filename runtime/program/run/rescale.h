// `--rescale young=2e5,density=500`: a finished model of another stiffness or density.
#pragma once

#include <string>

#include "common/result.h"
#include "formats/basis/basis_data.h"

namespace tremolo {

// text: young (Pa) and density (kg/m^3), one or both, of the new material. The factors are those to
// the material in the file's provenance. Errors: kUsage for a text of another form or a value that
// is not positive and finite; kContent with the reason where it would not be exact: several
// materials, an orthotropic one where young is given, point masses where density is given, or a
// file that does not say its material.
Result<BasisData> rescale_model(BasisData data, const std::string& text, const std::string& path);

}  // namespace tremolo
