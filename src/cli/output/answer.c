#include "cli/output/results.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "cli/output/print.h"
#include "experiment/experiment.h"
#include "run/out_folder.h"
#include "run/plan/accuracy_levels.h"
#include "value/halves.h"

enum { NAMES_SHOWN = 8 };
#define WORTH_MORE_TIME 1.5 // times as long: a finer training is named from here on

// A line of the answer, in this order.
static const struct line {
    enum vw_advice_word advice;
    const char *label;
    bool names; // names photos; a count says as much of the others
} lines[] = {{VW_ADVICE_KEEP, "keep", true},
             {VW_ADVICE_LOOK, "look at", true},
             {VW_ADVICE_DROP, "leave out", true},
             {VW_ADVICE_UNCLEAR, "cannot tell", false}};

// ---- Photos --------------------------------------------------------------------------------------------------------

void vw_answer_free(struct vw_answer *answer) {
    for (size_t i = 0; i < answer->photo_count; i++) free(answer->photos[i].name);
    free(answer->photos);
    answer->photos = NULL;
    answer->photo_count = 0;
}

enum vw_status vw_answer_take(struct vw_answer *answer, const struct vw_results *results) {
    vw_answer_free(answer);
    answer->photos = vw_allocate(results->advice.count, sizeof *answer->photos);
    if (!answer->photos) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; results->score_count && i < results->advice.count; i++) {
        const struct vw_photo_advice *photo = &results->advice.photos[i];
        answer->photos[i] = (struct vw_answer_photo){.name = vw_copy_text(photo->image->name),
                                                     .reason = photo->reason,
                                                     .advice = photo->advice,
                                                     .score = photo->score ? photo->score->value : NAN};
        if (!answer->photos[i].name) return VW_ERROR_MEMORY;
        answer->photo_count++;
    }
    return VW_OK;
}

// ---- Text ----------------------------------------------------------------------------------------------------------

// Compares by advice and reason; then the highest scores of photos to keep come first, of others the lowest, and photos
// without a score last.
static int compare(const void *left, const void *right) {
    const struct vw_answer_photo *a = left, *b = right;
    if (a->advice != b->advice) return a->advice < b->advice ? -1 : 1;
    int reasons = strcmp(a->reason, b->reason), scores = (a->score > b->score) - (a->score < b->score);
    if (reasons) return reasons;
    if (isnan(a->score) != isnan(b->score)) return isnan(a->score) ? 1 : -1;
    if (scores) return a->advice == VW_ADVICE_KEEP ? -scores : scores;
    return strcmp(a->name, b->name);
}

static size_t shared_folder(const struct vw_answer *answer) {
    size_t length = answer->photo_count ? strlen(answer->photos[0].name) : 0;
    for (size_t i = 0; i < answer->photo_count; i++)
        length = vw_text_shared_folder(answer->photos[0].name, length, answer->photos[i].name);
    return length;
}

// Prints the photos from `first` on that have its advice and reason; returns how many.
static size_t print_group(const struct vw_answer *answer, size_t first, bool names) {
    const struct vw_answer_photo *photos = answer->photos;
    size_t end = first, folder_length = shared_folder(answer);
    while (end < answer->photo_count && photos[end].advice == photos[first].advice &&
           strcmp(photos[end].reason, photos[first].reason) == 0)
        end++;
    if (!names) vw_print("%zu %s", end - first, photos[first].reason);
    for (size_t i = first; names && i < end && i < first + NAMES_SHOWN; i++)
        vw_print("%s%s", i > first ? ", " : "", photos[i].name + folder_length);
    if (names && end - first > NAMES_SHOWN) vw_print(" and %zu more", end - first - NAMES_SHOWN);
    if (names) vw_print(" (%s)", photos[first].reason);
    return end - first;
}

static void print_line(const struct vw_answer *answer, const struct line *line) {
    size_t first = 0, count = 0;
    while (first < answer->photo_count && answer->photos[first].advice != line->advice) first++;
    while (first + count < answer->photo_count && answer->photos[first + count].advice == line->advice) count++;
    if (!count) return;
    vw_print("%-16s%zu: ", line->label, count);
    for (size_t i = first; i < first + count;) {
        if (i > first) vw_print("; ");
        i += print_group(answer, i, line->names);
    }
    vw_print("\n");
}

void vw_reconstruction_print(const struct vw_reconstruction *seen) {
    const uint32_t *trained = seen->trained_px, *measured = seen->measured_px;
    enum vw_verdict verdict = vw_verdict_judge(seen);
    if (verdict == VW_VERDICT_UNKNOWN) return;
    vw_print("reconstruction  %s: %.1f dB and SSIM %.2f, median of %u %s photo%s at %u x %u", vw_verdict_word(verdict),
             seen->psnr_db, seen->ssim, seen->view_count, seen->of_test ? "test" : "validation",
             vw_plural(seen->view_count), measured[0], measured[1]);
    if (trained[0] != measured[0]) vw_print(", trained at %u x %u", trained[0], trained[1]);
    vw_print("; their mean colour has %.1f dB, the nearest train photo %.1f\n", seen->mean_colour_db,
             seen->nearest_photo_db);
}

// Returns the trainings of a verified selection, at most; 0: it is not possible.
static uint32_t count_trainings(const struct vw_answer *answer) {
    uint32_t command = 0;
    if (answer->val_count < VW_HALVES) return 0;
    while (strcmp(vw_priced_commands[command].name, "select") != 0) command++;
    return vw_priced_commands[command].trainings;
}

static void print_cost(uint32_t trainings, double seconds) {
    char time[VW_DURATION_BYTES];
    vw_text_duration(seconds, time);
    vw_print("   (");
    if (trainings) vw_print("up to %u trainings%s", trainings, isfinite(seconds) ? ", " : "");
    if (isfinite(seconds)) vw_print("about %s", time);
    vw_print(")\n");
}

// Prints the command that trains without what covers photos.
static void print_masks(const struct vw_answer *answer) {
    if (!answer->scene || !answer->mask_count) return;
    vw_print("masks           %u of what covers photos: viewworth value", answer->mask_count);
    vw_print_shell_path(answer->scene);
    vw_print(" --masks");
    vw_print_shell_path(answer->out);
    vw_print("/" VW_OUT_MASKS " --splits");
    vw_print_shell_path(answer->out);
    vw_print("/" VW_SPLITS_FILE " --out MASKED\n");
}

// Prints the command that trains the field as well at the photos' stored size, where this one was smaller.
static void print_stored_size(const struct vw_answer *answer) {
    uint32_t times = answer->downscale * answer->downscale;
    if (!answer->scene || times <= 1) return;
    vw_print("to keep it      viewworth train");
    vw_print_shell_path(answer->scene);
    vw_print(" --splits");
    vw_print_shell_path(answer->out);
    vw_print("/" VW_SPLITS_FILE " --downscale 1 --epochs %" PRIu32 " --out FIELD", times * answer->epochs);
    print_cost(0, times * answer->training_s * answer->unvalidated_share);
}

// Prints the command that helps most now, with its cost.
static void print_next(const struct vw_answer *answer, bool scored) {
    bool coarse = vw_verdict_judge(&answer->reconstruction) == VW_VERDICT_TOO_COARSE;
    bool finer = coarse && answer->times_at_most > WORTH_MORE_TIME && isfinite(answer->training_s);
    uint32_t trainings = coarse || !scored ? 0 : count_trainings(answer);
    if (finer) {
        vw_print("next            this command with --accuracy reference and another --out");
        print_cost(0, answer->times_at_most * answer->training_s);
    } else if (trainings) {
        vw_print("next            viewworth select");
        vw_print_shell_path(answer->out);
        vw_print(" --to LIST");
        print_cost(trainings, trainings * answer->training_s * answer->unvalidated_share);
    } else if (answer->has_report) {
        vw_print("next            open");
        vw_print_shell_path(answer->out);
        vw_print("/report.html in a browser\n");
    }
}

enum vw_status vw_answer_begin(const struct vw_run *run, const char *out, struct vw_answer *answer) {
    const struct vw_run_results *results = vw_run_get_results(run);
    *answer = (struct vw_answer){.out = out,
                                 .reconstruction = results->outputs.results.reconstruction,
                                 .downscale = results->downscale,
                                 .epochs = results->config->epochs,
                                 .val_count = results->outputs.results.agreement.view_count,
                                 .times_at_most = vw_accuracy_most_against(results->config),
                                 .unvalidated_share = vw_accuracy_unvalidated_share(results->config),
                                 .mask_count = results->outputs.mask_count,
                                 .has_report = results->outputs.report_path != NULL,
                                 .training_s = NAN};
    return vw_answer_take(answer, &results->outputs.results);
}

void vw_answer_print(struct vw_answer *answer) {
    vw_reconstruction_print(&answer->reconstruction);
    if (answer->photo_count) qsort(answer->photos, answer->photo_count, sizeof *answer->photos, compare);
    for (size_t i = 0; i < VW_ARRAY_COUNT(lines); i++) print_line(answer, &lines[i]);
    print_masks(answer);
    print_stored_size(answer);
    print_next(answer, answer->photo_count > 0);
}
