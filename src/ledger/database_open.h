// Opens database files, which may come from someone who wants to harm, and makes new ones.
#ifndef VIEWWORTH_LEDGER_DATABASE_OPEN_H
#define VIEWWORTH_LEDGER_DATABASE_OPEN_H

#include "ledger/database.h"

// Each of these is to be followed by vw_database_close(), also after a failure.

// Opens a file that exists and checks all of it. VW_ERROR_INPUT if it is not exactly of this format.
enum vw_status vw_database_open(const char *path, const struct vw_database_format *format,
                                enum vw_database_access access, struct vw_database *database);
// Creates a new database in memory with the tables of the format; messages name `path`.
enum vw_status vw_database_open_memory(const char *path, const struct vw_database_format *format,
                                       struct vw_database *database);
// Writes a database in memory as a new file of its path. VW_ERROR_USAGE if that exists.
enum vw_status vw_database_create_file(struct vw_database *database);
// Opens a file to append, and makes it with empty tables if it is missing.
enum vw_status vw_database_open_or_create(const char *path, const struct vw_database_format *format,
                                          struct vw_database *database);

#endif
