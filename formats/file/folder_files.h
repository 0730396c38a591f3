// The files that assimp may open: those of one folder.
#pragma once

#include <assimp/IOSystem.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tremolo {

// Opens the file `path`, and files in its folder or below, for reading; only regular files. A link
// out of the folder is followed only for `path`.
class FolderFiles : public Assimp::IOSystem {
 public:
  explicit FolderFiles(const std::string& path);

  bool Exists(const char* name) const override;
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* name, const char* mode) override;
  void Close(Assimp::IOStream* stream) override;

  // Replaces the file's own bytes from now on.
  void replace_file(std::string bytes) { replacement_ = std::move(bytes); }
  // The bytes of a file that may be opened; empty for any other.
  std::string contents(const std::string& name);

  // Requested names that are outside the folder or not regular files; each once, at most ten.
  const std::vector<std::string>& refused() const { return refused_; }

 private:
  // Empty if there is no such file here.
  std::filesystem::path resolve(const std::string& name) const;
  void refuse(const std::string& name);

  std::filesystem::path file_;
  std::filesystem::path real_file_;
  std::filesystem::path folder_;
  std::vector<std::string> refused_;
  std::optional<std::string> replacement_;
};

}  // namespace tremolo
