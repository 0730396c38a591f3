#pragma once

namespace tremolo {

// The largest number of threads that may be requested: no machine can use more, and a refusal by
// the system takes seconds.
inline constexpr unsigned kMostThreads = 1024;

}  // namespace tremolo
