#include "tests/lab/report/svg.h"

#include <algorithm>
#include <atomic>
#include <iterator>
#include <string_view>

#include <fmt/format.h>

#include "runtime/program/output/gnuplot.h"

namespace tremolo {
namespace {

constexpr int kLetter = 7;   // px, a letter's usual width at the font size below
constexpr int kSample = 30;  // px, the line before a legend's label
constexpr int kLine = 22;    // px, from one line of the legend to the next
constexpr int kMargin = 10;  // px

// gnuplot gives the same ids to the same things in every picture.
std::string with_own_ids(std::string_view svg) {
  static std::atomic<int> count{0};
  const std::string prefix = fmt::format("chart{}-", ++count);
  constexpr std::string_view kBefore[] = {" id='", " id=\"", "href='#", "href=\"#", "url(#"};
  std::string result;
  bool in_tag = false;
  while (!svg.empty()) {
    if (svg.front() == '<') in_tag = true;
    if (svg.front() == '>') in_tag = false;
    const auto found = std::find_if(std::begin(kBefore), std::end(kBefore),
                                    [&](std::string_view word) { return svg.starts_with(word); });
    if (!in_tag || found == std::end(kBefore)) {
      result += svg.front();
      svg.remove_prefix(1);
      continue;
    }
    result += std::string(*found) + prefix;
    svg.remove_prefix(found->size());
  }
  return result;
}

void erase_element(std::string& svg, std::string_view name) {
  const std::string open = fmt::format("<{}>", name), close = fmt::format("</{}>", name);
  const std::size_t begin = svg.find(open), end = svg.find(close);
  if (begin != svg.npos && end != svg.npos && begin < end)
    svg.erase(begin, end + close.size() - begin);
}

}  // namespace

Sheet::Sheet(int panels, int columns, int width, int height, std::vector<LegendEntry> legend)
    : columns_(std::max(1, std::min(columns, panels))),
      width_(width),
      height_(height),
      total_width_(columns_ * width),
      legend_(std::move(legend)) {
  if (!legend_.empty()) {
    std::size_t longest = 0;
    for (const LegendEntry& entry : legend_) longest = std::max(longest, entry.label.size());
    entry_width_ = kSample + kLetter * static_cast<int>(longest) + 24;
    const int count = static_cast<int>(legend_.size());
    legend_columns_ = std::clamp((total_width_ - 2 * kMargin) / entry_width_, 1, count);
    // Full lines of equal length look better than a long one with a rest.
    const int lines = (count + legend_columns_ - 1) / legend_columns_;
    legend_columns_ = (count + lines - 1) / lines;
    strip_ = lines * kLine + 2 * kMargin;
  }
  total_height_ = (panels + columns_ - 1) / columns_ * height + strip_;
}

std::string Sheet::panel(int index) const {
  const int row = index / columns_, column = index % columns_;
  const double w = total_width_, h = total_height_;
  return fmt::format("set size {:.6f},{:.6f}\nset origin {:.6f},{:.6f}\n", width_ / w, height_ / h,
                     column * width_ / w, 1.0 - (row + 1) * height_ / h);
}

std::string Sheet::panel(int index, int left, int right, int above, int below) const {
  const double x = index % columns_ * width_, y = index / columns_ * height_;
  const double w = total_width_, h = total_height_;
  return panel(index) + fmt::format(
                            "set lmargin at screen {:.6f}\nset rmargin at screen {:.6f}\n"
                            "set tmargin at screen {:.6f}\nset bmargin at screen {:.6f}\n",
                            (x + left) / w, (x + width_ - right) / w, 1.0 - (y + above) / h,
                            1.0 - (y + height_ - below) / h);
}

std::string Sheet::legend_script() const {
  if (legend_.empty()) return {};
  std::string text = fmt::format(
      "reset\nset size 1,{:.6f}\nset origin 0,0\nset margins 0,0,0,0\nunset border\nunset tics\n"
      "unset key\n",
      strip_ / static_cast<double>(total_height_));
  const int left = (total_width_ - legend_columns_ * entry_width_) / 2 + kMargin;
  for (std::size_t i = 0; i < legend_.size(); ++i) {
    const LegendEntry& entry = legend_[i];
    const int line = static_cast<int>(i) / legend_columns_;
    const double x = left + static_cast<int>(i) % legend_columns_ * entry_width_;
    const double y = (strip_ - kMargin - kLine * (line + 0.5)) / total_height_;
    const auto at = [&](double px) {
      return fmt::format("screen {:.6f},{:.6f}", px / total_width_, y);
    };
    if (!entry.line.empty())
      text += fmt::format("set arrow from {} to {} nohead {} lc rgb '{}'\n", at(x), at(x + kSample),
                          entry.line, entry.colour);
    if (!entry.point.empty())
      text += fmt::format("set label '' at {} point {} lc rgb '{}'\n", at(x + kSample / 2.0),
                          entry.point, entry.colour);
    text += fmt::format("set label {} at {} noenhanced\n", gnuplot_quoted(entry.label),
                        at(x + kSample + 6));
  }
  return text + "plot [0:1][0:1] -1 notitle\n";
}

Result<std::string> Sheet::draw(const std::string& plots) const {
  const std::string script = fmt::format(
      "set terminal svg size {},{} fixed enhanced font 'sans,13' background 'white'\n"
      "set multiplot\n{}{}unset multiplot\n",
      total_width_, total_height_, plots, legend_script());
  Result<std::string> drawn = run_gnuplot(script);
  if (!drawn) return drawn;
  std::string svg = std::move(*drawn);
  const std::size_t begin = svg.find("<svg"), end = svg.rfind("</svg>");
  if (begin == svg.npos || end == svg.npos) return system_error("gnuplot drew nothing");
  svg = svg.substr(begin, end + 6 - begin);
  erase_element(svg, "title");  // the picture's own, a useless tooltip; those of curves stay
  erase_element(svg, "desc");
  return with_own_ids(svg);
}

}  // namespace tremolo
