#include "formats/file/input_file.h"

#include <fcntl.h>
#include <span>
#include <sys/mman.h>
#include <unistd.h>
#include <utility>

#include "common/hash.h"
#include "common/result.h"

namespace tremolo {
namespace {

const char* kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a pipe: write to a file what comes through it, and name that";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

Error not_regular(const std::string& path, mode_t mode) {
  return system_error(path + ": not a regular file but " + kind_of(mode));
}

Error failure(const std::string& path, const char* what) {
  return os_error(path + ": cannot " + what);
}

}  // namespace

Result<struct stat> examine_input(const std::string& path) {
  struct stat status = {};
  if (::stat(path.c_str(), &status) != 0) return failure(path, "open");
  if (!S_ISREG(status.st_mode)) return not_regular(path, status.st_mode);
  return status;
}

Result<InputFile> open_input(const std::string& path) {
  const Result<struct stat> seen = examine_input(path);
  if (!seen) return seen.error();
  // O_NONBLOCK, because the path may lead to another kind of file meanwhile.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (descriptor < 0) return failure(path, "open");
  struct stat status = {};
  if (::fstat(descriptor, &status) != 0) {
    const Error error = failure(path, "examine");
    ::close(descriptor);
    return error;
  }
  if (!S_ISREG(status.st_mode)) {
    ::close(descriptor);
    return not_regular(path, status.st_mode);
  }
  return InputFile{descriptor, static_cast<std::uint64_t>(status.st_size)};
}

Result<MappedFile> MappedFile::open(const std::string& path) {
  const Result<InputFile> input = open_input(path);
  if (!input) return input.error();
  MappedFile file;
  if (input->size > 0) {
    const std::size_t size = input->size;
    void* address = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, input->descriptor, 0);
    if (address == MAP_FAILED) {
      const Error error = os_error(path + ": cannot map");
      ::close(input->descriptor);
      return error;
    }
    file.bytes_ = {static_cast<const std::byte*>(address), size};
  }
  ::close(input->descriptor);
  return file;
}

MappedFile::MappedFile(MappedFile&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
  std::swap(bytes_, other.bytes_);
  return *this;
}

MappedFile::~MappedFile() {
  if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

Result<std::string> read_whole_file(const std::string& path) {
  const Result<MappedFile> file = MappedFile::open(path);
  if (!file) return file.error();
  const auto bytes = file->bytes();
  if (bytes.empty()) return content_error(path + ": the file is empty");
  // A copy, so that a file that changes while it is parsed cannot change under the parser.
  return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

std::string checksum(std::string_view bytes) {
  return hash_text(hash_bytes(std::as_bytes(std::span(bytes.data(), bytes.size()))));
}

Result<std::string> program_checksum() {
  const Result<MappedFile> program = MappedFile::open("/proc/self/exe");
  if (!program) return program.error();
  return hash_text(hash_bytes(program->bytes()));
}

}  // namespace tremolo
