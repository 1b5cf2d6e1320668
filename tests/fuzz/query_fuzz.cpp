// Any text as a query: answered or refused with one line, and the database is the same afterwards.
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>

#include "server/store/database.h"
#include "server/store/query_door.h"
#include "tests/fuzz/require.h"

namespace {

using namespace granary;
using namespace granary::server;

// One small database for all inputs, removed at the end.
struct World {
  World() {
    std::filesystem::create_directories(folder);
    Database database(file);
    database.connection().exec(
        "INSERT INTO job (kind, state, rank, priority, owner, key, scene, resolved, submitted_ms) VALUES "
        "('discharge', 3, 5, 0, 'anna', 'k', x'', x'', 5), ('chute', 1, 6, 0, 'ben', 'l', x'', x'', 6)");
    database.connection().exec("INSERT INTO job_value VALUES (1, 'f1_m', 1.9, 0.01, 'm', '')");
  }
  ~World() { std::filesystem::remove_all(folder); }
  std::string contents() const {
    SQLite::Database now(file.string(), SQLite::OPEN_READONLY);
    std::string text;
    for (const char* sql : {"SELECT group_concat(sql) FROM sqlite_schema", "SELECT group_concat(id || state || owner) FROM job",
                            "SELECT group_concat(value) FROM job_value", "PRAGMA user_version"})
      text += now.execAndGet(sql).getString() + "\n";
    return text;
  }
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("granary-fuzz-" + std::to_string(::getpid()));
  const std::filesystem::path file = folder / "granary.db";
};

class Counting : public RowSink {
 public:
  void columns(const std::vector<std::string>&) override {}
  bool row(std::vector<Cell>) override { return ++rows < 2000; }
  int rows = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static World world;
  static int calls = 0;
  static const std::string before = world.contents();
  Counting sink;
  const std::atomic<bool> cancelled = false;
  const Status status = run_query(world.file, std::string(reinterpret_cast<const char*>(data), size),
                                  {.time_s = 0.2, .rows = 1000}, sink, cancelled);
  require(sink.rows <= 1000, "no more rows than allowed");
  if (!status) {
    require_one_line(status.error());
  }
  if (++calls % 50 == 0) require(world.contents() == before, "nothing was written");
  return 0;
}
