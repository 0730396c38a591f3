#pragma once

namespace tremolo {

// The most threads that may be asked for: no machine has use for more, and to be refused by the
// system takes seconds.
inline constexpr unsigned kMostThreads = 1024;

}  // namespace tremolo
