#include "server/store/job_functions.h"

#include <sqlite3.h>

#include <map>
#include <optional>
#include <stdexcept>
#include <string>

#include "server/store/job_cursor.h"
#include "server/store/scene_field.h"

namespace granary::server {

struct JobFunctions::Cursors {
  explicit Cursors(sqlite3* of) : connection(of) {}

  sqlite3* connection;
  bool reading = false;
  std::optional<JobCursor> scenes;
  std::map<std::string, JobCursor> values;

  JobCursor& of_scenes() {
    if (!scenes)
      scenes.emplace(connection,
                     "SELECT id, resolved FROM job NOT INDEXED WHERE id >= ?1 ORDER BY id");
    return *scenes;
  }
  JobCursor& of_value(const std::string& name) {
    return values
        .try_emplace(name, connection,
                     "SELECT job, value, error FROM job_value INDEXED BY job_value_by_name "
                     "WHERE name = ?2 AND job >= ?1 ORDER BY job",
                     name)
        .first->second;
  }
};

namespace {

using Cursors = JobFunctions::Cursors;

struct Reading {
  bool& flag;
  explicit Reading(Cursors& cursors) : flag(cursors.reading) { flag = true; }
  ~Reading() { flag = false; }
};

Cursors& cursors_of(sqlite3_context* context) {
  return *static_cast<Cursors*>(sqlite3_user_data(context));
}

std::string text_of(sqlite3_value* value) {
  const auto* text = reinterpret_cast<const char*>(sqlite3_value_text(value));
  return text ? text : "";
}

// What `make` makes of the text in the second argument, once a statement while that is a constant.
template <typename Made, typename Make>
Made& of_constant(sqlite3_context* context, sqlite3_value** arguments, std::optional<Made>& own,
                  Make make) {
  if (auto* known = static_cast<Made*>(sqlite3_get_auxdata(context, 1))) return *known;
  own.emplace(make(text_of(arguments[1])));
  return *own;
}
template <typename Made>
void keep_for_constant(sqlite3_context* context, std::optional<Made>& own) {
  if (own)
    sqlite3_set_auxdata(context, 1, new Made(std::move(*own)),
                        [](void* made) { delete static_cast<Made*>(made); });
}

// True when the cursor stands on the job's row; otherwise the answer is NULL or the error.
bool found(sqlite3_context* context, JobCursor& cursor, sqlite3_value* job) {
  const int status = cursor.move_to(sqlite3_value_int64(job));
  if (status != SQLITE_ROW && status != SQLITE_DONE) sqlite3_result_error_code(context, status);
  return status == SQLITE_ROW;
}

struct Answer {
  sqlite3_context* context;
  void operator()(std::monostate) const { sqlite3_result_null(context); }
  void operator()(std::int64_t value) const { sqlite3_result_int64(context, value); }
  void operator()(double value) const { sqlite3_result_double(context, value); }
  void operator()(const std::string& value) const {
    sqlite3_result_text(context, value.data(), static_cast<int>(value.size()), SQLITE_TRANSIENT);
  }
};

void scene_field(sqlite3_context* context, int, sqlite3_value** arguments) {
  Cursors& cursors = cursors_of(context);
  const Reading reading(cursors);
  std::optional<SceneField> made;
  const SceneField& field = of_constant(context, arguments, made,
                                        [](const std::string& path) { return SceneField(path); });
  JobCursor& scenes = cursors.of_scenes();
  if (found(context, scenes, arguments[0]))
    std::visit(Answer{context}, field.in(sqlite3_column_blob(scenes.row(), 1),
                                         sqlite3_column_bytes(scenes.row(), 1)));
  keep_for_constant(context, made);
}

template <int kColumn>
void value_column(sqlite3_context* context, int, sqlite3_value** arguments) {
  Cursors& cursors = cursors_of(context);
  const Reading reading(cursors);
  std::optional<JobCursor*> made;
  JobCursor& values = *of_constant(
      context, arguments, made, [&](const std::string& name) { return &cursors.of_value(name); });
  if (found(context, values, arguments[0]))
    sqlite3_result_value(context, sqlite3_column_value(values.row(), kColumn));
  keep_for_constant(context, made);
}

void add(sqlite3* connection, Cursors* cursors, const char* name,
         void (*function)(sqlite3_context*, int, sqlite3_value**)) {
  if (sqlite3_create_function(connection, name, 2,
                              SQLITE_UTF8 | SQLITE_DETERMINISTIC | SQLITE_INNOCUOUS, cursors,
                              function, nullptr, nullptr) != SQLITE_OK)
    throw std::runtime_error(sqlite3_errmsg(connection));
}

}  // namespace

JobFunctions::JobFunctions(sqlite3* connection) : cursors_(new Cursors(connection)) {
  add(connection, cursors_.get(), "scene_field", scene_field);
  add(connection, cursors_.get(), "job_value", value_column<1>);
  add(connection, cursors_.get(), "job_error", value_column<2>);
}

JobFunctions::~JobFunctions() = default;

bool JobFunctions::reading() const {
  return cursors_->reading;
}

}  // namespace granary::server
