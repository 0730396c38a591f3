// What earlier runs left in the folder of a run.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace tremolo {

// Whether a surface of a run may have this name: as frame_name() makes it, now or without the time
// in earlier versions.
bool is_frame_name(std::string_view name);

// Files in a run's folder that a program of ours wrote in an earlier run. A file is known by its
// name together with what stands in it, in a list of surfaces or in report.json: one that somebody
// else put there is none, whatever its name.
class EarlierRun {
 public:
  // What is there now; it must be asked before the run writes. bodies: names of folders in `folder`
  // that the run will have; others are looked at where the earlier report.json says that they were
  // of its bodies. No folder: no files.
  static EarlierRun in(const std::string& folder, const std::vector<std::string>& bodies = {});

  const std::vector<std::string>& files() const { return files_; }  // paths, each once

  // Removes the files that are not in `written` (paths), and folders of bodies that are empty then.
  // Errors: kSystem.
  Status remove(const std::vector<std::string>& written) const;

 private:
  void look_into(const std::string& folder, bool reported);
  void add(const std::string& path);

  std::vector<std::string> files_;
  std::vector<std::string> old_bodies_;  // folders
};

}  // namespace tremolo
