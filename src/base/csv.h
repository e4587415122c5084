// CSV (RFC 4180): reading record by record, writing field by field.
#ifndef VIEWWORTH_BASE_CSV_H
#define VIEWWORTH_BASE_CSV_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "viewworth/status.h"

enum { VW_CSV_FIELDS_MAX = 4096 }; // in a record: no table has more columns, and a field costs a pointer

// A file while it is read. Lines end with LF or CR LF, the last one possibly with the file. A byte order mark at the
// start and blank lines are skipped. A field has no quotes, or is "quoted" and may then contain commas, line ends and
// doubled quotes. The apostrophe that vw_csv_write_text() adds before formulas is removed.
struct vw_csv {
    const char *path; // borrowed
    char *text;       // owned: the file; fields of all records point into it
    size_t size_bytes;
    char **fields;        // owned array: fields of the current record, without quotes
    uint32_t field_count; // fields of the current record
    uint32_t line;        // first line of the current record, from 1
    char separator;       // a comma; a reader may set a tab, and then quotes and apostrophes are plain characters
    // private
    char *next;
    uint32_t next_line;
    size_t field_capacity;
};

// Reads a file of at most `limit_bytes`. VW_ERROR_INPUT if it cannot be opened or has a zero byte. Close it also after
// a failure.
enum vw_status vw_csv_open(const char *path, size_t limit_bytes, struct vw_csv *csv);
// Opens a table that is already in memory. `csv` owns `text`, which ends with a zero byte, from now on, also after a
// failure. `path` is for messages.
enum vw_status vw_csv_take(const char *path, void *text, size_t size_bytes, struct vw_csv *csv);
// Reads the next record; `*found` is false after the last one. VW_ERROR_INPUT names file and line of a quote that is
// misplaced or not closed, and of a record of more than VW_CSV_FIELDS_MAX fields.
enum vw_status vw_csv_next(struct vw_csv *csv, bool *found);
void vw_csv_close(struct vw_csv *csv);

// Writes a text field, quoted if necessary; nothing for NULL. If the text, or what follows a semicolon in it, begins
// with = + - @ (also in full width), a tab or a line end, after any apostrophes and quotes, an apostrophe is put before
// it. Otherwise a spreadsheet would evaluate it as a formula, and names may come from untrusted scenes.
void vw_csv_write_text(FILE *stream, const char *text);
// Writes the shortest decimal that reads back to the same double, and -0 as 0; an empty field for NaN.
void vw_csv_write_real(FILE *stream, double value);
enum { VW_CSV_REAL_BYTES = 32 };
void vw_csv_real_to_text(double value, char text[VW_CSV_REAL_BYTES]);
// Writes fields as a pattern says: t is a text (const char *), r a real (double), u a whole number (uint32_t); other
// characters are written as they are: "t,r,u\n".
void vw_csv_print(FILE *stream, const char *pattern, ...);
// A table in memory: what `print` writes to its stream. `text` ends with a zero byte and is owned by the caller (free).
// `path` is for the message.
struct vw_csv_text {
    char *text;
    size_t size_bytes;
};
typedef void vw_csv_printer(FILE *stream, const void *context);
enum vw_status vw_csv_make_text(const char *path, vw_csv_printer *print, const void *context, struct vw_csv_text *made);
// Writes the same to the file `path`, completely or not at all.
enum vw_status vw_csv_write_file(const char *path, vw_csv_printer *print, const void *context);

// ---- A list: a name a line ----

// Called with every name, without surrounding spaces, and its line number from 1. The name is borrowed. Blank lines are
// skipped.
typedef enum vw_status vw_name_taker(void *context, int line, const char *name);
// Reads the names; `*count` is their number. Stops at the first failure of `take`. VW_ERROR_INPUT if the file cannot be
// read.
enum vw_status vw_names_read(const char *path, vw_name_taker *take, void *context, uint32_t *count);

#endif
