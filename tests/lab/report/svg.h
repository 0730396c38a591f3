// What charts of every kind share: panels, a legend, and gnuplot's SVG made fit for a page.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"

namespace tremolo {

// One entry. line, point: gnuplot's style without colour, as "lw 2" and "pt 7 ps 0.6"; empty: none.
struct LegendEntry {
  std::string label;
  std::string colour;
  std::string line;
  std::string point;
};

// Panels of equal size in rows, the legend in a strip below. Lengths in px.
class Sheet {
 public:
  Sheet(int panels, int columns, int width, int height, std::vector<LegendEntry> legend);

  // gnuplot's commands that place what is plotted next into panel `index`; to be called in order.
  std::string panel(int index) const;

  // The same with what is plotted `left` px from the panel's left side, and so on.
  std::string panel(int index, int left, int right, int above, int below) const;

  // The SVG that `plots`, a script of panels, gives. Errors as draw_svg.
  Result<std::string> draw(const std::string& plots) const;

 private:
  std::string legend_script() const;

  int columns_;
  int width_;
  int height_;
  int total_width_;
  int legend_columns_ = 1;
  int entry_width_ = 0;
  int strip_ = 0;
  int total_height_;
  std::vector<LegendEntry> legend_;
};

}  // namespace tremolo
