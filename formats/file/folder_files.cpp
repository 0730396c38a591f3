#include "formats/file/folder_files.h"

#include <algorithm>
#include <assimp/DefaultIOStream.h>
#include <assimp/MemoryIOWrapper.h>
#include <cstdio>
#include <fcntl.h>
#include <string_view>
#include <sys/stat.h>
#include <unistd.h>

namespace tremolo {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostRefused = 10;

class RegularFile : public Assimp::DefaultIOStream {
 public:
  RegularFile(std::FILE* file, const std::string& name) : DefaultIOStream(file, name) {}
};

bool lies_in(const fs::path& file, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first ==
         folder.end();
}

}  // namespace

FolderFiles::FolderFiles(const std::string& path) {
  std::error_code none;
  file_ = fs::absolute(path, none).lexically_normal();
  real_file_ = fs::canonical(file_, none);
  folder_ = fs::canonical(file_.parent_path(), none);
}

fs::path FolderFiles::resolve(const std::string& name) const {
  // Importers give the name relative to the file's folder, or without a folder.
  std::error_code none;
  const fs::path wanted = fs::path(name).is_absolute() ? fs::path(name) : folder_ / name;
  const fs::path real = fs::canonical(wanted, none);
  if (none) return {};
  return real;
}

bool FolderFiles::Exists(const char* name) const {
  const fs::path real = resolve(name);
  return !real.empty() && (real == real_file_ || lies_in(real, folder_));
}

void FolderFiles::refuse(const std::string& name) {
  if (refused_.size() < kMostRefused &&
      std::find(refused_.begin(), refused_.end(), name) == refused_.end())
    refused_.push_back(name);
}

Assimp::IOStream* FolderFiles::Open(const char* name, const char* mode) {
  if (std::string_view(mode).find_first_of("wa+") != std::string_view::npos) return nullptr;
  const fs::path real = resolve(name);
  if (real.empty()) return nullptr;
  if (real != real_file_ && !lies_in(real, folder_)) {
    refuse(name);
    return nullptr;
  }
  if (replacement_ && real == real_file_)
    return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(replacement_->data()),
                                      replacement_->size());
  // O_NONBLOCK: to open a pipe would wait for its writer.
  const int descriptor = ::open(real.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  struct stat status = {};
  if (descriptor < 0 || ::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
    if (descriptor >= 0) ::close(descriptor);
    refuse(name);
    return nullptr;
  }
  std::FILE* file = ::fdopen(descriptor, "rb");
  if (file == nullptr) {
    ::close(descriptor);
    return nullptr;
  }
  return new RegularFile(file, real.string());
}

std::string FolderFiles::contents(const std::string& name) {
  Assimp::IOStream* stream = Open(name.c_str(), "rb");
  if (stream == nullptr) return {};
  std::string bytes(stream->FileSize(), '\0');
  const bool whole = stream->Read(bytes.data(), 1, bytes.size()) == bytes.size();
  Close(stream);
  return whole ? bytes : std::string();
}

void FolderFiles::Close(Assimp::IOStream* stream) {
  delete stream;
}

}  // namespace tremolo
