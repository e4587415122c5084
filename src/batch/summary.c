#include "batch/summary.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/memory.h"

struct vw_summary_row *vw_summary_of_runs(const struct vw_merged_runs *runs) {
    struct vw_summary_row *rows = vw_allocate(runs->count, sizeof *rows);
    for (uint32_t i = 0; rows && i < runs->count; i++)
        rows[i] = (struct vw_summary_row){.job = runs->runs[i].job,
                                          .state = runs->runs[i].status,
                                          .exit_code = -1,
                                          .seconds = NAN,
                                          .run = &runs->runs[i]};
    return rows;
}

struct table {
    const char *out;
    const struct vw_summary_row *rows;
    uint32_t count;
};

// Prints the path of a run's report from OUT; nothing for a run elsewhere.
static void print_report(FILE *stream, const char *out, const char *folder) {
    size_t length = strlen(out);
    while (length > 1 && out[length - 1] == '/') length--;
    if (strncmp(folder, out, length) != 0 || folder[length] != '/') return;
    vw_csv_write_text(stream, folder + length + strspn(folder + length, "/"));
    fputs("/report.html", stream);
}

static void print_run(FILE *stream, const char *out, const struct vw_merged_run *run) {
    if (!run) {
        fputs(",,,,,,", stream);
        return;
    }
    fprintf(stream, "%" PRIu32 ",%" PRIu64 ",%" PRIu32, run->photos, run->steps, run->epochs);
    vw_csv_print(stream, ",r,r,", run->first_psnr, run->val_psnr);
    print_report(stream, out, run->folder);
    fputc(',', stream);
}

static void print_table(FILE *stream, const void *context) {
    const struct table *table = context;
    fputs("job,state,exit_code,seconds,photos,steps,epochs,first_psnr,val_psnr,report,message\n", stream);
    for (uint32_t i = 0; i < table->count; i++) {
        const struct vw_summary_row *row = &table->rows[i];
        vw_csv_print(stream, "t,t,", row->job, row->state);
        if (row->exit_code >= 0) fprintf(stream, "%d", row->exit_code);
        fputc(',', stream);
        if (!isnan(row->seconds)) fprintf(stream, "%.1f", row->seconds);
        fputc(',', stream);
        print_run(stream, table->out, row->run);
        vw_csv_print(stream, "t\n", row->message);
    }
}

enum vw_status vw_summary_write(const char *out, const struct vw_summary_row *rows, uint32_t count) {
    char *path = vw_path_join(out, "summary.csv");
    enum vw_status status =
        path ? vw_csv_write_file(path, print_table, &(struct table){out, rows, count}) : VW_ERROR_MEMORY;
    free(path);
    return status;
}
