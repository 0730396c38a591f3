// Base64 (RFC 4648) as it stands in XML.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <string_view>

namespace tremolo {

// bytes: what was decoded. bad_at: place of the first character that does not belong there, or
// npos if the text is whole.
struct DecodedBase64 {
  std::string bytes;
  std::size_t bad_at = std::string_view::npos;
};

// Blanks and line ends are skipped. Several padded texts may stand behind each other, as writers
// that encode a header by itself leave them. Stops once it has `most` bytes, or up to two more.
DecodedBase64 decode_base64(std::string_view text,
                            std::size_t most = std::numeric_limits<std::size_t>::max());

// Padded, without line ends.
std::string encode_base64(std::string_view bytes);

}  // namespace tremolo
