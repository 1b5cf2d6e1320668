// Bad input: one line that names field, value and valid range, exit 2, nothing queued, whether the
// client or only the server sees it.
#include <gmock/gmock.h>

#include "tests/support/real_service.h"

namespace granary::test {
namespace {

using testing::HasSubstr;

class BadInput : public RealService {
 protected:
  void expect_refused(const std::vector<std::string>& arguments, const std::string& says) {
    const Outputs outputs = granary(arguments);
    EXPECT_EQ(outputs.exit_code, 2) << outputs.err;
    EXPECT_THAT(outputs.err, HasSubstr(says));
    EXPECT_EQ(std::count(outputs.err.begin(), outputs.err.end(), '\n'), 1) << outputs.err;
    EXPECT_EQ(outputs.out, "");
  }
};

TEST_F(BadInput, is_refused_by_name_and_queues_nothing) {
  const std::string good = scene("discharge_small");
  for (const auto& [setting, says] : std::vector<std::pair<std::string, std::string>>{
           {"discharge.particles.count=0", "discharge.particles.count"},
           {"discharge.particles.diameter_min_m=-0.01", "> 0 and <= 1"},
           {"discharge.rotation_rad_per_s=nan", "finite"},
           {"discharge.particles.colour=3", "unknown field"},
           {"discharge.particles.count=many", "whole number"},
           {"discharge.bucket.tip_x_m=-0.001", "discharge.bucket.tip_x_m"}})
    expect_refused({"submit", good, "--set", setting}, says);
  expect_refused(
      {"submit", good, scratch.write("bad.txtpb", "discharge { particles { count: -1 } }")},
      "bad.txtpb:1");
  EXPECT_EQ(nlohmann::json::parse(granary({"ls", "--format", "json"}).out).size(), 0u);
}

}  // namespace
}  // namespace granary::test
