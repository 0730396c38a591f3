#include "tests/lab/report/page.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

#include "formats/file/atomic_file.h"

namespace tremolo {
namespace {

constexpr std::string_view kStyle = R"css(
:root{color-scheme:light dark;--ink:#1c2126;--soft:#5b6670;--paper:#fff;--line:#d9dee3;--band:#f5f7f9;
--link:#0b5cab;--good:#17663a;--bad:#b3261e}
@media (prefers-color-scheme:dark){:root{--ink:#e4e8ec;--soft:#9aa5b0;--paper:#15181c;--line:#343b43;
--band:#1d2227;--link:#7fb8f0;--good:#6fcf97;--bad:#ff8a80}}
*{box-sizing:border-box}
html{-webkit-text-size-adjust:100%;scroll-behavior:smooth}
body{margin:0 auto;max-width:1100px;padding:2.5rem 1.25rem 5rem;background:var(--paper);color:var(--ink);
font:16px/1.55 system-ui,-apple-system,"Segoe UI",Roboto,"Helvetica Neue",Arial,sans-serif}
h1{font-size:2rem;line-height:1.2;margin:0 0 .4rem;letter-spacing:-.01em}
h2{font-size:1.4rem;line-height:1.25;margin:3rem 0 .8rem;padding-top:1rem;border-top:1px solid var(--line)}
h3{font-size:1.08rem;margin:2rem 0 .6rem}
p{max-width:46rem;margin:.7rem 0}
.subtitle{color:var(--soft);font-size:1.05rem;margin:0 0 1.5rem}
a{color:var(--link)}
nav ol{margin:.5rem 0;padding-left:1.4rem;columns:2 20rem}
nav li{margin:.15rem 0}
code{font:.9em ui-monospace,SFMono-Regular,Menlo,Consolas,monospace;background:var(--band);padding:.1em .3em;
border-radius:3px}
.scroll{overflow-x:auto;margin:1rem 0}
table{border-collapse:collapse;font-size:.875rem;font-variant-numeric:tabular-nums}
caption{text-align:left;color:var(--soft);padding:0 0 .5rem;font-size:.9rem}
th,td{padding:.35rem .75rem;border-bottom:1px solid var(--line);text-align:left;vertical-align:top}
th{font-weight:600;border-bottom:2px solid var(--line);vertical-align:bottom}
.n{text-align:right;white-space:nowrap}
.s{white-space:nowrap}
tbody tr:nth-child(even){background:var(--band)}
tbody .g td{border-top:2px solid var(--line)}
.met{color:var(--good);font-weight:600}
.missed{color:var(--bad);font-weight:700}
.shown{color:var(--soft)}
figure{margin:1.5rem 0}
.drawing{overflow-x:auto;background:#fff;border:1px solid var(--line);border-radius:6px;padding:.5rem}
.drawing svg{display:block;margin:0 auto;max-width:100%;height:auto}
figcaption{color:var(--soft);font-size:.9rem;margin-top:.5rem;max-width:46rem}
@media (max-width:640px){body{padding:1.5rem 1rem 3rem}h1{font-size:1.6rem}.drawing svg{max-width:none}
th,td{padding:.3rem .5rem}}
@media print{:root{--ink:#000;--soft:#444;--paper:#fff;--line:#bbb;--band:#f4f4f4;--link:#000;--good:#000;--bad:#000}
body{max-width:none;padding:0;font-size:10pt}.scroll,.drawing{overflow:visible}h2,h3{break-after:avoid}
figure,tr{break-inside:avoid}table{font-size:8pt}}
)css";

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  return result;
}

// Text with `code`; a backtick without a partner stays.
std::string marked_up(std::string_view text) {
  std::string result;
  while (true) {
    const std::size_t open = text.find('`');
    const std::size_t close = open == text.npos ? open : text.find('`', open + 1);
    if (close == text.npos) return result + escaped(text);
    result += escaped(text.substr(0, open)) + "<code>" +
              escaped(text.substr(open + 1, close - open - 1)) + "</code>";
    text.remove_prefix(close + 1);
  }
}

bool looks_like_number(const std::string& text) {
  const std::size_t digit = text.find_first_not_of("+-.<>=~ ");
  return digit != text.npos && text[digit] >= '0' && text[digit] <= '9';
}

std::size_t leading_empty(const std::vector<std::string>& cells) {
  const auto full = std::ranges::find_if(cells, [](const std::string& c) { return !c.empty(); });
  return static_cast<std::size_t>(full - cells.begin());
}

// A class for each column: numbers to the right, short text in one line.
std::vector<std::string_view> column_classes(const Table& table) {
  std::vector<std::string_view> classes;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    bool any = false, number = true, brief = true;
    for (const std::vector<std::string>& row : table.rows) {
      if (row[c].empty()) continue;
      any = true;
      number = number && looks_like_number(row[c]);
      brief = brief && row[c].size() <= 24;
    }
    classes.push_back(any && number ? " class=\"n\"" : brief ? " class=\"s\"" : "");
  }
  return classes;
}

}  // namespace

Page::Page(std::string title, std::string subtitle)
    : title_(std::move(title)), subtitle_(std::move(subtitle)) {}

std::string& Page::body() {
  return sections_.empty() ? preface_ : sections_.back().body;
}

void Page::section(std::string_view title) {
  sections_.push_back({std::string(title), {}});
}

void Page::heading(std::string_view title) {
  body() += "<h3>" + escaped(title) + "</h3>\n";
}

void Page::paragraph(std::string_view text) {
  body() += "<p>" + marked_up(text) + "</p>\n";
}

void Page::table(const Table& table, std::string_view caption) {
  const std::vector<std::string_view> classes = column_classes(table);
  std::size_t indent = 0;
  for (const std::vector<std::string>& cells : table.rows)
    indent = std::max(indent, leading_empty(cells));
  const auto row = [&](const std::vector<std::string>& cells, std::string_view tag) {
    body() += leading_empty(cells) < indent ? "<tr class=\"g\">" : "<tr>";
    for (std::size_t c = 0; c < cells.size(); ++c)
      body() += fmt::format("<{0}{1}>{2}</{0}>", tag, classes[c], marked_up(cells[c]));
    body() += "</tr>\n";
  };
  body() += "<div class=\"scroll\" tabindex=\"0\"><table>";
  if (!caption.empty()) body() += "<caption>" + marked_up(caption) + "</caption>";
  body() += "<thead>";
  row(table.columns, "th");
  body() += "</thead><tbody>\n";
  for (const std::vector<std::string>& cells : table.rows) row(cells, "td");
  body() += "</tbody></table></div>\n";
}

void Page::figure(std::string_view svg, std::string_view caption) {
  body() +=
      fmt::format("<figure><div class=\"drawing\">{}</div><figcaption>{}</figcaption></figure>\n",
                  svg, marked_up(caption));
}

void Page::criteria(const std::vector<Criterion>& criteria) {
  body() +=
      "<div class=\"scroll\" tabindex=\"0\"><table><thead><tr><th>criterion</th><th>bound</th>"
      "<th>measured</th><th></th></tr></thead><tbody>\n";
  for (const Criterion& c : criteria) {
    const std::string_view word = verdict(c);
    const std::string_view style = word == "MISSED" ? "missed" : word == "met" ? "met" : "shown";
    body() +=
        fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td class=\"{}\">{}</td></tr>\n",
                    marked_up(c.what), marked_up(c.bound), marked_up(c.measured), style, word);
  }
  body() += "</tbody></table></div>\n";
}

void Page::last_section_first() {
  if (!sections_.empty())
    std::rotate(sections_.begin(), std::prev(sections_.end()), sections_.end());
}

Status Page::write(const std::string& path) const {
  std::string text = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\">\n<title>{0}</title>\n<style>{1}</style>"
      "</head>\n<body>\n<header><h1>{0}</h1>\n<p class=\"subtitle\">{2}</p></header>\n",
      escaped(title_), kStyle, marked_up(subtitle_));
  if (sections_.size() > 1) {
    text += "<nav aria-label=\"Contents\"><ol>\n";
    for (std::size_t i = 0; i < sections_.size(); ++i)
      text += fmt::format("<li><a href=\"#section-{}\">{}</a></li>\n", i + 1,
                          escaped(sections_[i].title));
    text += "</ol></nav>\n";
  }
  text += "<main>\n" + preface_;
  for (std::size_t i = 0; i < sections_.size(); ++i)
    text += fmt::format("<h2 id=\"section-{}\">{}</h2>\n{}", i + 1, escaped(sections_[i].title),
                        sections_[i].body);
  return write_file(path, text + "</main>\n</body></html>\n");
}

}  // namespace tremolo
