#include "lab/benchmark_files.h"

#include <inttypes.h>
#include <stdlib.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/memory.h"

struct scene_metrics {
    const char *scene;
    const struct vw_metrics *metrics;
};

static void print_metrics(FILE *stream, const void *context) {
    const struct scene_metrics *rows = context;
    fputs("scene,metric,method,value,ci_low,ci_high,count\n", stream);
    for (size_t i = 0; i < rows->metrics->count; i++) {
        const struct vw_metric *row = &rows->metrics->rows[i];
        const char *const texts[] = {rows->scene, row->metric, row->method};
        const double values[] = {row->value, row->ci_low, row->ci_high};
        for (int t = 0; t < 3; t++) {
            vw_csv_write_text(stream, texts[t]);
            fputc(',', stream);
        }
        for (int v = 0; v < 3; v++) {
            vw_csv_write_real(stream, values[v]);
            fputc(',', stream);
        }
        fprintf(stream, "%u\n", row->count);
    }
}

enum vw_status vw_benchmark_write_metrics(const char *path, const char *scene, const struct vw_metrics *metrics) {
    return vw_csv_write_file(path, print_metrics, &(struct scene_metrics){scene, metrics});
}

// ---- Photos ----

// A column of a value per photo, or of one per retraining seed and photo, whose mean is printed.
struct column {
    const char *name;
    const double *values;
    uint32_t seed_count;
};

struct photo_table {
    const struct vw_benchmark_photos *photos;
    uint32_t photo_count, column_count;
    struct column columns[3 * VW_TRUTH_COUNT];
};

static void print_photos(FILE *stream, const void *context) {
    const struct photo_table *table = context;
    fputs("name", stream);
    for (uint32_t c = 0; c < table->column_count; c++) fprintf(stream, ",%s", table->columns[c].name);
    fputc('\n', stream);
    for (uint32_t i = 0; i < table->photo_count; i++) {
        vw_csv_write_text(stream, table->photos->scene->views[table->photos->views[i]].name);
        for (uint32_t c = 0; c < table->column_count; c++) {
            const struct column *column = &table->columns[c];
            double mean = 0;
            for (uint32_t seed = 0; seed < column->seed_count; seed++)
                mean += column->values[(size_t)seed * table->photo_count + i] / column->seed_count;
            fputc(',', stream);
            vw_csv_write_real(stream, mean);
        }
        fputc('\n', stream);
    }
}

static enum vw_status write_photos(const char *out, const char *name, const struct photo_table *table) {
    char *path = vw_path_join(out, name);
    enum vw_status status = path ? vw_csv_write_file(path, print_photos, table) : VW_ERROR_MEMORY;
    free(path);
    return status;
}

enum vw_status vw_benchmark_write_worths(const char *out, const struct vw_benchmark_photos *photos,
                                         const struct vw_worths *worths) {
    static const char *const names[] = {"worth_db",      "ci_low",      "ci_high",
                                        "test_worth_db", "test_ci_low", "test_ci_high"};
    struct photo_table table = {photos, worths->photo_count, VW_ARRAY_COUNT(names), {{0}}};
    for (uint32_t i = 0; i < VW_ARRAY_COUNT(names); i++) {
        const struct vw_worths *of_truth = &worths[i / 3];
        const double *const values[] = {of_truth->values, of_truth->ci_low, of_truth->ci_high};
        table.columns[i] = (struct column){names[i], values[i % 3], 1};
    }
    return write_photos(out, "worths.csv", &table);
}

enum vw_status vw_benchmark_write_exact(const char *out, const struct vw_benchmark_photos *photos,
                                        const struct vw_exact_values *exact) {
    static const char *const names[] = {"shapley_db",      "banzhaf_db",      "leave_one_out_db",
                                        "test_shapley_db", "test_banzhaf_db", "test_leave_one_out_db"};
    struct photo_table table = {photos, exact->photo_count, VW_ARRAY_COUNT(names), {{0}}};
    for (uint32_t i = 0; i < VW_ARRAY_COUNT(names); i++)
        table.columns[i] =
            (struct column){names[i], exact->values[i / VW_EXACT_COUNT][i % VW_EXACT_COUNT], exact->seed_count};
    return write_photos(out, "exact.csv", &table);
}

struct feature_table {
    const struct vw_benchmark_photos *photos;
    const struct vw_photo_features *features;
    uint64_t first_seed;
};

static void print_features(FILE *stream, const void *context) {
    const struct feature_table *table = context;
    fputs("name,seed", stream);
    for (uint32_t f = 0; f < VW_FEATURE_COUNT; f++) fprintf(stream, ",%s", vw_features[f].name);
    fputc('\n', stream);
    for (uint32_t seed = 0; seed < table->features->seed_count; seed++)
        for (uint32_t i = 0; i < table->features->photo_count; i++) {
            vw_csv_write_text(stream, table->photos->scene->views[table->photos->views[i]].name);
            fprintf(stream, ",%" PRIu64, table->first_seed + seed);
            for (uint32_t f = 0; f < VW_FEATURE_COUNT; f++) {
                fputc(',', stream);
                vw_csv_write_real(stream, vw_photo_feature(table->features, seed, i, (enum vw_feature)f));
            }
            fputc('\n', stream);
        }
}

enum vw_status vw_benchmark_write_features(const char *out, const struct vw_benchmark_photos *photos,
                                           uint64_t first_seed, const struct vw_photo_features *features) {
    const struct feature_table table = {photos, features, first_seed};
    char *path = vw_path_join(out, "photo_features.csv");
    enum vw_status status = path ? vw_csv_write_file(path, print_features, &table) : VW_ERROR_MEMORY;
    free(path);
    return status;
}
