#include "client/commands/duration.h"

#include <charconv>
#include <cmath>

namespace granary::commands {
namespace {

constexpr double kLongestDuration_s = 366.0 * 86400.0;

double unit_s(char unit) {
  switch (unit) {
    case 's':
      return 1;
    case 'm':
      return 60;
    case 'h':
      return 3600;
    case 'd':
      return 86400;
    default:
      return 0;
  }
}

Error bad_duration(std::string_view text) {
  return {ErrorCode::invalid_argument,
          "'" + std::string(text) +
              "' is not a duration: seconds above 0 and at most 366d, as 90, 90s, 10m, 2h or 1h30m",
          ""};
}

}  // namespace

Result<double> parse_duration_s(std::string_view text) {
  double total_s = 0;
  double unit_before_s = INFINITY;  // units fall: "1h30m", never "30m1h" or "1h1h"
  std::string_view rest = text;
  while (!rest.empty()) {
    double amount = 0;
    const auto parsed =
        std::from_chars(rest.data(), rest.data() + rest.size(), amount, std::chars_format::fixed);
    if (parsed.ec != std::errc() || amount < 0) return bad_duration(text);
    rest.remove_prefix(static_cast<std::size_t>(parsed.ptr - rest.data()));
    if (rest.empty() && std::isfinite(unit_before_s)) return bad_duration(text);  // "1h30"
    const double unit = rest.empty() ? 1 : unit_s(rest.front());
    if (unit == 0 || unit >= unit_before_s) return bad_duration(text);
    if (!rest.empty()) rest.remove_prefix(1);
    unit_before_s = unit;
    total_s += amount * unit;
  }
  if (!(total_s > 0) || total_s > kLongestDuration_s) return bad_duration(text);
  return total_s;
}

}  // namespace granary::commands
