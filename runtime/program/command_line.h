// The command line of `tremolo`, and of the program beside it that knows other kinds of scenes.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/result.h"
#include "runtime/program/export/motion_source.h"
#include "runtime/program/run/run_options.h"

namespace tremolo {

// What the command line says of a scene. file: its path. flags: as they were parsed; told: whether
// one, as "--step", was given. degree, beside: of --degree and --beside, empty where it was not
// given.
struct SceneCommand {
  std::string file;
  RunOptions flags;
  std::function<bool(const char*)> told;
  std::string degree;
  bool json = false;
  std::string beside = {};
};

// What is done with the text of a scene with [[cloths]], and of one with [[bodies]] of kind "tets".
// run_*, inspect_*: the exit code; errors are printed.
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

// Parses the words and does what they ask for; the exit code. nodal: null where another program,
// tremolo-nodal beside this one, is to be started for such scenes.
int run_command_line(int count, char** words, const NodalScenes* nodal);

}  // namespace tremolo
