// Checkpoints: finished stages are saved in the folder OUTPUT.checkpoint, so that an interrupted
// run can be resumed. A stage is one file a rank, STAGE.RANK, written under another name and
// renamed, so it is either complete or absent. The folder is removed once the basis file is
// written.
//
// A resumed run writes the same basis file, byte for byte, as an uninterrupted one: a stage's file
// contains everything that the basis file or a later stage needs, and nothing that varies between
// runs.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/stage_log.h"
#include "formats/file/checkpoint_file.h"
#include "precompute/problem/precompute_request.h"
#include "precompute/problem/problem.h"

namespace tremolo {

// The inputs of a stage: everything that changes a bit of it, with names that a user understands.
using CheckpointIdentity = std::vector<std::pair<std::string, std::string>>;

// Returns the identity of a run. counts: the numbers chosen, not requested. Left out is what
// affects only the file at the end (render surface, load, encoding) or is kept beside the model
// (certificate).
CheckpointIdentity checkpoint_identity(const PrecomputeRequest& request, const Problem& problem,
                                       const ModeCounts& counts, LinearSolver solver,
                                       int blas_threads);
inline constexpr const char* kSolverFact = "solver";

// Returns the folder for a run that writes this basis file.
std::string checkpoint_folder(const std::string& output_path);

// Returns the solver that computed the stages in the folder, if they are to be resumed; the same on
// all ranks. None if no stage has the information.
std::optional<LinearSolver> kept_solver(const CheckpointRequest& request);

// Reads and writes the stages of checkpoint_stages.h. All members are collective.
class Checkpoint {
 public:
  // Reads and writes nothing unless request.keep is set. With request.resume existing stages are
  // used; throws SharedFailure (kContent) if their identity differs. Otherwise existing stages are
  // removed.
  Checkpoint(const CheckpointRequest& request, const CheckpointIdentity& identity, StageLog& log);

  // Calls `take`, which may throw Failure, with the stage's file. Returns false, so that the stage
  // must be computed, if there is no such file or, with a note, if the file of some rank cannot be
  // used.
  bool find(const std::string& stage, const std::function<void(const CheckpointFile&)>& take);

  // Saves a stage. If that fails, a warning is noted and no further stages are saved.
  void keep(const std::string& stage, std::vector<NamedArray> arrays);

  // Returns whether any stage was found.
  bool found() const { return found_; }

  // Removes a stage that no later one needs, to free disk space.
  void drop(const std::string& stage);

 private:
  std::string path(const std::string& stage) const;
  std::optional<CheckpointFile> open(const std::string& stage, std::string& problem) const;
  void make_folder();
  void require_same_identity(const CheckpointIdentity& identity);

  std::string folder_;
  std::string identity_;
  StageLog& log_;
  bool reading_ = false;
  bool writing_ = false;
  bool found_ = false;
};

// Removes the stages of all ranks, and the folder if it is empty then; to be called when all
// outputs are written. A failure is only noted.
void remove_checkpoint(const CheckpointRequest& request, const StageLog& log);

}  // namespace tremolo
