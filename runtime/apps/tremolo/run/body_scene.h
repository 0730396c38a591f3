// One body by itself, as a scene of one body.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/apps/tremolo/run/run_options.h"
#include "runtime/integrator.h"
#include "runtime/io/scenes/scene_reader.h"

namespace tremolo {

// A scene of one body with one load, and the options that scenes with [[bodies]] do not have.
struct BodyScene {
  SceneFile file;         // path: empty without a scene file; files: the CSV of --signal
  std::string load_name;  // or the path of its CSV, for reports
  std::string deflect;    // "5%": the load is scaled to this motion; empty: it is not
  std::string start;      // start_state.h; empty: at rest
  std::string rescale;    // another material (rescale_model()); empty: that of the file

  SceneBody& body() { return file.scene.bodies.front(); }
  const SceneBody& body() const { return file.scene.bodies.front(); }
  // Of the kind kNone for --load none.
  SceneLoad& load() { return body().loads.front(); }
  const SceneLoad& load() const { return body().loads.front(); }
  double step() const { return file.scene.step; }  // s
  // The integrator's options with this step.
  IntegratorOptions settings() const;
};

// Puts the flags of a model, a method and columns on a body. Errors: kUsage for a
// text of the wrong form.
Status apply_to_body(const GivenFlags& flags, SceneBody& body);

// Flags and keys become a scene; reads the CSV of --signal. Errors: kUsage for a name or a text of
// the wrong form and for options that exclude each other; kContent for a value out of range; those
// of read_signal().
Result<BodyScene> body_scene(const RunOptions& options);

// The bodies of a scene with one table per body, with the flags over their keys; several bodies
// have a folder each in --out. path: of the scene, for errors. Errors also kUsage for --wav, --save
// and --restore with several.
Result<std::vector<BodyScene>> body_scenes(std::vector<RunOptions> tables, const GivenFlags& flags,
                                           const std::string& path);
// The same for the scene's text; errors of parse_scene().
Result<std::vector<BodyScene>> body_scenes(const std::string& text, const GivenFlags& flags,
                                           const std::string& path);
// The body of a basis file.
Result<std::vector<BodyScene>> model_scene(const std::string& path, const GivenFlags& flags);

}  // namespace tremolo
