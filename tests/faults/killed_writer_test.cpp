// A process that writes frames as fast as it can is killed with SIGKILL at random moments. Every
// frame it had reported must be there afterwards, and what is left must become a file that opens.
// GRANARY_KILLS sets how many times (default 20; tests/long.sh uses more).
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <random>
#include <thread>

#include "tests/support/result_reader.h"
#include "tests/support/temporary_directory.h"
#include "worker/storage/frame_store.h"
#include "worker/storage/salvage.h"
#include "worker/storage/verify.h"

namespace granary::storage {
namespace {

using namespace granary::testing;

constexpr std::size_t kParticles = 500;
constexpr std::uint64_t kFramesPerSegment = 64;
constexpr std::uint64_t kMostFrames = 1000;

std::vector<double> positions_of(std::uint64_t frame) {
  std::vector<double> values(2 * kParticles);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = static_cast<double>(frame) + 1e-3 * static_cast<double>(i);
  return values;
}

// Appends frames and says after each which one it was. However late the killer comes on a busy
// machine, what has to be read afterwards stays small: it ends with waiting.
[[noreturn]] void write_frames(const Path& directory, int report) {
  FrameStore store(real_file_system(), directory, {"scene", "1", "portable"}, "a scene");
  for (std::uint64_t frame = 0; frame < kMostFrames; ++frame) {
    const std::vector<double> positions = positions_of(frame);
    const core::ColumnView column{"position_m", "m", core::ElementType::f64,
                                  kParticles,   2,   positions.data()};
    store.append({frame, 0.01 * static_cast<double>(frame), "flow", std::span(&column, 1)});
    if (write(report, &frame, sizeof frame) != sizeof frame) _exit(0);
    if (frame % kFramesPerSegment == kFramesPerSegment - 1) store.seal();
  }
  for (;;) pause();
}

// The last frame the writer reported before it was killed after `life`.
std::optional<std::uint64_t> kill_a_writer(const Path& directory, std::chrono::microseconds life) {
  int report[2];
  EXPECT_EQ(pipe(report), 0);
  const pid_t writer = fork();
  if (writer == 0) write_frames(directory, report[1]);
  close(report[1]);
  std::jthread killer([&] {
    std::this_thread::sleep_for(life);
    kill(writer, SIGKILL);
  });
  std::optional<std::uint64_t> last;
  for (std::uint64_t frame; read(report[0], &frame, sizeof frame) == sizeof frame;) last = frame;
  close(report[0]);
  waitpid(writer, nullptr, 0);
  return last;
}

int kill_count() {
  const char* text = std::getenv("GRANARY_KILLS");
  return text == nullptr ? 20 : std::atoi(text);
}

TEST(KilledWriter, loses_at_most_the_frame_it_was_writing) {
  std::mt19937 random(20261122);  // any seed: the moments are random anyway
  int with_frames = 0;
  for (int i = 0; i < kill_count(); ++i) {
    TemporaryDirectory directory;
    const auto life =
        std::chrono::microseconds(std::uniform_int_distribution<>(1500, 5000)(random));
    const auto last = kill_a_writer(directory.path(), life);
    if (!last) continue;
    ++with_frames;
    const Path file = directory / "salvaged.h5";
    const std::uint64_t saved = salvage_run(real_file_system(), directory.path(), file);
    EXPECT_GE(saved, *last + 1) << "reported frames are missing";
    const VerifyReport report = verify_result(file);
    EXPECT_TRUE(report.ok()) << report.problems.front();
    EXPECT_EQ(report.frame_count, saved);
    const StoredResult result = read_result(file);
    EXPECT_EQ(result.texts.at("@state"), "partial");
    EXPECT_EQ(result.datasets.at("/scene").text(), "a scene");
    char name[64];
    std::snprintf(name, sizeof name, "/frames/%06llu/position_m",
                  static_cast<unsigned long long>(*last));
    EXPECT_EQ(result.datasets.at(name).as<double>(), positions_of(*last));
  }
  EXPECT_GE(with_frames, kill_count() / 2) << "the test killed before anything was written";
}

TEST(Salvage, of_a_directory_without_frames_says_so_and_makes_no_file) {
  TemporaryDirectory directory;
  EXPECT_ANY_THROW(salvage_run(real_file_system(), directory.path(), directory / "r.h5"));
  EXPECT_FALSE(std::filesystem::exists(directory / "r.h5"));
  EXPECT_FALSE(std::filesystem::exists(directory / "r.h5.tmp"));
}

}  // namespace
}  // namespace granary::storage
