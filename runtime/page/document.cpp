#include "runtime/page/document.h"

#include <tremolo_page_template.h>

namespace tremolo {

std::string page_document(std::string_view report) {
  constexpr std::string_view kMark = "%REPORT%";
  const std::string_view page = kPageTemplate;
  const std::size_t mark = page.find(kMark);
  std::string document(page.substr(0, mark));
  document.reserve(page.size() + report.size());
  // Escapes the character <, so that no text ends the page's script element; it appears only in
  // strings, where JSON allows the escape.
  for (const char c : report) c == '<' ? document += "\\u003c" : document += c;
  document += page.substr(mark + kMark.size());
  return document;
}

}  // namespace tremolo
