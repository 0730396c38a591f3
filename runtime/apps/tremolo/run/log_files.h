// Files that the logs of all kinds of bodies write during a run: a table and numbered surfaces.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/result.h"
#include "formats/file/atomic_file.h"
#include "runtime/io/scenes/scene_keys.h"

namespace tremolo {

// Makes the folder of a run and those above it; empty: none. Errors: kSystem.
Status make_run_folder(const std::string& folder);

// The outputs of one of several bodies: in the folder of its name in that of all.
SceneOutputs outputs_of_body(const SceneOutputs& all, const std::string& body);

// The table in the folder of the outputs; empty: nothing is written.
std::string table_path(const SceneOutputs& outputs);

// A CSV file. Whole lines are written to a temporary file, which finish() renames.
class CsvTable {
 public:
  CsvTable() = default;  // nothing is written
  // path: empty: nothing is written. head: the names of the columns. parked: the file is closed
  // between pieces, for runs with more tables than a process may have open files. Errors: kSystem.
  static Result<CsvTable> create(const std::string& path, std::string head, bool parked = false);

  bool is_written() const { return file_ != nullptr; }
  // The text to which the present row is appended.
  std::string& row() { return text_; }
  Status end_row();
  // Writes the buffered rows, so that they can be read in the temporary file.
  Status flush();
  Status finish();

 private:
  std::string text_;
  std::unique_ptr<AtomicFile> file_;  // null: nothing is written
  bool parked_ = false;
};

// The steps of a run: of its start, not 0 if it was restored, and of its end.
struct StepRange {
  std::int64_t first = 0, last = 0;
};

// Surfaces of one body, evenly spaced in time, in the folder of its outputs, which is there.
class Frames {
 public:
  Frames() = default;  // nothing is written
  // outputs: the body's folder, the number of surfaces and their format. Those that were due up to
  // the start of a restored run are not written.
  Frames(const SceneOutputs& outputs, StepRange steps);

  // True if a surface is due after `steps` steps. Surfaces are due at k/N of the run, k = 1 ... N.
  bool due(std::int64_t steps) const;
  // Calls `write` with the path of the next surface. time: s.
  Status write(double time, const std::function<Status(const std::string& path)>& write);
  // Writes frames.csv (frame, t in s, file) if there are surfaces.
  Status finish();

  const std::vector<std::string>& files() const { return files_; }  // paths, all that is written

 private:
  std::string folder_, format_;
  int count_ = 0, next_ = 0;
  std::int64_t steps_ = 0;
  std::string list_ = "frame,t,file\n";
  std::vector<std::string> files_;
};

// Completes surfaces and the table of one body's outputs. files: all paths are added.
Status finish_files(const SceneOutputs& outputs, Frames& frames, CsvTable& table,
                    std::vector<std::string>& files);

}  // namespace tremolo
