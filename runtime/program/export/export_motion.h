// `tremolo export` of a motion: runs it and writes files for other programs.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/program/export/export_page.h"
#include "runtime/program/export/frame_steps.h"
#include "runtime/program/export/motion_source.h"

namespace tremolo {

// Options of the export; the undocumented ones are as in GlbOptions.
struct MotionOutputs {
  std::string glb, pc2, mdd, pvd, usda, series, page;  // paths; empty: not requested
  PageExtras extras;  // of the page
  FrameRange range;
  std::size_t modes = 0;  // coordinates kept in the files; 0: all; the motion always has all
  bool plain_weights = false;
  bool no_normals = false;
  bool no_colliders = false;
  std::vector<std::string> textures;  // "MATERIAL=IMAGE" or "IMAGE"
  std::string up = "z";               // or "y", of the world
  std::string beside;                 // of cloth: a second scene, next to the first
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
