#include "worker/storage/picture_export.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <string>
#include <vector>

#include "worker/storage/export_files.h"
#include "worker/storage/result_reader.h"
#include "worker/storage/storage_error.h"

namespace granary::storage {
namespace {

constexpr int kPanelCount = 6;
constexpr int kColumns = 3;
constexpr double kPanel = 320;   // pixels
constexpr double kMargin = 28;   // for the caption
constexpr double kMinRadius = 0.6;
// Strata and speeds from dark to bright; readable in grey as well.
constexpr std::array<const char*, 6> kColours = {"#30305f", "#3f5f9f", "#3f8f9f",
                                                 "#5faf7f", "#bfbf4f", "#df8f3f"};

struct Box {
  double x_min = 1e300, x_max = -1e300, y_min = 1e300, y_max = -1e300;
  void include(double x, double y) {
    x_min = std::min(x_min, x), x_max = std::max(x_max, x);
    y_min = std::min(y_min, y), y_max = std::max(y_max, y);
  }
};

struct Grain {
  double x, y, radius;
  std::size_t colour;
};

struct Outline {
  std::vector<std::array<double, 2>> points;
};

struct Panel {
  std::string caption;
  std::vector<Grain> grains;
  std::vector<Outline> outlines;
};

std::string format(const char* pattern, ...) {
  char text[256];
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text, sizeof text, pattern, arguments);
  va_end(arguments);
  return text;
}

std::vector<std::size_t> colour_classes(const NumberTable& grains, bool is_discharge) {
  const NumberColumn& by = grains.required(is_discharge ? "stratum" : "velocity_m_per_s");
  std::vector<double> measure;
  for (std::size_t i = 0; i < by.values.size(); i += by.width)
    measure.push_back(std::abs(by.values[i]));
  const double largest = measure.empty() ? 1 : *std::max_element(measure.begin(), measure.end());
  std::vector<std::size_t> classes;
  for (const double value : measure) {
    const double share = largest > 0 ? value / largest : 0;
    classes.push_back(std::min(kColours.size() - 1, static_cast<std::size_t>(share * kColours.size())));
  }
  return classes;
}

// Discharge: x, y of the plane. Chute: x along the floor, z above it.
std::vector<Grain> grains_of(const NumberTable& table, bool is_discharge) {
  const NumberColumn& position = table.required("position_m");
  const NumberColumn& radius = table.required("radius_m");
  const auto colours = colour_classes(table, is_discharge);
  std::vector<Grain> grains;
  for (std::size_t i = 0; i < radius.values.size(); ++i) {
    const double* at = &position.values[i * position.width];
    grains.push_back({at[0], is_discharge ? at[1] : at[2], radius.values[i], colours[i]});
  }
  return grains;
}

// Angle of the bucket [rad] at a time, from the series of the centre of gravity.
double bucket_angle(const NumberTable& cg, double time_s) {
  const auto& times = cg.required("time_s").values;
  const auto& angles = cg.required("angle_deg").values;
  if (times.empty()) return 0;
  const auto next = std::lower_bound(times.begin(), times.end(), time_s);
  const std::size_t i = next == times.end() ? times.size() - 1 : static_cast<std::size_t>(next - times.begin());
  return angles[i] * M_PI / 180;
}

// The polylines of the field `bucket`, one per wall, turned clockwise about the pulley.
std::vector<Outline> bucket_outlines(const NumberTable& bucket, double angle) {
  const auto& x = bucket.required("x_m").values;
  const auto& y = bucket.required("y_m").values;
  const auto& wall = bucket.required("wall").values;
  const double c = std::cos(angle), s = std::sin(angle);
  std::vector<Outline> outlines;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (i == 0 || wall[i] != wall[i - 1]) outlines.emplace_back();
    outlines.back().points.push_back({c * x[i] + s * y[i], -s * x[i] + c * y[i]});
  }
  return outlines;
}

std::vector<std::size_t> chosen_frames(const ResultReader& reader, bool is_discharge) {
  std::vector<std::size_t> main;  // what follows the main phase would shrink it to a corner
  for (std::size_t i = 0; i < reader.frame_count(); ++i)
    if (!is_discharge || reader.frame(i).phase == "rotation") main.push_back(i);
  if (main.empty()) throw StorageError(StorageFault::damaged, "there are no frames to draw");
  std::vector<std::size_t> chosen;
  for (int k = 0; k < kPanelCount; ++k)
    chosen.push_back(main[(main.size() - 1) * static_cast<std::size_t>(k) / (kPanelCount - 1)]);
  return chosen;
}

std::vector<Panel> panels_of(const ResultReader& reader) {
  const bool is_discharge = reader.kind() == "discharge";
  const auto fields = reader.table_names("fields");
  const bool has_bucket = std::find(fields.begin(), fields.end(), "bucket") != fields.end();
  std::vector<Panel> panels;
  for (const std::size_t index : chosen_frames(reader, is_discharge)) {
    const StoredFrame frame = reader.frame(index);
    Panel panel{format("t = %.3f s", frame.time_s), grains_of(frame.grains, is_discharge), {}};
    if (is_discharge && has_bucket) {
      const double angle = bucket_angle(reader.table("series", "cg"), frame.time_s);
      panel.outlines = bucket_outlines(reader.table("fields", "bucket"), angle);
      panel.caption += format(", %.0f degrees", angle * 180 / M_PI);
    }
    panels.push_back(std::move(panel));
  }
  return panels;
}

Box box_of(const std::vector<Panel>& panels) {
  Box box;
  for (const Panel& panel : panels) {
    for (const Grain& grain : panel.grains) {
      box.include(grain.x - grain.radius, grain.y - grain.radius);
      box.include(grain.x + grain.radius, grain.y + grain.radius);
    }
    for (const Outline& outline : panel.outlines)
      for (const auto& point : outline.points) box.include(point[0], point[1]);
  }
  return box;
}

void draw(const Panel& panel, const Box& box, double left, double top, std::string& svg) {
  const double scale = std::min(kPanel / (box.x_max - box.x_min), kPanel / (box.y_max - box.y_min));
  const auto x_of = [&](double x) { return left + (x - box.x_min) * scale; };
  const auto y_of = [&](double y) { return top + (box.y_max - y) * scale; };
  svg += format("<text x='%.0f' y='%.0f'>%s</text>\n", left, top - 8, panel.caption.c_str());
  for (std::size_t colour = 0; colour < kColours.size(); ++colour) {
    svg += format("<g fill='%s'>", kColours[colour]);
    for (const Grain& grain : panel.grains)
      if (grain.colour == colour)
        svg += format("<circle cx='%.1f' cy='%.1f' r='%.1f'/>", x_of(grain.x), y_of(grain.y),
                      std::max(kMinRadius, grain.radius * scale));
    svg += "</g>\n";
  }
  for (const Outline& outline : panel.outlines) {
    svg += "<polyline points='";
    for (const auto& point : outline.points) svg += format("%.1f,%.1f ", x_of(point[0]), y_of(point[1]));
    svg += "'/>\n";
  }
}

}  // namespace

Path export_picture(const Path& result, const Path& directory) {
  const ResultReader reader(result);
  const std::vector<Panel> panels = panels_of(reader);
  const Box box = box_of(panels);
  const double aspect = std::min(1.0, (box.y_max - box.y_min) / (box.x_max - box.x_min));
  const double height = kPanel * aspect + kMargin + 12, width = kPanel + 12;
  std::string svg = format(
      "<svg xmlns='http://www.w3.org/2000/svg' width='%.0f' height='%.0f' font-family='sans-serif' "
      "font-size='13'>\n<rect width='100%%' height='100%%' fill='white'/>\n"
      "<style>polyline{fill:none;stroke:#202020;stroke-width:1.5}</style>\n",
      width * kColumns + 12, height * ((kPanelCount + kColumns - 1) / kColumns) + 12);
  for (std::size_t k = 0; k < panels.size(); ++k)
    draw(panels[k], box, 12 + width * static_cast<double>(k % kColumns),
         kMargin + height * static_cast<double>(k / kColumns), svg);
  svg += "</svg>\n";
  make_directory(directory);
  const Path picture = directory / "picture.svg";
  write_text(picture, svg);
  return picture;
}

}  // namespace granary::storage
