// The command line of `tremolo` and of tremolo-nodal, which runs other kinds of scenes.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/result.h"
#include "runtime/apps/tremolo/export/motion_source.h"
#include "runtime/apps/tremolo/run/run_options.h"

namespace tremolo {

// The command line of a command that reads a scene.
struct SceneCommand {
  std::string file;  // path of the scene
  RunOptions flags;
  std::function<bool(const char*)> told;  // whether a flag, such as "--step", was given
  std::string degree;                     // of --degree; empty: not given
  bool json = false;
  std::string beside = {};  // of --beside; empty: not given
};

// Commands for scenes with [[cloths]] and with [[bodies]] of kind "tets". run_* and inspect_* print
// errors and return the exit code.
struct NodalScenes {
  int (*run_cloth)(const std::string& text, const SceneCommand& command);
  int (*run_tets)(const std::string& text, const SceneCommand& command);
  Result<std::unique_ptr<MotionSource>> (*cloth_motion)(const std::string& text,
                                                        const SceneCommand& command);
  Result<std::unique_ptr<MotionSource>> (*tets_motion)(const std::string& text,
                                                       const SceneCommand& command);
  int (*inspect_cloth)(const std::string& text, const SceneCommand& command);
  int (*inspect_tets)(const std::string& text, const SceneCommand& command);
};

// Parses the words and runs the command; returns the exit code. nodal: null if such scenes are run
// by another program, tremolo-nodal in the same folder.
int run_command_line(int count, char** words, const NodalScenes* nodal);

// `tremolo inspect`. Prints the contents of a basis file and verifies every checksum; with a
// selector, prints its vertices instead. Returns the exit code; errors are printed on stderr.
int inspect_command(const std::string& path, const std::string& select, bool json);

}  // namespace tremolo
