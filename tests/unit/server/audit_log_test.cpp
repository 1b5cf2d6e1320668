#include "server/ops/audit_log.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/support/temporary_directory.h"

namespace granary::server {
namespace {

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

TEST(AuditLog, one_line_says_who_did_what_to_what_and_how_it_ended) {
  const std::string line = audit_line({1'795'000'000'123, "anna", "unix:", "Jobs/Cancel", "jobs/17", "OK"});
  const auto parsed = nlohmann::json::parse(line);
  EXPECT_EQ(parsed["time"], "2026-11-18T11:06:40.123Z");
  EXPECT_EQ(parsed["owner"], "anna");
  EXPECT_EQ(parsed["call"], "Jobs/Cancel");
  EXPECT_EQ(parsed["target"], "jobs/17");
  EXPECT_EQ(parsed["outcome"], "OK");
}

TEST(AuditLog, no_name_can_forge_a_second_line) {
  const std::string line = audit_line({0, "an\"na\n{}", "", "Jobs/Cancel", "jobs/1\r\n\xff", "OK"});
  EXPECT_EQ(line.find('\n'), std::string::npos);
  EXPECT_EQ(line.find('\r'), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(line)["owner"], "an\"na\n{}");
}

TEST(AuditLog, appends_and_turns_over_when_it_is_long) {
  testing::TemporaryDirectory folder;
  AuditLog log(folder.path() / "audit.log", 150);
  log.append({0, "anna", "", "Jobs/Submit", "1 items", "OK"});
  log.append({0, "ben", "", "Jobs/Submit", "2 items", "OK"});
  log.append({0, "carl", "", "Jobs/Submit", "3 items", "OK"});
  EXPECT_NE(text_of(folder.path() / "audit.log.1").find("anna"), std::string::npos);
  EXPECT_NE(text_of(folder.path() / "audit.log").find("carl"), std::string::npos);
}

}  // namespace
}  // namespace granary::server
