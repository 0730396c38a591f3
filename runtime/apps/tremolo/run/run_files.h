// The files of a run's folder.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "formats/file/output_guard.h"
#include "runtime/apps/tremolo/run/body_scene.h"
#include "runtime/apps/tremolo/run/earlier_run.h"

namespace tremolo {

inline constexpr const char* kTableName = "run.csv";
inline constexpr const char* kReportName = "report.json";
inline constexpr int kReportSchema =
    1;  // `schema` of reports: raised when a key changes its meaning
inline constexpr const char* kFramesName = "frames.csv";      // the surfaces' times
inline constexpr const char* kMaterialsName = "surface.mtl";  // of surfaces as .obj

// "surface-0012-t1.500000s.ply": the frame's number from 0 and its time, s.
std::string frame_name(int frame, double time, const std::string& format);

// The files that a run reads: the model, the scene, --signal, --start, --restore and lists
// of ids.
std::vector<NamedFile> inputs_of(const BodyScene& scene);
// Adds the lists of ids named in a selector, or a vertex's number. whose: "--at".
void add_ids_of(const std::string& selector, const std::string& whose,
                std::vector<NamedFile>& inputs);

// All files that a run writes or removes. They are known, and known to be writable, before the
// first step.
class RunOutputs {
 public:
  // A file that a flag names; empty: none. Its folder must be there.
  void add(const std::string& path);
  // The folder of a run, made if need be; empty: none. bodies: names of folders in it.
  void add_folder(const std::string& folder, const std::vector<std::string>& bodies = {});
  // Files in a folder that was added; in those of some of its bodies.
  void add_files(const std::string& folder, const std::vector<const char*>& names);
  void add_files(const std::string& folder, const std::vector<std::string>& bodies,
                 const std::vector<const char*>& names);

  // Errors: kUsage if one of them is an input, another output or a folder for another output;
  // kSystem if one cannot be written.
  Status check(const std::vector<NamedFile>& inputs) const;

  // Removes files of earlier runs, found in the folders when these were added, except those in
  // `written` (paths). Errors: kSystem.
  Status remove_earlier(const std::vector<std::string>& written) const;

 private:
  std::vector<std::string> folders_, named_, in_folders_;
  std::vector<EarlierRun> earlier_;
};

// The files that a run of these bodies writes. Several bodies have one folder each, NAME in the
// requested folder, which also gets the report of all.
RunOutputs outputs_of(const std::vector<BodyScene>& bodies);

// The folder requested as the bodies' --out; for a single body its own.
std::string folder_of_all(const BodyScene& body, const std::vector<BodyScene>& bodies);

// Names of the files of one body in its folder.
const std::vector<const char*>& body_files();

// "run.csv, energy.svg, 50 surfaces" of paths.
std::string list_files(const std::vector<std::string>& files);

}  // namespace tremolo
