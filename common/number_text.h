// A number as an error message shows it.
#pragma once

#include <array>
#include <string>

#include "common/decimal.h"

namespace tremolo {

// Six digits, with an exponent where that is shorter: "0.003", "1e-300", "nan".
inline std::string number_text(double value) {
  std::array<char, 32> text;
  return {text.data(), write_decimal(text.data(), text.data() + text.size(), value)};
}

}  // namespace tremolo
