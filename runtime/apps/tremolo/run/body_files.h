// The files of the run of one reduced body: its table, its surfaces and the page of its energy.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/result.h"
#include "runtime/apps/tremolo/run/log_files.h"
#include "runtime/apps/tremolo/run/recorder.h"
#include "runtime/body.h"
#include "runtime/io/scenes/scene_keys.h"

namespace tremolo {

class BodyFiles {
 public:
  // outputs: in the body's own folder, which is made; without a folder nothing is written. steps:
  // of the run. parked: as for CsvTable. Errors: kContent for a vertex that the model does
  // not have; kSystem.
  static Result<BodyFiles> create(const SceneOutputs& outputs, const RecordedColumns& columns,
                                  const Model& model, StepRange steps, bool parked = false);

  const std::string& folder() const { return outputs_.out; }  // empty: nothing is written
  // True if a row is due after `steps` steps.
  bool row_due(std::int64_t steps) const {
    return !folder().empty() && steps % outputs_.every == 0;
  }
  // further: as many values as there are further columns.
  Status write_row(const Moment& moment, const Energy& energy,
                   std::span<const double> further = {}) {
    return recorder_.record(moment, energy, further);
  }
  // Writes a surface if one is due. body: in the state of the moment.
  Status write_surface(const Moment& moment, const Body& body);
  // Writes the buffered rows, so that the temporary file can be followed.
  Status flush() { return recorder_.flush(); }
  // Renames the files from their temporary names and draws the page, if it is requested. label: of
  // its energy; empty: no page. files: all paths are added.
  Status finish(const Model& model, const std::string& label, std::vector<std::string>& files);

 private:
  BodyFiles(const SceneOutputs& outputs, Recorder recorder, StepRange steps)
      : outputs_(outputs), recorder_(std::move(recorder)), frames_(outputs, steps) {}

  SceneOutputs outputs_;
  Recorder recorder_;
  Frames frames_;
};

}  // namespace tremolo
