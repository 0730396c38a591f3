// `tremolo run` of a scene whose [[bodies]] are of kind "tets".
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/result.h"
#include "formats/file/output_guard.h"
#include "runtime/program/run/run_options.h"
#include "runtime/scene_reader/tets_reader.h"

namespace tremolo {

// Applies command-line flags, which override the scene; those of a method apply to every body.
// degree: of --degree. given: whether a flag, such as "--step", is on the command line. Errors:
// kUsage for a flag that does not apply to these bodies or an unknown name; kContent for a value
// out of range.
Status apply_tets_flags(const RunOptions& flags, const std::string& degree,
                        const std::function<bool(const char*)>& given, TetScene& scene);

// The files that a run reads.
std::vector<NamedFile> inputs_of(const TetScene& scene);

// Runs the scene. json: one object on stdout, also when the run failed. The exit code; errors are
// printed on stderr.
int run_tets_command(const TetScene& scene, bool json);

}  // namespace tremolo
