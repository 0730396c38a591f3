// `tremolo run` and `inspect` of a scene with several bodies.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "formats/file/output_guard.h"
#include "runtime/apps/tremolo/run/body_scene.h"
#include "runtime/io/scenes/nodal_readers.h"
#include "runtime/io/scenes/scene_reader.h"

namespace tremolo {

// Applies command-line flags, which override the scene; those of a method apply to every body.
// Errors: kUsage for a flag that
// does not apply to a world or names something that does not exist; kContent for a value out of
// range.
Status apply_flags(const GivenFlags& flags, SceneFile& file);
// The same for a scene that may have bodies of tetrahedra. Errors (kUsage) also for flags of a
// method with some.
Status apply_flags(const GivenFlags& flags, MixedFile& mixed);

// "fixed", "driven", "free" or "rigid".
const char* kind_name(const SceneBody& body);
// The file of the model or the mesh, or the name of a rigid body's shape.
std::string solid_name(const SceneBody& body);

// The files that a run of the scene reads; of the scene alone: those that its parts name.
std::vector<NamedFile> inputs_of(const Scene& scene);
std::vector<NamedFile> inputs_of(const SceneFile& file);
std::vector<NamedFile> inputs_of(const MixedFile& mixed);

// Runs the scene. threads: that step its bodies, 0: one per core. json: one object on stdout, also
// when the run failed. Returns the exit code; errors are printed on stderr.
int run_world_command(const MixedFile& mixed, unsigned threads, bool json);

// A scene with [[bodies]]; returns the exit code. Errors are those with which a run would end
// before its first step.
int inspect_world_command(const MixedFile& mixed, bool json);

// For a scene with one table per body; each body is in a world of its own.
int inspect_bodies_command(const std::vector<BodyScene>& bodies, bool json);

}  // namespace tremolo
