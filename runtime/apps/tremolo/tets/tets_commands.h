// `tremolo run`, `inspect` and `export` of a scene with tetrahedra.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "formats/file/output_guard.h"
#include "runtime/apps/tremolo/export/motion_source.h"
#include "runtime/apps/tremolo/run/run_options.h"
#include "runtime/io/scenes/nodal_readers.h"

namespace tremolo {

// Applies command-line flags, which override the scene; those of a method apply to every body.
// degree: of --degree. given: whether a flag, such as "--step", is on the command line. Errors:
// kUsage for a flag that does not apply to these bodies or an unknown name; kContent for a value
// out of range.
Status apply_tets_flags(const GivenFlags& flags, const std::string& degree, TetScene& scene);

// The files that a run reads.
std::vector<NamedFile> inputs_of(const TetScene& scene);

// Runs the scene. json: one object on stdout, also when the run failed. The exit code; errors are
// printed on stderr.
int run_tets_command(const TetScene& scene, bool json);

// `tremolo inspect` of scenes whose bodies are tetrahedra. Returns the exit code; errors are those
// with which a run would end before its first step.
int inspect_tets_command(const TetScene& scene, bool json);

// `tremolo export` of a scene whose [[bodies]] are of kind "tets". The drawn surfaces are first in
// its recording, then, if requested, colliders as scenery. A body's pose is the rigid motion of its
// mesh's frame that fits its surface best, and its displacements are the difference. Errors of
// record: those of make_tets_bodies and frame_steps; kSolver for a step that fails.
MotionSource tets_motion(TetScene scene);

}  // namespace tremolo
