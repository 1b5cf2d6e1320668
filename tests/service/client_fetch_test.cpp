// fetch and verify: resumed, checked, never overwriting.
#include <filesystem>

#include "proto/contract/sha256.h"
#include "tests/support/client_fixture.h"

namespace granary::test {
namespace {

using testing::HasSubstr;

class ClientFetch : public ClientTest {
 protected:
  ClientFetch() {
    content_ = "\x89HDF\r\n\x1a\n";
    for (int i = 0; i < 3000; ++i) content_ += static_cast<char>(i * 7919 % 251);
    FakeJob& fake = jobs().add("jobs/1");
    fake.file = content_;
    fake.job.mutable_result()->set_sha256(sha256_hex(content_));
    fake.job.mutable_result()->set_size_bytes(content_.size());
  }
  Outputs fetch() { return granary({"fetch", "jobs/1", "-o", file_}); }
  std::vector<std::uint64_t> offsets() {
    std::vector<std::uint64_t> all;
    for (const auto& request : jobs().downloads()) all.push_back(request.offset_bytes());
    return all;
  }

  std::string content_;
  std::string file_ = scratch_.file("result.h5");
};

TEST_F(ClientFetch, writes_the_file_and_its_checksum_and_prints_its_name) {
  const Outputs outputs = fetch();
  EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
  EXPECT_EQ(outputs.out, file_ + "\n");
  EXPECT_EQ(file_text(file_), content_);
  EXPECT_EQ(file_text(file_ + ".sha256"), sha256_hex(content_) + "  result.h5\n");
  EXPECT_FALSE(std::filesystem::exists(file_ + ".part"));
}

TEST_F(ClientFetch, continues_where_a_cut_stream_stopped) {
  jobs()["jobs/1"].cut_download = {1500, 0, 700};
  EXPECT_EQ(fetch().exit_code, 0);
  EXPECT_EQ(offsets(), (std::vector<std::uint64_t>{0, 1500, 1500, 2200}));
  EXPECT_EQ(file_text(file_), content_);
}

TEST_F(ClientFetch, continues_what_an_earlier_run_left) {
  scratch_.write("result.h5.part", content_.substr(0, 1234));
  EXPECT_EQ(fetch().exit_code, 0);
  EXPECT_EQ(offsets(), (std::vector<std::uint64_t>{1234}));
  EXPECT_EQ(file_text(file_), content_);
}

TEST_F(ClientFetch, starts_over_when_the_part_belongs_to_another_result) {
  scratch_.write("result.h5.part", std::string(1234, 'x'));
  EXPECT_EQ(fetch().exit_code, 0);
  EXPECT_EQ(offsets(), (std::vector<std::uint64_t>{1234, 0}));
  EXPECT_EQ(file_text(file_), content_);
  std::filesystem::remove(file_);
  scratch_.write("result.h5.part", std::string(9999, 'x'));  // longer than the result
  EXPECT_EQ(fetch().exit_code, 0);
  EXPECT_EQ(file_text(file_), content_);
}

TEST_F(ClientFetch, content_that_does_not_match_its_checksum_is_exit_9_and_not_published) {
  jobs()["jobs/1"].file[100] ^= 1;
  const Outputs outputs = fetch();
  EXPECT_EQ(outputs.exit_code, 9);
  EXPECT_THAT(outputs.err, IsOneErrorLine());
  EXPECT_FALSE(std::filesystem::exists(file_));
}

TEST_F(ClientFetch, never_replaces_other_content_unasked) {
  scratch_.write("result.h5", "mine");
  const Outputs refused = fetch();
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("--force"));
  EXPECT_EQ(file_text(file_), "mine");
  EXPECT_EQ(granary({"fetch", "jobs/1", "-o", file_, "--force"}).exit_code, 0);
  EXPECT_EQ(file_text(file_), content_);
}

TEST_F(ClientFetch, same_content_already_there_is_fine_and_not_sent_again) {
  EXPECT_EQ(fetch().exit_code, 0);
  EXPECT_EQ(fetch().exit_code, 0);
  EXPECT_EQ(jobs().downloads().size(), 1u);
}

TEST_F(ClientFetch, job_without_a_result_is_exit_2_and_an_unknown_one_3) {
  jobs().add("jobs/2", v1::RUNNING);
  EXPECT_EQ(granary({"fetch", "jobs/2"}).exit_code, 2);
  EXPECT_EQ(granary({"fetch", "jobs/3"}).exit_code, 3);
}

TEST_F(ClientFetch, verify_finds_one_changed_bit_by_the_recorded_sum) {
  ASSERT_EQ(fetch().exit_code, 0);
  std::string changed = content_;
  changed[2000] ^= 1;
  scratch_.write("result.h5", changed);
  const Outputs outputs = granary({"verify", file_});
  EXPECT_EQ(outputs.exit_code, 9);
  EXPECT_THAT(outputs.err, IsOneErrorLine());
  EXPECT_THAT(outputs.err, HasSubstr(sha256_hex(content_)));
}

TEST_F(ClientFetch, verify_tells_a_missing_file_from_a_foreign_one) {
  EXPECT_EQ(granary({"verify", scratch_.write("text.h5", "just text")}).exit_code, 9);
  EXPECT_EQ(granary({"verify", scratch_.file("none.h5")}).exit_code, 3);
}

}  // namespace
}  // namespace granary::test
