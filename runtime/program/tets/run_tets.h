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

// The flags of a command line over what the scene says; those of a method are for every body.
// degree: of --degree. told: whether a flag, as "--step", was given. Errors: kUsage for a flag that
// these bodies do not take or an unknown name; kContent for a value out of range.
Status apply_tets_flags(const RunOptions& flags, const std::string& degree,
                        const std::function<bool(const char*)>& told, TetScene& scene);

// The files that a run reads.
std::vector<NamedFile> inputs_of(const TetScene& scene);

// Runs the scene. json: one object on stdout, also when the run failed. The exit code; errors are
// printed on stderr.
int run_tets_command(const TetScene& scene, bool json);

}  // namespace tremolo
