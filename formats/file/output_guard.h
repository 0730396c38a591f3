// No output takes the place of an input, or of another output.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace tremolo {

// A file of a command line. role: what it is, for messages: "the mesh", "--config"; empty for an
// output. names_others: what stands in it may name further files in its folder or below, which are
// read with it: textures and materials of a surface, *INCLUDE and .node/.ele of a mesh.
struct NamedFile {
  std::string path;
  std::string role = {};
  bool names_others = false;
};

// Whether both paths lead to one file: the same inode, through whatever links and spellings; where
// one of them is not there yet, the same place.
bool same_file(const std::string& a, const std::string& b);

// Error (kUsage) if an output is one of the inputs, one of their further files, another output, or
// would be a folder of another output; the message names both. Empty paths are passed over. It must
// be asked before anything is written. The time is linear in the number of outputs.
Status keep_apart(const std::vector<std::string>& outputs, const std::vector<NamedFile>& inputs);

// Error (kSystem) if one of the files cannot be written: what stands there is no regular file, or
// no file can be made in its folder. A folder that is not there yet must be one that can be made if
// `makes_folders`, else it is an error. Nothing stays behind. Empty paths are passed over.
Status check_writable(const std::vector<std::string>& outputs, bool makes_folders = false);

// The files of a folder whose names match: those that a numbered output would replace or that are
// removed as results of earlier runs. They are outputs too. Empty if there is no such folder.
std::vector<std::string> files_like(const std::string& folder,
                                    const std::function<bool(std::string_view name)>& matches);

// While an object exists, no AtomicFile, no film and no remove_result() of this process takes away
// one of the inputs, whatever the name and whenever: also of outputs that nobody could list before.
// The last line of defence behind keep_apart(), for programs. There may be one object at a time.
class GuardedInputs {
 public:
  explicit GuardedInputs(const std::vector<NamedFile>& inputs);
  ~GuardedInputs();
  GuardedInputs(const GuardedInputs&) = delete;
  GuardedInputs& operator=(const GuardedInputs&) = delete;
};

// Error (kUsage) if `output` is one of the inputs that are guarded now.
Status check_replaceable(const std::string& output);

// Removes a result of an earlier run; one that is not there is removed already. Errors: as of
// check_replaceable(); kSystem.
Status remove_result(const std::string& path);

}  // namespace tremolo
