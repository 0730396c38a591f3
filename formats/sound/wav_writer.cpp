#include "formats/sound/wav_writer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "formats/file/atomic_file.h"

namespace tremolo {
namespace {

constexpr double kFullScale = 32767.0;

// Appends a value, little-endian.
void put(std::string& out, std::uint32_t value, int bytes) {
  for (int k = 0; k < bytes; ++k) out.push_back(static_cast<char>(value >> (8 * k) & 0xffU));
}

}  // namespace

Status write_wav(const std::string& path, std::uint32_t rate, std::span<const double> samples) {
  constexpr std::size_t kMost = 0x7fffffff / 2 - 64;
  if (samples.size() > kMost)
    return content_error(path + ": " + std::to_string(samples.size()) +
                         " samples are more than a WAV file can hold");
  const auto size = static_cast<std::uint32_t>(2 * samples.size());
  std::string out = "RIFF";
  out.reserve(44 + size);
  put(out, 36 + size, 4);
  out += "WAVEfmt ";
  put(out, 16, 4);        // of this chunk
  put(out, 1, 2);         // PCM
  put(out, 1, 2);         // channels
  put(out, rate, 4);      // samples a second
  put(out, 2 * rate, 4);  // bytes a second
  put(out, 2, 2);         // bytes a sample
  put(out, 16, 2);        // bits a sample
  out += "data";
  put(out, size, 4);
  for (const double sample : samples) {
    const double cut = std::isfinite(sample) ? std::clamp(sample, -1.0, 1.0) : 0.0;
    put(out, static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(kFullScale * cut))),
        2);
  }
  return write_file(path, out);
}

}  // namespace tremolo
