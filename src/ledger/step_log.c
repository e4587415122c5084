#include "ledger/step_log.h"

#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/memory.h"
#include "base/text.h"
#include "ledger/schema.h"

static const double VALUE_MOST = 1e4;        // limit of PSNR and error, so that their squares and sums stay finite
static const uint64_t TABLE_MOST = 1u << 26; // photos times epochs: scoring stores a number for each
static const size_t FILE_LIMIT_BYTES = (size_t)1 << 27; // a row has at least 10 bytes: their number fits 32 bits

enum column { STEP, EPOCH, PHOTO, PSNR, L1, COLUMN_COUNT };
static const char *const column_names[COLUMN_COUNT] = {"step", "epoch", "photo", "psnr", "l1"};

struct reading {
    struct vw_step_log *log;
    uint32_t places[COLUMN_COUNT]; // position of each column in a row
    uint32_t field_count;          // fields of the header
    const char **photos;           // owned; of each record; NULL for none
    size_t photo_capacity, record_capacity;
    uint32_t first_epoch, epoch_count; // epochs that a photo is trained in
};

// ---- Fields ----

static const char *field_of(const struct reading *reading, enum column column) {
    return reading->log->csv.fields[reading->places[column]];
}

static enum vw_status refuse_field(const struct reading *reading, enum column column, const char *what) {
    const struct vw_csv *csv = &reading->log->csv;
    return vw_fail(VW_ERROR_INPUT, "%s:%u: field %s: \"%.80s\" is %s; correct it", csv->path, csv->line,
                   column_names[column], field_of(reading, column), what);
}

static enum vw_status read_whole(const struct reading *reading, enum column column, uint64_t most, uint64_t *number) {
    const char *text = field_of(reading, column);
    char *end = NULL;
    errno = 0;
    unsigned long long parsed = isdigit((unsigned char)text[0]) ? strtoull(text, &end, 10) : 0;
    if (!end || *end) return refuse_field(reading, column, "not a whole number");
    if (errno || parsed > most) return refuse_field(reading, column, "too large");
    *number = parsed;
    return VW_OK;
}

// Reads a number; an empty field is NaN.
static enum vw_status read_real(const struct reading *reading, enum column column, double *number) {
    const char *text = field_of(reading, column);
    char *end = NULL;
    errno = 0;
    double parsed = isspace((unsigned char)text[0]) ? 0 : strtod(text, &end);
    if (*text && (!end || end == text || *end)) return refuse_field(reading, column, "not a number");
    if (isfinite(parsed) ? fabs(parsed) > VALUE_MOST : errno == ERANGE)
        return refuse_field(reading, column, "too large: at most 10000 is accepted");
    *number = *text ? parsed : NAN;
    return VW_OK;
}

static enum vw_status read_values(const struct reading *reading, struct vw_step_record *record) {
    bool has_psnr = *field_of(reading, PSNR), has_l1 = *field_of(reading, L1);
    enum vw_status status = read_real(reading, PSNR, &record->val_psnr);
    if (!status) status = read_real(reading, L1, &record->val_l1);
    if (!status && has_psnr != has_l1)
        status = refuse_field(reading, has_psnr ? L1 : PSNR, "empty, but the other value is not; give both or neither");
    if (!status && record->val_l1 < 0)
        status = refuse_field(reading, L1, "negative, but a mean absolute error is at least 0");
    if (status) return status;
    record->nonfinite = has_psnr && !(isfinite(record->val_psnr) && isfinite(record->val_l1));
    record->validated = has_psnr && !record->nonfinite;
    if (!record->validated) record->val_psnr = record->val_l1 = NAN;
    return VW_OK;
}

// ---- Rows ----

static enum vw_status append_record(struct reading *reading, const struct vw_step_record *record, const char *photo) {
    struct vw_step_log *log = reading->log;
    enum vw_status status =
        vw_grow((void **)&log->records, &reading->record_capacity, log->record_count + (size_t)1, sizeof *log->records);
    if (!status)
        status = vw_grow((void **)&reading->photos, &reading->photo_capacity, log->record_count + (size_t)1,
                         sizeof *reading->photos);
    if (status) return status;
    reading->photos[log->record_count] = photo;
    log->records[log->record_count++] = *record;
    return VW_OK;
}

static enum vw_status check_step(const struct reading *reading, uint64_t step, bool first) {
    const struct vw_csv *csv = &reading->log->csv;
    uint64_t next = reading->log->record_count;
    if (step == next || (first && step <= 1)) return VW_OK;
    if (first)
        return vw_fail(VW_ERROR_INPUT,
                       "%s:%u: field step: the first step is %" PRIu64 "; begin the log with step 0 or 1", csv->path,
                       csv->line, step);
    if (step < next)
        return vw_fail(VW_ERROR_INPUT,
                       "%s:%u: field step: step %" PRIu64 " follows step %" PRIu64
                       "; sort the log by step and keep one row per step",
                       csv->path, csv->line, step, next - 1);
    return vw_fail(VW_ERROR_INPUT,
                   "%s:%u: field step: step %" PRIu64 " follows step %" PRIu64
                   "; the log must have every step, because each change is credited to one photo",
                   csv->path, csv->line, step, next - 1);
}

static enum vw_status check_photo(const struct reading *reading, bool first) {
    const char *photo = field_of(reading, PHOTO);
    if (!vw_text_is_clean(photo))
        return refuse_field(reading, PHOTO, "not a valid name: it has control characters or is not UTF-8");
    if (!*photo && !first) return refuse_field(reading, PHOTO, "empty; only the first row may have no photo");
    return VW_OK;
}

// Adds the untrained state before a log that begins with step 1.
static enum vw_status append_start(struct reading *reading) {
    const struct vw_step_record start = {
        .view = VW_RECORD_UNTRAINED, .train_loss = NAN, .val_psnr = NAN, .val_psnr_pooled = NAN, .val_l1 = NAN};
    return append_record(reading, &start, NULL);
}

static enum vw_status read_row(struct reading *reading, bool first) {
    const struct vw_csv *csv = &reading->log->csv;
    struct vw_step_record record = {.view = VW_RECORD_UNTRAINED, .train_loss = NAN, .val_psnr_pooled = NAN};
    uint64_t epoch = 0;
    if (csv->field_count != reading->field_count)
        return vw_fail(VW_ERROR_INPUT, "%s:%u: %u fields, but the header has %u columns; write one field per column",
                       csv->path, csv->line, csv->field_count, reading->field_count);
    enum vw_status status = read_whole(reading, STEP, INT64_MAX, &record.step);
    if (!status) status = check_step(reading, record.step, first);
    if (!status) status = read_whole(reading, EPOCH, UINT32_MAX - 1, &epoch);
    if (!status) status = check_photo(reading, first);
    if (!status) status = read_values(reading, &record);
    if (!status && first && record.step == 1) status = append_start(reading);
    if (status) return status;
    const char *photo = record.step > 0 && *field_of(reading, PHOTO) ? field_of(reading, PHOTO) : NULL;
    if (!photo) return append_record(reading, &record, NULL);
    if (!reading->log->epochs) reading->first_epoch = (uint32_t)epoch;
    if (epoch + 1 < (uint64_t)reading->first_epoch + reading->log->epochs)
        return refuse_field(reading, EPOCH, "smaller than in the row before; epochs must not fall");
    record.epoch = (uint32_t)epoch - reading->first_epoch;
    if (!vw_step_has_epoch(&record))
        return refuse_field(reading, EPOCH, "an epoch too late: by step N at most N epochs after the first have begun");
    if (record.epoch >= reading->log->epochs) reading->epoch_count++;
    reading->log->epochs = record.epoch + 1;
    return append_record(reading, &record, photo);
}

static enum vw_status read_header(struct reading *reading) {
    const struct vw_csv *csv = &reading->log->csv;
    uint32_t counts[COLUMN_COUNT] = {0};
    for (uint32_t i = 0; i < csv->field_count; i++)
        for (enum column c = 0; c < COLUMN_COUNT; c++)
            if (strcmp(csv->fields[i], column_names[c]) == 0) {
                reading->places[c] = i;
                counts[c]++;
            }
    for (enum column c = 0; c < COLUMN_COUNT; c++)
        if (counts[c] != 1)
            return vw_fail(VW_ERROR_INPUT,
                           "%s:%u: the header %s column %s; it must have step, epoch, photo, psnr and l1 once each",
                           csv->path, csv->line, counts[c] ? "has more than one" : "lacks the", column_names[c]);
    reading->field_count = csv->field_count;
    return VW_OK;
}

static enum vw_status read_rows(struct reading *reading) {
    struct vw_csv *csv = &reading->log->csv;
    bool found = false, first = true;
    enum vw_status status = vw_csv_next(csv, &found);
    if (!status) status = read_header(reading);
    for (; !status && !(status = vw_csv_next(csv, &found)) && found; first = false) status = read_row(reading, first);
    if (!status && !reading->log->epochs)
        status = vw_fail(VW_ERROR_INPUT, "%s: no step has a photo; check that the file is complete", csv->path);
    return status;
}

// Fills in the values of steps that were not validated between two that were: each gets an equal share of the change.
static void share_changes(struct vw_step_log *log) {
    const struct vw_step_record *from = NULL; // the last one that was validated
    for (struct vw_step_record *to = log->records; to < log->records + log->record_count; to++) {
        if (!to->validated) continue;
        uint64_t finite = 0, place;
        for (const struct vw_step_record *step = to; from && step > from; step--) finite += !step->nonfinite;
        place = finite;
        for (struct vw_step_record *between = to - 1; from && between > from; between--) {
            if (between->nonfinite) continue;
            double share = (double)--place / (double)finite;
            between->val_psnr = from->val_psnr + share * (to->val_psnr - from->val_psnr);
            between->val_l1 = from->val_l1 + share * (to->val_l1 - from->val_l1);
            between->validated = true;
            log->shared_count++;
            if (to->step - from->step > log->validated_every) log->validated_every = to->step - from->step;
        }
        from = to;
    }
}

// ---- Photos ----

static int compare_names(const void *left, const void *right) {
    return strcmp(*(const char *const *)left, *(const char *const *)right);
}

// Sorts the names, moves one of each to the front, and returns the number of different names.
static uint32_t sort_names(const char **names, uint32_t count) {
    uint32_t distinct = 0;
    qsort(names, count, sizeof *names, compare_names);
    for (uint32_t i = 0; i < count; i++)
        if (i == 0 || strcmp(names[i], names[distinct - 1]) != 0) names[distinct++] = names[i];
    return distinct;
}

// Makes an image for every name, and sets the image of every record.
static enum vw_status number_photos(struct reading *reading) {
    struct vw_step_log *log = reading->log;
    uint32_t used = 0;
    const char **names = vw_allocate(log->record_count, sizeof *names);
    if (!names) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < log->record_count; i++)
        if (reading->photos[i]) names[used++] = reading->photos[i];
    log->image_count = sort_names(names, used);
    log->images = vw_allocate(log->image_count, sizeof *log->images);
    for (uint32_t i = 0; log->images && i < log->image_count; i++)
        log->images[i] = (struct vw_ledger_image){.image_id = i, .name = names[i], .split = "train"};
    for (uint32_t i = 0; log->images && i < log->record_count; i++) {
        if (!reading->photos[i]) continue;
        const char **name = bsearch(&reading->photos[i], names, log->image_count, sizeof *names, compare_names);
        log->records[i].view = (uint32_t)(name - names);
    }
    free(names);
    return log->images ? VW_OK : VW_ERROR_MEMORY;
}

static enum vw_status check_extent(const struct reading *reading) {
    const struct vw_step_log *log = reading->log;
    if (log->image_count > VW_VIEWS_MOST)
        return vw_fail(VW_ERROR_INPUT, "%s: %u photos are more than the limit of %d; leave some out", log->csv.path,
                       log->image_count, VW_VIEWS_MOST);
    if ((uint64_t)log->image_count * reading->epoch_count <= TABLE_MOST) return VW_OK;
    return vw_fail(VW_ERROR_INPUT,
                   "%s: %u photos in %u epochs are too many: photos times epochs is limited to %" PRIu64
                   "; epochs must be passes over the photos, not steps",
                   log->csv.path, log->image_count, reading->epoch_count, TABLE_MOST);
}

enum vw_status vw_step_log_read(const char *path, struct vw_step_log *log) {
    *log = (struct vw_step_log){0};
    struct reading reading = {.log = log};
    enum vw_status status = vw_csv_open(path, FILE_LIMIT_BYTES, &log->csv);
    if (!status) vw_sha256(log->csv.text, log->csv.size_bytes, log->sha256);
    if (!status) status = read_rows(&reading);
    if (!status) share_changes(log);
    if (!status) status = number_photos(&reading);
    if (!status) status = check_extent(&reading);
    free(reading.photos);
    return status;
}

void vw_step_log_clear(struct vw_step_log *log) {
    vw_csv_close(&log->csv);
    free(log->records);
    free(log->images);
    *log = (struct vw_step_log){0};
}
