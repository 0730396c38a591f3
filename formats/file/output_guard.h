// No output takes the place of an input, or of another output.
#pragma once

#include <string>
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

// Error (kUsage) if an output is one of the inputs, one of their further files, or another output;
// the message names both. Empty paths are passed over. To be asked before anything is written.
Status keep_apart(const std::vector<std::string>& outputs, const std::vector<NamedFile>& inputs);

}  // namespace tremolo
