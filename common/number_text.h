// A number as an error message shows it.
#pragma once

#include <array>
#include <charconv>
#include <string>

namespace tremolo {

// Six digits, with an exponent where that is shorter: "0.003", "1e-300", "nan".
inline std::string number_text(double value) {
  std::array<char, 32> text;
  const auto result =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 6);
  return {text.data(), result.ptr};
}

}  // namespace tremolo
