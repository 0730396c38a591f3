// `tremolo export` of what moves: a run goes into files that other programs open.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/program/export/export_page.h"
#include "runtime/program/export/frame_steps.h"
#include "runtime/program/export/motion_source.h"

namespace tremolo {

// Paths; empty: not asked for. modes: coordinates that are kept in the files, 0: all; the motion
// has all of them. textures: "MATERIAL=IMAGE" or "IMAGE". up: "z" or "y", of the world. The others
// as GlbOptions has them.
struct MotionOutputs {
  std::string glb, pc2, mdd, pvd, usda, series, page;
  PageExtras extras;  // of the page
  FrameRange range;
  std::size_t modes = 0;
  bool plain_weights = false;
  bool no_normals = false;
  bool no_colliders = false;
  std::vector<std::string> textures;
  std::string up = "z";
  std::string beside;  // of cloth: a second scene, beside the first
  bool json = false;

  bool any() const {
    return !glb.empty() || !pc2.empty() || !mdd.empty() || !pvd.empty() || !usda.empty() ||
           !series.empty() || !page.empty();
  }
};

// Runs the motion and writes the files; prints their names on stdout. Returns the exit code. Errors
// are printed; after one no new file remains, except complete files of a series.
int export_motion_command(const MotionOutputs& outputs, const MotionSource& source);

}  // namespace tremolo
