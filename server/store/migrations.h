// Numbered migrations: PRAGMA user_version counts those applied. A migration is never edited once
// it has shipped; a change is a new one.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

namespace granary::server {

int newest_schema();

// Each in a transaction of its own. Throws std::runtime_error when the file is newer than we are.
void migrate(SQLite::Database& connection);
// As far as `schema`: how a database of an earlier release looks.
void migrate_to(SQLite::Database& connection, int schema);

}  // namespace granary::server
