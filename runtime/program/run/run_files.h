// The files of a run's folder.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "formats/file/output_guard.h"
#include "runtime/program/run/run_options.h"

namespace tremolo {

inline constexpr const char* kTableName = "run.csv";
inline constexpr const char* kReportName = "report.json";
inline constexpr const char* kFramesName = "frames.csv";      // which surface is of what time
inline constexpr const char* kMaterialsName = "surface.mtl";  // of surfaces as .obj

// "surface-0012-t1.500000s.ply": the frame's number from 0 and its time, s.
std::string frame_name(int frame, double time, const std::string& format);

// The files that a run reads: the model, the scene, --signal, --start and lists of ids.
std::vector<NamedFile> inputs_of(const RunOptions& options);

// Error (kUsage) if a file that the run writes, or one of an earlier run that it removes, is one
// that it reads: the model, the scene, --start, --signal or a list of ids.
Status keep_run_apart(const RunOptions& options);

// Surfaces, their lists and the picture of an earlier run into the same folder do not belong to
// this one: removes those that are not in `written` (paths).
Status remove_leftovers(const std::string& folder, const std::vector<std::string>& written);

// "run.csv, energy.svg, 50 surfaces" of paths.
std::string list_files(const std::vector<std::string>& files);

}  // namespace tremolo
