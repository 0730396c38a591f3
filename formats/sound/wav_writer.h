// Sound -> WAV.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "common/result.h"

namespace tremolo {

// One channel of 16-bit PCM, `rate` samples per second. samples: -1 to 1, clipped beyond. Written
// whole or not at all. kContent for more samples than the format's 32 bits can count, kSystem if
// the file cannot be written.
Status write_wav(const std::string& path, std::uint32_t rate, std::span<const double> samples);

}  // namespace tremolo
