#include "formats/file/base64.h"

#include <algorithm>
#include <cstdint>

namespace tremolo {
namespace {

int digit_value(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

// Four characters, of which the last two may be padding, hold one to three bytes.
struct Quartet {
  std::uint32_t bits = 0;
  int characters = 0;
  int padding = 0;

  bool take(char c) {
    const int value = digit_value(c);
    if (c == '=' ? characters < 2 : (value < 0 || padding > 0)) return false;
    bits = bits << 6 | static_cast<std::uint32_t>(c == '=' ? 0 : value);
    padding += c == '=' ? 1 : 0;
    ++characters;
    return true;
  }
};

}  // namespace

DecodedBase64 decode_base64(std::string_view text, std::size_t most) {
  DecodedBase64 decoded;
  decoded.bytes.reserve(std::min(text.size() / 4 * 3, most < text.size() ? most + 2 : most));
  Quartet quartet;
  for (std::size_t at = 0; at < text.size() && decoded.bytes.size() < most; ++at) {
    const char c = text[at];
    if (c == ' ' || c == '\t' || c == '\r' || c == '\n') continue;
    if (!quartet.take(c)) {
      decoded.bad_at = at;
      return decoded;
    }
    if (quartet.characters < 4) continue;
    for (int byte = 0; byte < 3 - quartet.padding; ++byte)
      decoded.bytes.push_back(static_cast<char>(quartet.bits >> (16 - 8 * byte) & 0xffu));
    quartet = {};
  }
  if (quartet.characters != 0) decoded.bad_at = text.size();
  return decoded;
}

std::string encode_base64(std::string_view bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    const std::size_t held = std::min<std::size_t>(3, bytes.size() - at);
    std::uint32_t bits = 0;
    for (std::size_t byte = 0; byte < 3; ++byte)
      bits = bits << 8 | (byte < held ? static_cast<unsigned char>(bytes[at + byte]) : 0u);
    for (std::size_t digit = 0; digit < 4; ++digit)
      text += digit > held ? '=' : kDigits[bits >> (18 - 6 * digit) & 63u];
  }
  return text;
}

}  // namespace tremolo
