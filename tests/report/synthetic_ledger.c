// Writes the ledger of a run that never was, for tests of its report:
//
//     synthetic_ledger FILE PHOTOS [plain|hostile [EPOCHS [VIEWS]]]    so many train photos, VIEWS (12) to validate,
//     EPOCHS (3); hostile: names that would break a page
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/memory.h"
#include "base/random.h"
#include "base/statistics.h"
#include "train/identity.h"
#include "viewworth/ledger.h"
#include "viewworth/train.h"
#include "viewworth/value.h"

enum { VIEWS_MOST = 64, SEED = 7 };
static const char zeros[] = "0000000000000000000000000000000000000000000000000000000000000000";
static const char *const hostile_names[] = {
    "/a.png", // a page that looks for the folder of all names ends
    "</script><script>window.broken = 1</script>.png",
    "<img src=x onerror=\"window.broken = 2\">.png",
    "<!-- <script>.png",
    "\" onmouseover=\"window.broken = 3\" '.png",
    "\xe4\xba\xac & ampersand.png", // beyond ASCII
    "=HYPERLINK(\"javascript:window.broken=4\").png",
    "{{data}} ${window.broken = 5} `.png",
    "__proto__",
};

struct synthetic {
    struct vw_ledger_image *images;
    uint32_t photos, epochs, view_count, image_count, record_count;
    struct vw_step_record *records;
    struct vw_view_error *errors; // view_count per record
    uint32_t views[VIEWS_MOST];
};

static double draw(uint32_t step, uint32_t item) {
    uint32_t words[4];
    vw_random_words(SEED, VW_RANDOM_JITTER, step, item, 0, words);
    return vw_random_unit(words[0]) - 0.5;
}

static enum vw_status name_images(struct synthetic *run, bool hostile) {
    static const char *const providers[] = {"anna", "Smith & Sons", "<b>chris</b>", ""};
    for (uint32_t i = 0; i < run->image_count; i++) {
        bool validates = i >= run->photos, odd = hostile && i < VW_ARRAY_COUNT(hostile_names);
        char *name =
            odd ? vw_copy_text(hostile_names[i]) : vw_format_text("photos/%s_%04u.jpg", validates ? "val" : "train", i);
        if (!name) return VW_ERROR_MEMORY;
        run->images[i] = (struct vw_ledger_image){.image_id = i,
                                                  .name = name,
                                                  .split = validates ? "val" : "train",
                                                  .provider = providers[i % 4],
                                                  .sha256 = zeros};
        if (validates) run->views[i - run->photos] = i;
    }
    return VW_OK;
}

// Takes the steps: photo i moves PSNR by a tenth of what is drawn for it, and by as much noise.
static void take_steps(struct synthetic *run) {
    double psnr_db = 12;
    for (uint32_t step = 0; step < run->record_count; step++) {
        uint32_t photo = step ? (step - 1) % run->photos : 0;
        struct vw_view_error *errors = &run->errors[(size_t)step * run->view_count];
        if (step) psnr_db += 0.1 * (draw(0, photo) + draw(step, 1));
        double mean_db = 0, mse = 0, l1 = 0;
        for (uint32_t v = 0; v < run->view_count; v++) {
            double view_db = psnr_db + draw(step, 2 + v);
            errors[v] = (struct vw_view_error){.mse = pow(10, -view_db / 10), .l1 = 0.4 * pow(10, -view_db / 20)};
            mean_db += vw_psnr_db(errors[v].mse) / run->view_count;
            mse += errors[v].mse / run->view_count;
            l1 += errors[v].l1 / run->view_count;
        }
        run->records[step] = (struct vw_step_record){.step = step,
                                                     .epoch = step ? (step - 1) / run->photos : 0,
                                                     .view = step ? photo : (uint32_t)VW_RECORD_UNTRAINED,
                                                     .train_loss = step ? 0.1 : NAN,
                                                     .validated = true,
                                                     .val_psnr = mean_db,
                                                     .val_psnr_pooled = vw_psnr_db(mse),
                                                     .val_l1 = l1,
                                                     .views = errors,
                                                     .view_count = run->view_count};
    }
}

static enum vw_status make(struct synthetic *run, bool hostile) {
    run->image_count = run->photos + run->view_count;
    run->record_count = 1 + run->epochs * run->photos;
    run->images = vw_allocate(run->image_count, sizeof *run->images);
    run->records = vw_allocate(run->record_count, sizeof *run->records);
    run->errors = vw_allocate((size_t)run->record_count * run->view_count, sizeof *run->errors);
    if (!run->images || !run->records || !run->errors) return VW_ERROR_MEMORY;
    enum vw_status status = name_images(run, hostile);
    if (!status) take_steps(run);
    return status;
}

// Finds the subset hash and the run id, so that verify, which recomputes them, can be timed.
static enum vw_status name_run(const struct synthetic *run, struct vw_ledger_run *row, const struct vw_config *config,
                               char subset[VW_HASH_HEX_BYTES], char run_id[VW_HASH_HEX_BYTES]) {
    const struct vw_effect_decision sky = {.name = "sky", .on = true};
    struct vw_run_identity identity = {.version = row->version,
                                       .device = row->device,
                                       .driver = row->driver,
                                       .config = config,
                                       .effects = &sky,
                                       .effect_count = 1,
                                       .validates = true};
    struct vw_hasher hasher;
    uint8_t hash[VW_HASH_BYTES];
    vw_hasher_begin(&hasher);
    for (uint32_t i = 0; i < run->image_count; i++)
        if (strcmp(run->images[i].split, "train") == 0) vw_hasher_add_text(&hasher, run->images[i].name);
    vw_hasher_end(&hasher, identity.subset_hash);
    vw_hash_to_hex(identity.subset_hash, subset);
    enum vw_status status = vw_identity_run_id(&identity, hash);
    vw_hash_to_hex(hash, run_id);
    row->subset_hash = subset;
    row->run_id = run_id;
    return status;
}

static enum vw_status write_run(const char *path, const struct synthetic *run, bool hostile) {
    char subset[VW_HASH_HEX_BYTES], run_id[VW_HASH_HEX_BYTES];
    struct vw_config config = vw_config_of_field(VW_FIELD_HASH);
    config.epochs = run->epochs;
    config.seed = SEED;
    char *config_json = vw_config_to_json(&config, false);
    struct vw_ledger_run row = {.scene_hash = zeros,
                                .seed = SEED,
                                .config_json = config_json,
                                .scene_path =
                                    hostile ? "scenes/</title><script>window.broken = 6</script>" : "scenes/none",
                                .device = "no device",
                                .driver = "none",
                                .shader_hash = zeros,
                                .version = "0.1.0",
                                .started_utc = "2026-11-22T01:00:00Z",
                                .scene_options_json = "{}",
                                .effects_json = "[{\"name\":\"sky\",\"on\":true,\"called_for\":true,\"evidence\":0.5,"
                                                "\"threshold\":0.1,\"meaning\":\"<i>share</i>\"}]"};
    const struct vw_value_input input = {.records = run->records,
                                         .record_count = run->record_count,
                                         .burn_in_epochs = 1,
                                         .images = run->images,
                                         .image_count = run->image_count};
    struct vw_ledger *ledger = NULL;
    struct vw_ledger_score *scores = NULL;
    uint32_t score_count = 0;
    enum vw_status status = config_json ? vw_value_score(&input, &scores, &score_count) : VW_ERROR_MEMORY;
    if (!status) status = name_run(run, &row, &config, subset, run_id);
    if (!status) status = vw_ledger_create(path, &row, run->images, run->image_count, &ledger);
    if (!status) status = vw_ledger_append(ledger, run->records, run->record_count, run->views);
    if (!status) status = vw_ledger_set_field(ledger, zeros);
    if (!status) status = vw_ledger_finish(ledger, "finished", "2026-11-22T01:23:45Z", scores, score_count);
    vw_ledger_close(&ledger);
    free(scores);
    free(config_json);
    return status;
}

int main(int argc, char **argv) {
    struct synthetic run = {.photos = argc > 2 ? (uint32_t)atoi(argv[2]) : 0,
                            .epochs = argc > 4 ? (uint32_t)atoi(argv[4]) : 3,
                            .view_count = argc > 5 ? (uint32_t)atoi(argv[5]) : 12};
    bool hostile = argc > 3 && strcmp(argv[3], "hostile") == 0;
    if (run.photos < VW_ARRAY_COUNT(hostile_names) || run.view_count > VIEWS_MOST) return 2;
    enum vw_status status = make(&run, hostile);
    if (!status) status = write_run(argv[1], &run, hostile);
    if (status) fprintf(stderr, "%s\n", vw_error_message());
    for (uint32_t i = 0; run.images && i < run.image_count; i++) free((char *)run.images[i].name);
    free(run.images);
    free(run.records);
    free(run.errors);
    return status ? 1 : 0;
}
