// The checkpoint file: header, table, every array as what it is and as what it is not.
#include "formats/file/checkpoint_file.h"
#include "tests/fuzz/harness.h"

void tremolo::fuzz::read_input(std::string_view bytes) {
  const Result<CheckpointFile> file =
      CheckpointFile::from_memory(std::as_bytes(std::span(bytes.data(), bytes.size())));
  check_error(file);
  if (!file) return;
  for (const NamedArray& array : file->arrays()) {
    const auto values = file->matrix(array.name);
    const auto integers = file->integers(array.name);
    const auto text = file->text(array.name);
    if (int{bool(values)} + int{bool(integers)} + int{bool(text)} > 1)
      finding("an array of two types");
    if (values && !values->allFinite()) finding("a number that is not finite");
    if (values && (static_cast<std::uint64_t>(values->rows()) != array.rows ||
                   static_cast<std::uint64_t>(values->cols()) != array.columns))
      finding("a matrix of another shape");
  }
  // Longer than a name can be: any other would be found out and written into an input.
  if (file->matrix(std::string(checkpoint_layout::kNameSize + 1, 'x')))
    finding("an array that is not there");
}
