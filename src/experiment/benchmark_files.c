#include "experiment/benchmark_files.h"

#include <stdlib.h>

#include "base/csv.h"
#include "base/file.h"

static enum vw_status write_file(const char *out, const char *name, void (*print)(FILE *, const void *),
                                 const void *context) {
    char *path = vw_path_join(out, name);
    enum vw_status status = path ? vw_csv_write_file(path, print, context) : VW_ERROR_MEMORY;
    free(path);
    return status;
}

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

struct photo_worths {
    const struct vw_scene *scene;
    const uint32_t *photos;
    const struct vw_worths *worths;
};

static void print_worths(FILE *stream, const void *context) {
    const struct photo_worths *rows = context;
    fputs("name,worth_db,ci_low,ci_high,test_worth_db,test_ci_low,test_ci_high\n", stream);
    for (uint32_t i = 0; i < rows->worths->photo_count; i++) {
        vw_csv_write_text(stream, rows->scene->views[rows->photos[i]].name);
        for (uint32_t truth = 0; truth < VW_TRUTH_COUNT; truth++) {
            const struct vw_worths *worths = &rows->worths[truth];
            const double values[] = {worths->values[i], worths->ci_low[i], worths->ci_high[i]};
            for (int v = 0; v < 3; v++) {
                fputc(',', stream);
                vw_csv_write_real(stream, values[v]);
            }
        }
        fputc('\n', stream);
    }
}

enum vw_status vw_benchmark_write_worths(const char *out, const struct vw_scene *scene, const uint32_t *photos,
                                         const struct vw_worths *worths) {
    return write_file(out, "worths.csv", print_worths, &(struct photo_worths){scene, photos, worths});
}
