// CSV (RFC 4180): tables that people and other programs write are read record by record, and ours are written field by
// field.
#ifndef VIEWWORTH_CSV_H
#define VIEWWORTH_CSV_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "viewworth/status.h"

// A file being read. Lines end with LF or CR LF, the last one also with the file; a byte order mark at the start and
// blank lines are passed over. A field is plain, without any quote, or "quoted": then it may hold commas, line ends and
// doubled quotes. The apostrophe that vw_csv_write_text() puts before what a spreadsheet would calculate is taken away
// again.
struct vw_csv {
    const char *path; // borrowed
    char *text;       // owned: the file; fields of all records point into it
    size_t size_bytes;
    char **fields;        // owned array: those of the current record, without quotes
    uint32_t field_count; // of the current record
    uint32_t line;        // where it begins, from 1
    // private
    char *next;
    uint32_t next_line;
    size_t field_capacity;
};

// Reads a file of at most `limit_bytes`. VW_ERROR_INPUT when it cannot be opened or holds a zero byte. Close it also
// after a failure.
enum vw_status vw_csv_open(const char *path, size_t limit_bytes, struct vw_csv *csv);
// Moves on to the next record; `*found` is false after the last one. VW_ERROR_INPUT names file and line of a quote that
// is misplaced or stays open.
enum vw_status vw_csv_next(struct vw_csv *csv, bool *found);
void vw_csv_close(struct vw_csv *csv);

// A text field, quoted when it must be; nothing for NULL. A text that begins, apostrophes aside, with = + - @, a tab or
// a line end is written behind one more apostrophe, since spreadsheets would take it for a formula: names come from
// scenes that anybody may have made.
void vw_csv_write_text(FILE *stream, const char *text);
// The shortest decimal that reads back to the same double; an empty field for NaN.
void vw_csv_write_real(FILE *stream, double value);
// Writes what `print` puts into the stream to `path`, whole or not at all.
typedef void vw_csv_printer(FILE *stream, const void *context);
enum vw_status vw_csv_write_file(const char *path, vw_csv_printer *print, const void *context);

#endif
