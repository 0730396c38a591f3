// `tremolo run` of a scene with [[cloths]].
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/result.h"
#include "formats/file/output_guard.h"
#include "runtime/program/run/run_options.h"
#include "runtime/scene_reader/cloth_reader.h"

namespace tremolo {

// Applies command-line flags, which override the scene. given: whether a flag, such as "--step", is
// on the command line. Errors: kUsage for a flag that does not apply to cloth or an unknown method;
// kContent for a value out of range.
Status apply_cloth_flags(const RunOptions& flags, const std::function<bool(const char*)>& given,
                         ClothFile& file);

// The files that a run of the scene reads.
std::vector<NamedFile> inputs_of(const ClothFile& file);

// Runs the scene. json: one object on stdout, also when the run failed. The exit code; errors are
// printed on stderr.
int run_cloth_command(const ClothFile& file, bool json);

}  // namespace tremolo
