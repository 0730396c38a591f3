// Base64 (RFC 4648) as used in XML.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <string_view>

namespace tremolo {

// bytes: the decoded ones. bad_at: position of the first invalid character, or npos if the text is
// complete.
struct DecodedBase64 {
  std::string bytes;
  std::size_t bad_at = std::string_view::npos;
};

// Blanks and line ends are skipped. Several padded texts may follow each other, from writers that
// encode a header separately. Stops once it has `most` bytes, or up to two more.
DecodedBase64 decode_base64(std::string_view text,
                            std::size_t most = std::numeric_limits<std::size_t>::max());

// Padded, without line ends.
std::string encode_base64(std::string_view bytes);

}  // namespace tremolo
