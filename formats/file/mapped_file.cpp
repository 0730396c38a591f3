#include "formats/file/mapped_file.h"

#include <sys/mman.h>
#include <unistd.h>
#include <utility>

#include "formats/file/input_file.h"
#include "formats/file/os_error.h"

namespace tremolo {

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

}  // namespace tremolo
