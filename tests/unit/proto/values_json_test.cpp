#include "proto/contract/values_json.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace granary {

TEST(ValuesJson, has_the_contracts_shape_and_null_for_unknown) {
  v1::GetValuesResponse response;
  response.set_name("jobs/1");
  response.set_kind("discharge");
  response.set_state(v1::COMPLETE);
  auto& values = *response.mutable_result()->mutable_values();
  values["f1_m"].set_value(1.92);
  values["f1_m"].set_error_basis("single run");
  values["f4_m"].set_value(std::numeric_limits<double>::quiet_NaN());
  response.mutable_result()->mutable_ledger()->set_remainder_ratio(1e-4);
  const std::string line = values_json(response);
  EXPECT_EQ(line.find('\n'), std::string::npos);
  const auto json = nlohmann::json::parse(line);
  EXPECT_EQ(json["state"], "complete");
  EXPECT_EQ(json["values"]["f1_m"]["value"], 1.92);
  EXPECT_TRUE(json["values"]["f1_m"]["error"].is_null());
  EXPECT_TRUE(json["values"]["f4_m"]["value"].is_null());
  EXPECT_EQ(json["ledger"]["remainder_ratio"], 1e-4);
  for (const char* key : {"job", "kind", "cost", "effects", "engine_version", "state_hash"})
    EXPECT_TRUE(json.contains(key)) << key;
}

}  // namespace granary
