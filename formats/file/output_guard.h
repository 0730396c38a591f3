// Protects inputs and outputs: no output may overwrite an input or another output.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace tremolo {

// A file of a command line.
struct NamedFile {
  std::string path;
  std::string role = {};  // for messages: "the mesh", "--config"; empty for an output
  // It may name further files in its folder or below, which are read with it: textures and
  // materials of a surface, *INCLUDE and .node/.ele of a mesh.
  bool names_others = false;
};

// True if both paths lead to one file: the same inode, through any links; if one of them does not
// exist, the same resolved path.
bool same_file(const std::string& a, const std::string& b);

// Error (kUsage) if an output is one of the inputs, one of their further files, another output, or
// would be a folder of another output; the message names both. Empty paths are skipped. Call it
// before anything is written. The time is linear in the number of outputs.
Status keep_apart(const std::vector<std::string>& outputs, const std::vector<NamedFile>& inputs);

// Error (kSystem) if one of the files cannot be written: the existing one is not a regular file, or
// no file can be created in its folder. A missing folder is an error unless `makes_folders` is set
// and it can be created. No trial file remains. Empty paths are skipped.
Status check_writable(const std::vector<std::string>& outputs, bool makes_folders = false);

// The files of a folder whose names match, which a numbered output would replace or which are
// removed as results of earlier runs: they count as outputs, too. Empty if there is no such folder.
std::vector<std::string> files_like(const std::string& folder,
                                    const std::function<bool(std::string_view name)>& matches);

// While an object exists, no AtomicFile, no film and no remove_result() of this process replaces or
// removes one of the inputs, even for outputs that were not known before. It is the last protection
// after keep_apart(), for programs. There may be one object at a time.
class GuardedInputs {
 public:
  explicit GuardedInputs(const std::vector<NamedFile>& inputs);
  ~GuardedInputs();
  GuardedInputs(const GuardedInputs&) = delete;
  GuardedInputs& operator=(const GuardedInputs&) = delete;
};

// Error (kUsage) if `output` is one of the inputs guarded at present.
Status check_replaceable(const std::string& output);

// Removes a result of an earlier run; a missing one is not an error. Errors: as for
// check_replaceable(); kSystem.
Status remove_result(const std::string& path);

}  // namespace tremolo
