#include "server/ops/access.h"

#include <gtest/gtest.h>

#include <set>

#include "granary/v1/admin.pb.h"
#include "granary/v1/job.pb.h"
#include "granary/v1/query.pb.h"
#include "granary/v1/study.pb.h"
#include "granary/v1/worker.pb.h"

namespace granary::server {
namespace {

using google::protobuf::FileDescriptor;

std::vector<std::string> every_call() {
  std::vector<std::string> calls;
  for (const FileDescriptor* file : {v1::BackupRequest::descriptor()->file(), v1::Job::descriptor()->file(),
                                     v1::WorkerHello::descriptor()->file(),
                                     v1::Study::descriptor()->file(),
                                     v1::QueryRequest::descriptor()->file()})
    for (int i = 0; i < file->service_count(); ++i)
      for (int k = 0; k < file->service(i)->method_count(); ++k)
        calls.push_back("/" + file->service(i)->full_name() + "/" + file->service(i)->method(k)->name());
  return calls;
}

TEST(Access, table_of_calls_and_roles) {
  const std::set<std::string> changing = {"Submit", "Cancel", "Retry",  "Delete",
                                           "Pause",  "Resume", "Extend"};
  const std::set<std::string> of_workers = {"Synchronize", "Upload", "FetchArtifact"};
  const std::set<std::string> of_admins = {"Backup"};
  ASSERT_EQ(every_call().size(), 27u) << "a new call needs a role in access.cpp";
  for (const std::string& call : every_call()) {
    const std::string name = call.substr(call.rfind('/') + 1);
    const bool changes = changing.count(name) > 0, is_workers = of_workers.count(name) > 0,
               is_admins = of_admins.count(name) > 0;
    EXPECT_EQ(may_call(Role::read, call), !changes && !is_workers && !is_admins) << call;
    EXPECT_EQ(may_call(Role::submit, call), !is_workers && !is_admins) << call;
    EXPECT_EQ(may_call(Role::worker, call), is_workers) << call;
    EXPECT_TRUE(may_call(Role::admin, call)) << call;
    EXPECT_FALSE(is_open(call)) << call;
  }
  EXPECT_FALSE(may_call(Role::submit, "/granary.v1.Jobs/Unknown"));
  EXPECT_FALSE(may_call(Role::read, ""));
  EXPECT_TRUE(is_open("/grpc.health.v1.Health/Check"));
}

TEST(Access, a_token_is_found_by_its_hash_until_it_expires) {
  const NewToken made = make_token({Role::submit, "anna", 1000});
  EXPECT_EQ(made.token.size(), 64u);
  EXPECT_EQ(made.line.find(made.token), std::string::npos) << "the token itself is not kept";
  const auto table = TokenTable::parse("# tokens\n\n" + made.line + "\n", "tokens");
  ASSERT_TRUE(table.ok()) << table.error().message;
  const auto owner = table->find(made.token, 999);
  ASSERT_TRUE(owner.has_value());
  EXPECT_EQ(owner->owner, "anna");
  EXPECT_EQ(owner->role, Role::submit);
  EXPECT_FALSE(table->find(made.token, 1000).has_value());
  EXPECT_FALSE(table->find(made.token + "0", 999).has_value());
  EXPECT_FALSE(table->find("", 999).has_value());
}

TEST(Access, two_tokens_are_never_the_same) {
  EXPECT_NE(make_token({Role::read, "a", 0}).token, make_token({Role::read, "a", 0}).token);
}

TEST(Access, a_bad_token_file_names_its_line) {
  const std::string hash(64, 'a');
  for (const std::string& bad : {std::string("secret read anna"), hash + " root anna", hash + " read", hash + " read anna 7 x"}) {
    const auto table = TokenTable::parse("# ok\n" + bad + "\n", "tokens");
    ASSERT_FALSE(table.ok()) << bad;
    EXPECT_NE(table.error().message.find("tokens:2:"), std::string::npos);
  }
}

}  // namespace
}  // namespace granary::server
