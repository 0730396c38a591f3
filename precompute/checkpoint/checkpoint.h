// Finished stages in the folder OUTPUT.checkpoint, so that a run that was ended goes on where it
// was. A stage is one file a rank, STAGE.RANK, written under another name and renamed: it is there
// whole or not at all. When the basis file is written the folder goes.
//
// A run that finds its stages gives the same basis file, byte for byte, as one that makes them:
// what goes into that file or into a later stage is in the stage's file, and nothing that differs
// from run to run.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/stage_log.h"
#include "formats/file/checkpoint_file.h"
#include "precompute/problem/model_request.h"
#include "precompute/problem/problem.h"

namespace tremolo {

// What a stage belongs to: everything that changes a bit of it, by names that a user understands.
using CheckpointIdentity = std::vector<std::pair<std::string, std::string>>;

// counts: as chosen, not as asked for. What only shapes the file at the end (the render surface,
// the load, the encoding) or stands beside the model (the certificate) is not part of it.
CheckpointIdentity checkpoint_identity(const ModelRequest& request, const Problem& problem,
                                       const ModeCounts& counts, LinearSolver solver,
                                       int blas_threads);
inline constexpr const char* kSolverFact = "solver";

// Of a run that writes this basis file.
std::string checkpoint_folder(const std::string& output_path);

// When stages are to be resumed, who solved for those that are there; the same on all ranks. None:
// there are none that tell.
std::optional<LinearSolver> kept_solver(const CheckpointRequest& request);

// The stages that checkpoint_stages.h reads and writes. All ranks call everything together.
class Checkpoint {
 public:
  // Unless stages are to be kept nothing is read or written. When they are to be resumed those that
  // are there are of use; SharedFailure (kContent) if they are of another identity. Else they are
  // removed.
  Checkpoint(const CheckpointRequest& request, const CheckpointIdentity& identity, StageLog& log);

  // Calls `take` with the stage's file, which may throw Failure. False when there is no such file
  // or, with a note, when some rank's cannot be used: the stage is to be made again.
  bool find(const std::string& stage, const std::function<void(const CheckpointFile&)>& take);

  // A failure is a warning; no further stage is kept then.
  void keep(const std::string& stage, std::vector<NamedArray> arrays);

  // Whether some stage was found.
  bool found() const { return found_; }

  // For a stage that no later one needs; frees its room on the disk.
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

// To be called when the run's outputs are written: removes the stages, of all ranks, and the folder
// if nothing else is in it. A failure is a note.
void remove_checkpoint(const CheckpointRequest& request, const StageLog& log);

}  // namespace tremolo
