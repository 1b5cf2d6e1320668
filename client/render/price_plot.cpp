#include "client/render/price_plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <limits>

namespace granary::render {
namespace {

constexpr double kWidth = 760, kHeight = 460;
constexpr double kLeft = 70, kRight = 190, kTop = 40, kBottom = 55;
constexpr const char* kColours[] = {"#1b6ca8", "#c8553d", "#3d8b37", "#7a4fa3", "#8a6d1d"};

std::string text_of(const char* format, double value) {
  char text[40];
  std::snprintf(text, sizeof text, format, value);
  return text;
}
std::string px(double value) {
  return text_of("%.1f", value);
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char letter : text) {
    if (letter == '<')
      out += "&lt;";
    else if (letter == '>')
      out += "&gt;";
    else if (letter == '&')
      out += "&amp;";
    else
      out += letter;
  }
  return out;
}

bool is_drawn(const PricePlotPoint& point) {
  return point.cpu_s > 0 && point.error > 0;
}

// Whole decades around the data.
struct Axis {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void include(double value) {
    low = std::min(low, std::log10(value));
    high = std::max(high, std::log10(value));
  }
  void round() {
    if (low > high) low = -1, high = 1;
    low = std::floor(low - 0.05);
    high = std::max(std::ceil(high + 0.05), low + 1);
  }
  double share(double value) const { return (std::log10(value) - low) / (high - low); }
};

struct Frame {
  Axis x, y;
  double at_x(double cpu_s) const { return kLeft + x.share(cpu_s) * (kWidth - kLeft - kRight); }
  double at_y(double error) const {
    return kHeight - kBottom - y.share(error) * (kHeight - kTop - kBottom);
  }
};

std::string text_at(double x, double y, const char* anchor, const std::string& text,
                    const char* more = "") {
  return "<text x=\"" + px(x) + "\" y=\"" + px(y) + "\" text-anchor=\"" + anchor + "\" " + more +
         ">" + escaped(text) + "</text>\n";
}

std::string segment(double x1, double y1, double x2, double y2, const char* style) {
  return "<line x1=\"" + px(x1) + "\" y1=\"" + px(y1) + "\" x2=\"" + px(x2) + "\" y2=\"" + px(y2) +
         "\" " + style + "/>\n";
}

std::string axes(const Frame& frame) {
  std::string svg;
  const double right = kWidth - kRight, bottom = kHeight - kBottom;
  for (double decade = frame.x.low; decade <= frame.x.high; ++decade) {
    const double x = frame.at_x(std::pow(10, decade));
    svg += segment(x, kTop, x, bottom, "stroke=\"#ddd\"");
    svg += text_at(x, bottom + 18, "middle", text_of("%g", std::pow(10, decade)));
  }
  for (double decade = frame.y.low; decade <= frame.y.high; ++decade) {
    const double y = frame.at_y(std::pow(10, decade));
    svg += segment(kLeft, y, right, y, "stroke=\"#ddd\"");
    svg += text_at(kLeft - 8, y + 4, "end", text_of("%g %%", 100 * std::pow(10, decade)));
  }
  svg += text_at((kLeft + right) / 2, kHeight - 14, "middle", "CPU seconds");
  return svg + text_at(18, kTop - 12, "start", "error");
}

std::string curve(const Frame& frame, const PricePlotLine& line, const char* colour) {
  std::vector<PricePlotPoint> points;
  std::copy_if(line.points.begin(), line.points.end(), std::back_inserter(points), is_drawn);
  std::sort(points.begin(), points.end(),
            [](const auto& a, const auto& b) { return a.cpu_s < b.cpu_s; });
  std::string path, marks;
  for (const PricePlotPoint& point : points) {
    const double x = frame.at_x(point.cpu_s), y = frame.at_y(point.error);
    path += px(x) + "," + px(y) + " ";
    marks += "<circle cx=\"" + px(x) + "\" cy=\"" + px(y) + "\" r=\"4\" fill=\"" + colour +
             "\"><title>" + escaped(line.name + " = " + point.label) + "</title></circle>\n";
    if (point.knee)
      marks += "<circle cx=\"" + px(x) + "\" cy=\"" + px(y) + "\" r=\"8\" fill=\"none\" stroke=\"" +
               colour + "\" stroke-width=\"2\"/>\n";
  }
  return "<polyline points=\"" + path + "\" fill=\"none\" stroke=\"" + colour +
         "\" stroke-width=\"1.5\"/>\n" + marks;
}

// Two rows: the line's name, and its knee, which has no room beside the points.
std::string legend_entry(const PricePlotLine& line, const char* colour, double y) {
  const double x = kWidth - kRight + 18;
  std::string svg = "<circle cx=\"" + px(x) + "\" cy=\"" + px(y - 4) + "\" r=\"4\" fill=\"" +
                    colour + "\"/>\n" + text_at(x + 10, y, "start", line.name);
  const auto knee = std::find_if(line.points.begin(), line.points.end(),
                                 [](const PricePlotPoint& point) { return point.knee; });
  if (knee != line.points.end())
    svg += text_at(x + 10, y + 14, "start", "knee: " + knee->label, "font-size=\"11\"");
  return svg;
}

}  // namespace

std::string price_plot_svg(const std::string& title, const std::vector<PricePlotLine>& lines) {
  Frame frame;
  for (const PricePlotLine& line : lines)
    for (const PricePlotPoint& point : line.points)
      if (is_drawn(point)) frame.x.include(point.cpu_s), frame.y.include(point.error);
  frame.x.round();
  frame.y.round();
  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + px(kWidth) + " " +
                    px(kHeight) + "\" font-family=\"sans-serif\" font-size=\"12\">\n" +
                    "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n" +
                    text_at(kWidth / 2, 20, "middle", title, "font-size=\"14\"") + axes(frame);
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const char* colour = kColours[k % std::size(kColours)];
    svg += curve(frame, lines[k], colour);
    svg += legend_entry(lines[k], colour, kTop + 36 * static_cast<double>(k) + 18);
  }
  return svg + "</svg>\n";
}

}  // namespace granary::render
