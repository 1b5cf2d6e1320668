// The documented, stable views of the query door: what users may ask about, in SQL. The views are
// temporary ones of each query's own connection; the tables below them may change with any
// migration.
#pragma once

#include <string>
#include <vector>

namespace granary::server {

struct ViewColumnText {
  std::string name;
  std::string expression;  // over the tables of `from`
  std::string meaning;
};

struct ViewText {
  std::string name;
  std::string meaning;
  std::string from;  // what stands behind FROM
  std::vector<ViewColumnText> columns;
};

// A value that some job has had: its error column is derived from it ("f1_m" -> "f1_error_m").
struct ValueName {
  std::string name;
  std::string unit;
};

struct KnownValues {
  std::vector<ValueName> discharge;
  std::vector<ValueName> chute;
};

// `seen`: values found in the database; the documented ones are always there.
std::vector<ViewText> query_views(const KnownValues& seen);

std::string error_column(const ValueName& value);

}  // namespace granary::server
