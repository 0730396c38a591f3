// `tremolo run`, `inspect` and `export` of a scene with [[cloths]].
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "formats/file/output_guard.h"
#include "runtime/apps/tremolo/export/motion_source.h"
#include "runtime/apps/tremolo/output/warnings.h"
#include "runtime/apps/tremolo/run/run_options.h"
#include "runtime/io/scenes/nodal_readers.h"

namespace tremolo {

// Applies command-line flags, which override the scene. given: whether a flag, such as "--step", is
// on the command line. Errors: kUsage for a flag that does not apply to cloth or an unknown method;
// kContent for a value out of range.
Status apply_cloth_flags(const GivenFlags& flags, ClothFile& file);

// The files that a run of the scene reads.
std::vector<NamedFile> inputs_of(const ClothFile& file);

// Runs the scene. json: one object on stdout, also when the run failed. The exit code; errors are
// printed on stderr.
int run_cloth_command(const ClothFile& file, bool json);

// Prints the particles, springs, triangles, mass and fastest oscillation of each cloth, and the
// longest stable step of methods with a limit. json: one object on stdout. Returns the exit code;
// errors are printed on stderr.
int inspect_cloth_command(const ClothFile& file, bool json);

// Colliders and fixed balls whose keyframes are relative to their `position`, and away from it at
// t = 0: a sentence for each.
Warnings keyframe_warnings(const ClothScene& scene);

// `tremolo export` of a scene with [[cloths]]. Scenes, at least one, each to the right of the
// previous one; a name that exists already gets "-2" appended. Cloths of a scene are first in its
// recording, then balls and, if requested, colliders as scenery, planes of the first scene only.
// Errors of record: those of ClothWorld::create and step, and of frame_steps; kContent if the
// frames of the scenes have different times.
MotionSource cloth_motion(std::vector<ClothFile> files);

}  // namespace tremolo
