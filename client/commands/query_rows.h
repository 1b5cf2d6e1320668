// Rows of a read-only query, as a table of JSON cells.
#pragma once

#include "client/commands/command_line.h"

namespace granary::commands {

// All rows before any is shown: a query that fails half-way prints no half of an answer. Column
// names are made distinct ("n", "n_2", ..), since JSON objects need that.
Result<render::Table> query_rows(Context& context, const v1::QueryRequest& request);
Result<render::Table> query_rows(Context& context, const std::string& sql);

}  // namespace granary::commands
