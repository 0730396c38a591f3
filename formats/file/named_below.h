// Files that stand in a file by their names: pieces, includes.
#pragma once

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>

namespace tremolo {

// The path of the file that `name` means in the file `owner`: one in the owner's folder or below,
// with / or \ between folders. None for any other: a file must not make a program open files
// elsewhere on the machine. Behind a NUL the system does not look: two names could be one file.
inline std::optional<std::string> named_below(const std::string& owner, std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  const std::filesystem::path below(name);
  if (name.empty() || below.is_absolute() || name.find('\0') != std::string::npos)
    return std::nullopt;
  for (const std::filesystem::path& part : below)
    if (part == "..") return std::nullopt;
  return (std::filesystem::path(owner).parent_path() / below).string();
}

}  // namespace tremolo
