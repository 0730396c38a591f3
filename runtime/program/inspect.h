// `tremolo inspect`.
#pragma once

#include <string>

namespace tremolo {

// Prints what a basis file holds and verifies every checksum; with a selector, the vertices that it
// chooses instead. The exit code; errors are printed on stderr.
int inspect_command(const std::string& path, const std::string& select, bool json);

}  // namespace tremolo
