#include "server/studies/golden_section.h"

#include <algorithm>
#include <deque>
#include <numbers>

namespace granary::server {
namespace {

constexpr double kShare = 1 / std::numbers::phi;  // 0.618: what is left of a bracket
// Brackets looked at ahead: beyond this they are narrower than doubles.
constexpr int kMaxBrackets = 64;

}  // namespace

GoldenSection golden_section(double low, double high) {
  return {low, high, high - kShare * (high - low), low + kShare * (high - low)};
}

GoldenSection narrowed(const GoldenSection& b, bool left_is_better) {
  if (left_is_better) return {b.low, b.right, b.right - kShare * (b.right - b.low), b.left};
  return {b.left, b.high, b.right, b.left + kShare * (b.high - b.left)};
}

std::vector<double> next_points(const GoldenSection& bracket, const std::map<double, double>& known,
                                std::size_t count) {
  std::vector<double> wanted;
  std::deque<GoldenSection> possible{bracket};
  const auto want = [&](double t) {
    const bool listed = std::find(wanted.begin(), wanted.end(), t) != wanted.end();
    if (wanted.size() < count && known.count(t) == 0 && !listed) wanted.push_back(t);
  };
  for (int looked = 0; looked < kMaxBrackets && wanted.size() < count; ++looked) {
    const GoldenSection b = possible.front();
    possible.pop_front();
    want(b.left);
    want(b.right);
    const auto left = known.find(b.left), right = known.find(b.right);
    if (left != known.end() && right != known.end()) {
      possible.push_back(narrowed(b, left->second >= right->second));
    } else {
      possible.push_back(narrowed(b, true));
      possible.push_back(narrowed(b, false));
    }
  }
  return wanted;
}

}  // namespace granary::server
