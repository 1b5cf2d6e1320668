// SQL functions that the query door's views are written in:
//   scene_field(job, 'path')                        a field of the scene as run
//   job_value(job, 'name'), job_error(job, 'name')  a value, the half-width of its 95 % interval
// NULL when there is none. Each keeps a cursor that goes along with the view's scan over the jobs.
#pragma once

#include <memory>

struct sqlite3;

namespace granary::server {

class JobFunctions {
 public:
  // Throws std::runtime_error. To be destroyed before its connection closes, and after the last
  // statement that uses the functions.
  explicit JobFunctions(sqlite3* connection);
  ~JobFunctions();
  JobFunctions(const JobFunctions&) = delete;
  JobFunctions& operator=(const JobFunctions&) = delete;

  // While they read tables on behalf of a view: the authorizer hears of no view then.
  bool reading() const;

  struct Cursors;

 private:
  std::unique_ptr<Cursors> cursors_;
};

}  // namespace granary::server
