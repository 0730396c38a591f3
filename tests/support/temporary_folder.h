// A folder of its own for a test, removed at its end.
#pragma once

#include <deque>
#include <filesystem>
#include <fstream>
#include <stdlib.h>
#include <string>

namespace tremolo::testing {

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "tremolo-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::filesystem::filesystem_error(pattern, {});
    path_ = pattern;
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::string path() const { return path_.string(); }
  std::string file(const std::string& name) const { return (path_ / name).string(); }
  std::string write(const std::string& name, const std::string& bytes) const {
    // Some file systems flush a file that was truncated and written again; thousands of those are
    // slow.
    std::filesystem::remove(file(name));
    std::ofstream(file(name), std::ios::binary) << bytes;
    return file(name);
  }

 private:
  std::filesystem::path path_;
};

// A fresh folder that lives as long as the process: tests run side by side.
inline std::string fresh_folder() {
  static std::deque<TemporaryFolder> folders;
  return folders.emplace_back().path();
}

}  // namespace tremolo::testing
