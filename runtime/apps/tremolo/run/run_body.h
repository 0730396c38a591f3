// Makes the world of a scene of one body.
#pragma once

#include <string>

#include "common/result.h"
#include "formats/basis/basis_data.h"
#include "runtime/apps/tremolo/run/body_scene.h"
#include "runtime/world/scene_world.h"

namespace tremolo {

// The model of the scene's body.
Result<Model::Pointer> load_model(const BodyScene& scene);

// The vertices of the scene's load and the force on each, unscaled; empty for --load none. Errors:
// those of selectors; kUsage for a model without a default load where the scene names none.
Result<DefaultLoad> load_of_run(const BodyScene& scene, const Model& model);

// A body before its run. It must outlive the world that world_of_one() makes of it.
struct RunInput {
  Model::Pointer model;
  BodyScene scene;
  DefaultLoad forces;  // load_of_run()
};

// Loads the model and finds the vertices of the load. Errors: those of load_model() and
// load_of_run().
Result<RunInput> load_body(const BodyScene& scene);

// The world of the scene's body alone, with its load, in the state of --start. Errors of
// SceneWorld::create, without the body's name, of Body::add_load, and of start_state.
Result<SceneWorld> world_of_one(const RunInput& input);

// The error of a world's body without that body's name, which a user of one body has not chosen;
// kContent for kUsage, since the scene's values are the cause.
Error error_of_body(Error error, const std::string& name);

// The largest reduced force of the load in time, r: of a square, a sine and a constant one; zero
// for an impulse, which is over before the body is where it would hold it, and for --signal.
Result<Eigen::VectorXd> largest_load(const RunInput& input);

// Turns the library's kUsage for a wrong argument into kContent: on the command line kUsage means
// an unknown flag or name, and a number out of range is an invalid value.
Error value_error(Error error);

// The share of --deflect: "5%" or "0.05". Errors: kUsage; kContent if it is not positive.
Result<double> parse_share(const std::string& text);

// `--rescale young=2e5,density=500`: a finished model of another stiffness or density. text: young
// (Pa) and density (kg/m^3), one or both, of the new material. The factors are those to the
// material in the file's provenance. Errors: kUsage for a text of another form or a value that is
// not positive and finite; kContent with the reason where it would not be exact: several materials,
// an orthotropic one where young is given, point masses where density is given, or a file that does
// not say its material.
Result<BasisData> rescale_model(BasisData data, const std::string& text, const std::string& path);

}  // namespace tremolo
