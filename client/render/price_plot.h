// Error against CPU seconds as one self-contained SVG: no scripts, no fonts, no links.
#pragma once

#include <string>
#include <vector>

namespace granary::render {

struct PricePlotPoint {
  double cpu_s = 0;
  double error = 0;  // relative
  std::string label;
  bool knee = false;
};
struct PricePlotLine {
  std::string name;
  std::vector<PricePlotPoint> points;
};

// Both axes logarithmic; points without a positive error or price are left out.
std::string price_plot_svg(const std::string& title, const std::vector<PricePlotLine>& lines);

}  // namespace granary::render
