#include "client/render/progress_line.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <utility>

namespace granary::render {
namespace {

constexpr std::size_t kBarWidth = 20;

template <typename... Values>
std::string formatted(const char* pattern, Values... values) {
  char text[128];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

// f1..f4 as soon as there is one of them; else the first few values, by name so that they stay in
// their place.
std::vector<std::pair<std::string, double>> shown_values(const v1::Progress& progress) {
  constexpr std::size_t kMostValues = 4;
  const std::map<std::string, double> sorted(progress.current_values().begin(),
                                             progress.current_values().end());
  std::vector<std::pair<std::string, double>> criteria, others;
  for (const auto& [name, value] : sorted) {
    if (!std::isfinite(value)) continue;
    const bool is_criterion =
        name == "f1_m" || name == "f2_m" || name == "f3_percent" || name == "f4_m";
    if (is_criterion)
      criteria.emplace_back(name, value);
    else if (others.size() < kMostValues)
      others.emplace_back(name, value);
  }
  return criteria.empty() ? others : criteria;
}

std::vector<std::string> segments(const v1::Progress& progress) {
  const double fraction = std::clamp(progress.fraction(), 0.0, 1.0);
  // Rounded down, so that 100 % is never shown before the end.
  std::vector<std::string> parts{"[" + bar(fraction, kBarWidth) + "]" +
                                 formatted(" %3d %%", static_cast<int>(fraction * 100 + 1e-9))};
  if (!progress.phase().empty()) parts.push_back(progress.phase());
  if (progress.replicates() > 1)
    parts.push_back(formatted("replicate %u/%u", progress.replicate() + 1, progress.replicates()));
  if (progress.end_time_s() > 0 && progress.time_s() <= progress.end_time_s())
    parts.push_back(formatted("t %.3g/%.3g s", progress.time_s(), progress.end_time_s()));
  else if (progress.time_s() > 0)
    parts.push_back(formatted("t %.3g s", progress.time_s()));
  if (progress.eta_s() > 0 && std::isfinite(progress.eta_s()))
    parts.push_back("ETA " + clock_text(progress.eta_s()));
  if (progress.particles() > 0)
    parts.push_back(
        formatted("%llu particles", static_cast<unsigned long long>(progress.particles())));
  if (progress.contacts() > 0)
    parts.push_back(
        formatted("%llu contacts", static_cast<unsigned long long>(progress.contacts())));
  if (progress.ns_per_particle_step() > 0)
    parts.push_back(formatted("%.3g ns/particle-step", progress.ns_per_particle_step()));
  for (const auto& [name, value] : shown_values(progress))
    parts.push_back(name + formatted(" %.4g", value));
  if (progress.steps() > 0 && std::isfinite(progress.ledger_remainder_ratio()))
    parts.push_back(formatted("ledger %.1e", progress.ledger_remainder_ratio()));
  return parts;
}

}  // namespace

std::string clock_text(double duration_s) {
  const auto total = static_cast<long long>(std::llround(std::max(duration_s, 0.0)));
  const long long days = total / 86400, hours = total / 3600 % 24, minutes = total / 60 % 60,
                  seconds = total % 60;
  char text[64];
  if (days > 0)
    std::snprintf(text, sizeof text, "%lldd %lld:%02lld:%02lld", days, hours, minutes, seconds);
  else if (hours > 0)
    std::snprintf(text, sizeof text, "%lld:%02lld:%02lld", hours, minutes, seconds);
  else
    std::snprintf(text, sizeof text, "%lld:%02lld", minutes, seconds);
  return text;
}

std::string bar(double fraction, std::size_t width) {
  const auto filled =
      static_cast<std::size_t>(std::clamp(fraction, 0.0, 1.0) * static_cast<double>(width) + 1e-9);
  return std::string(filled, '#') + std::string(width - filled, '.');
}

std::string progress_line(const v1::Progress& progress) {
  std::string line;
  for (const std::string& part : segments(progress)) line += (line.empty() ? "" : "  ") + part;
  return line;
}

std::vector<std::string> progress_lines(const v1::Progress& progress, std::size_t width) {
  std::vector<std::string> lines{""};
  for (const std::string& part : segments(progress)) {
    std::string& last = lines.back();
    if (last.empty())
      last = part.substr(0, width);
    else if (last.size() + 2 + part.size() <= width)
      last += "  " + part;
    else
      lines.push_back(part.substr(0, width));
  }
  return lines;
}

}  // namespace granary::render
