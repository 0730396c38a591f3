// Writes the surfaces of a run, evenly spaced in time, and the list of them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/body.h"
#include "runtime/program/run/run_options.h"

namespace tremolo {

// Writes the present shape of `body` as it is drawn: its render surface, else the boundary.
// materials: the name of the .mtl file that an .obj refers to; empty: none. Errors: those of the
// writers.
Status write_shape(const Body& body, const std::string& path, const std::string& materials = "");

class Frames {
 public:
  // steps: of the whole run. The options must outlive this.
  Frames(const RunOptions& options, std::int64_t steps) : options_(options), steps_(steps) {}

  // True if a surface is due after `steps` steps. Surfaces are due at k/N of the run, k = 1 ... N.
  bool due(std::int64_t steps) const;
  // body: as it is at `time`, s.
  Status write(const Body& body, double time);
  // Writes frames.csv (frame, t in s, file) and, for .obj files with materials, surface.mtl.
  Status finish(const Model& model);

  const std::vector<std::string>& files() const { return files_; }  // paths, all that is written

 private:
  Status keep(const std::string& path, Status status);

  const RunOptions& options_;
  std::int64_t steps_;
  int written_ = 0;
  std::string list_ = "frame,t,file\n";
  std::vector<std::string> files_;
};

}  // namespace tremolo
