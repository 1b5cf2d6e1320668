#include "worker/core/student_t.h"

#include <cmath>
#include <numbers>

namespace granary::core {

double student_t_two_sided(double t, unsigned degrees) {
  const double theta = std::atan(t / std::sqrt(static_cast<double>(degrees)));
  const double sine = std::sin(theta);
  const double cosine_squared = std::cos(theta) * std::cos(theta);
  const bool odd = degrees % 2 == 1;
  // odd:  2/pi (theta + sin (cos + 2/3 cos^3 + 2*4/(3*5) cos^5 + ...)), up to cos^(degrees - 2)
  // even: sin (1 + 1/2 cos^2 + 1*3/(2*4) cos^4 + ...),                 up to cos^(degrees - 2)
  double term = odd ? std::cos(theta) : 1;
  double sum = 0;
  for (unsigned power = odd ? 1 : 0; power + 2 <= degrees; power += 2) {
    sum += term;
    term *= cosine_squared * (power + 1.0) / (power + 2.0);
  }
  return odd ? 2 / std::numbers::pi * (theta + sine * sum) : sine * sum;
}

double student_t_quantile(double probability, unsigned degrees) {
  double low = 0;
  double high = 1;
  while (student_t_two_sided(high, degrees) < probability) high *= 2;
  // Bisection to the last bit: called once per value of a finished job.
  for (double middle = high / 2; middle > low && middle < high; middle = (low + high) / 2)
    (student_t_two_sided(middle, degrees) < probability ? low : high) = middle;
  return high;
}

std::optional<MeanInterval> mean_with_interval(std::span<const double> samples) {
  if (samples.size() < 2) return std::nullopt;
  const double count = static_cast<double>(samples.size());
  double mean = 0;
  for (const double sample : samples) mean += sample / count;
  double squares = 0;
  for (const double sample : samples) squares += (sample - mean) * (sample - mean);
  const double standard_error = std::sqrt(squares / (count - 1) / count);
  return MeanInterval{
      mean, student_t_quantile(0.95, static_cast<unsigned>(samples.size() - 1)) * standard_error};
}

}  // namespace granary::core
