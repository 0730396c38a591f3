// The common start of window and off-screen pictures.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/apps/view/camera/camera.h"
#include "runtime/apps/view/draw/renderer.h"
#include "runtime/apps/view/live/live_world.h"
#include "runtime/apps/view/setup/viewer_options.h"
#include "runtime/apps/view/stage/stage.h"

namespace tremolo {

// The checked options; needs neither a world nor OpenGL.
struct ViewSetup {
  PictureSize size;
  UpAxis up = UpAxis::kZ;
  CameraWish camera;
  std::optional<Eigen::Vector3f> background;  // none: the studio
  std::vector<Eigen::Vector3f> paints;        // of each body and guest, linear light
  std::vector<StageImage> images;
  std::vector<std::optional<Material>>
      solids;  // of each body; empty if its model's file does not name it
};

// scene: as of shown_scene(): its gravity gives the up axis unless the options do. knows_stress:
// the stress of a body can be shown that is not among the scene's. Errors: kUsage, kContent, also
// for --colour stress if there is no body with a known material; kSystem for an image that cannot
// be read.
Result<ViewSetup> make_setup(const ViewerOptions& options, const Scene& scene,
                             bool knows_stress = false);

// Error kContent: --colour stress, and the stress of no body on the stage is known. Prints the
// names of bodies that keep their colour because they have no texture coordinates.
Status check_stage(const ViewerOptions& options, const Stage& stage);

// The camera that frames the stage's last pose.
Camera first_camera(const ViewSetup& setup, const Stage& stage);

// lights: of this kind of card, unless the options say how many. ground: its height, m.
PictureLook look_of(const ViewerOptions& options, const ViewSetup& setup, double ground,
                    bool has_ground, const LightCounts& lights);
template <class Stage>
PictureLook look_of(const ViewerOptions& options, const ViewSetup& setup, const Stage& stage,
                    const LightCounts& lights) {
  return look_of(options, setup, stage.ground(), stage.has_ground(), lights);
}

// The colour that an option names: body, moved, stress or degree.
ColourBy colour_by(const std::string& name);

// --lights N: a quarter of them in the lamp. At most kMostLights.
LightCounts light_counts(int lights, int side);

}  // namespace tremolo
