// Files of earlier runs in the folder of a run.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace tremolo {

// True if frame_name() makes such a name, now or in earlier versions, which left out the time.
bool is_frame_name(std::string_view name);

// Files in a run's folder that one of these programs wrote in an earlier run. A file is identified
// by its name together with its contents, a list of surfaces or report.json: a file from elsewhere
// is never one of them, whatever its name.
class EarlierRun {
 public:
  // Lists the files present now; call it before the run writes. bodies: folders in `folder` that
  // the run will have. Other folders are searched only if the earlier report.json lists them as its
  // bodies'. No folder: no files.
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
