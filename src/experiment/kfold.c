#include "experiment/kfold.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/inside.h"
#include "base/memory.h"
#include "experiment/experiment.h"
#include "experiment/fold_scores.h"
#include "report/tables.h"
#include "run/out_lock.h"
#include "run/outputs/report_folder.h"
#include "run/scoring.h"
#include "scene/splits_file.h"
#include "value/evaluation/score_tables.h"
#include "value/matrix.h"
#include "viewworth/log.h"
#include "viewworth/value.h"

enum { TRAIN_PHOTOS_LEAST = 2, LIST_COUNT = VW_SPLIT_EXCLUDED };
static const size_t LIST_LIMIT_BYTES = (size_t)1 << 26;

// A training, and what its ledger says.
struct fold {
    char *lists[LIST_COUNT]; // owned: paths by split; NULL without test photos
    struct vw_session session;
    struct vw_ledger *ledger;
    struct vw_value_input input;
    struct vw_ledger_score *scores;
    uint32_t score_count;
};

struct work {
    const struct vw_kfold_params *params;
    struct vw_kfold *kfold;
    uint32_t *fold_of; // by view
    struct vw_planned_run runs[VW_FOLDS_MOST];
    struct fold folds[VW_FOLDS_MOST];
    struct vw_ledger_image *images; // all photos of the folds, as photos to train on
    uint32_t image_count;
};

// ---- Which photos are in which fold ---------------------------------------------------------------------------------

struct numbered {
    uint8_t number[VW_HASH_BYTES];
    const char *name;
    uint32_t view;
};

static int compare_numbered(const void *left, const void *right) {
    const struct numbered *a = left, *b = right;
    int order = memcmp(a->number, b->number, sizeof a->number);
    return order ? order : strcmp(a->name, b->name);
}

static uint32_t number_photos(const struct vw_scene *scene, uint64_t seed, struct numbered *photos) {
    uint32_t count = 0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        const struct vw_view *view = &scene->views[v];
        if (view->split != VW_SPLIT_TRAIN && view->split != VW_SPLIT_VAL) continue;
        struct vw_hasher hasher;
        vw_hasher_begin(&hasher);
        vw_hasher_add_integer(&hasher, (int64_t)seed);
        vw_hasher_add_text(&hasher, view->name);
        vw_hasher_end(&hasher, photos[count].number);
        photos[count].name = view->name;
        photos[count++].view = v;
    }
    if (count) qsort(photos, count, sizeof *photos, compare_numbered);
    return count;
}

enum vw_status vw_kfold_divide(const struct vw_scene *scene, uint64_t seed, uint32_t folds, uint32_t **fold_of) {
    struct numbered *photos = vw_allocate(scene->view_count, sizeof *photos);
    uint32_t *made = vw_allocate(scene->view_count, sizeof *made);
    uint32_t count = photos && made ? number_photos(scene, seed, photos) : 0;
    enum vw_status status = photos && made ? VW_OK : VW_ERROR_MEMORY;
    if (!status && (!folds || count < folds || count - (count + folds - 1) / folds < TRAIN_PHOTOS_LEAST))
        status = vw_fail(VW_ERROR_USAGE,
                         "--kfold %u: the scene has %u photos to train and validate on; every fold needs one, and the "
                         "others at least %d: use a smaller K or more photos",
                         folds, count, TRAIN_PHOTOS_LEAST);
    for (uint32_t v = 0; !status && v < scene->view_count; v++) made[v] = UINT32_MAX;
    for (uint32_t i = 0; !status && i < count; i++) made[photos[i].view] = i % folds;
    free(photos);
    if (status) free(made);
    else *fold_of = made;
    return status;
}

// ---- Lists ----------------------------------------------------------------------------------------------------------

struct list {
    const struct work *work;
    uint32_t fold;
    enum vw_split split;
};

static enum vw_split split_in(const struct work *work, uint32_t fold, uint32_t view) {
    if (work->fold_of[view] == UINT32_MAX) return work->kfold->session.scene->views[view].split;
    return work->fold_of[view] == fold ? VW_SPLIT_VAL : VW_SPLIT_TRAIN;
}

static void print_names(FILE *stream, const void *context) {
    const struct list *list = context;
    const struct vw_scene *scene = list->work->kfold->session.scene;
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (split_in(list->work, list->fold, v) == list->split) fprintf(stream, "%s\n", scene->views[v].name);
}

// Creates a list, or checks that an existing one is the same: the runs of the folder were made with it.
static enum vw_status keep_or_create(const char *path, const struct vw_csv_text *text) {
    void *held = NULL;
    size_t held_bytes = 0;
    if (!vw_file_exists(path)) return vw_file_create(path, text->text, text->size_bytes);
    enum vw_status status = vw_file_read(path, LIST_LIMIT_BYTES, &held, &held_bytes);
    bool same = !status && held_bytes == text->size_bytes && !memcmp(held, text->text, held_bytes);
    free(held);
    if (status || same) return status;
    return vw_fail(VW_ERROR_USAGE,
                   "%s: has other photos; the folder was made with another --kfold, --seed or scene: repeat its "
                   "command, or name another --out",
                   path);
}

static enum vw_status write_list(const struct work *work, uint32_t fold, enum vw_split split, char **path) {
    const char *out = work->params->common.out;
    struct vw_csv_text text = {0};
    char *name = vw_format_text("%s/%s.txt", work->runs[fold].folder, vw_split_name(split));
    *path = name ? vw_path_join(out, name) : NULL;
    enum vw_status status = *path ? vw_file_check_inside(out, name) : VW_ERROR_MEMORY;
    if (!status) status = vw_csv_make_text(*path, print_names, &(struct list){work, fold, split}, &text);
    if (!status) status = keep_or_create(*path, &text);
    free(text.text);
    free(name);
    return status;
}

static enum vw_status write_lists(struct work *work, uint32_t fold) {
    const struct vw_scene *scene = work->kfold->session.scene;
    enum vw_status status = vw_folder_create_inside(work->params->common.out, work->runs[fold].folder);
    for (enum vw_split split = 0; !status && split < VW_SPLIT_EXCLUDED; split++)
        if (split != VW_SPLIT_TEST || scene->split_count[VW_SPLIT_TEST])
            status = write_list(work, fold, split, &work->folds[fold].lists[split]);
    return status;
}

static enum vw_status plan(struct work *work) {
    const struct vw_experiment_params *params = &work->params->common;
    enum vw_status status = VW_OK;
    for (uint32_t k = 0; !status && k < work->params->folds; k++) {
        struct vw_planned_run *run = &work->runs[k];
        struct fold *fold = &work->folds[k];
        *run = (struct vw_planned_run){.seed = params->config->seed + k, .session = &fold->session, .owns_scene = true};
        snprintf(run->folder, sizeof run->folder, "fold-%u", k + 1);
        snprintf(run->what, sizeof run->what, "fold     %u of %u, seed %" PRIu64, k + 1, work->params->folds,
                 run->seed);
        status = write_lists(work, k);
        run->scene = params->scene;
        run->scene.train_list = fold->lists[VW_SPLIT_TRAIN];
        run->scene.val_list = fold->lists[VW_SPLIT_VAL];
        run->scene.test_list = fold->lists[VW_SPLIT_TEST];
        run->scene.splits = NULL;
    }
    return status;
}

// ---- Trainings ------------------------------------------------------------------------------------------------------

static bool all_begun(const struct work *work) {
    bool begun = true;
    for (uint32_t k = 0; begun && k < work->params->folds; k++) {
        char *name = vw_path_join(work->runs[k].folder, "ledger.db");
        begun = name && vw_file_exists_inside(work->params->common.out, name);
        free(name);
    }
    return begun;
}

// Shares the devices and the effects of the whole scene among all folds; a run that exists keeps its own.
static enum vw_status share_session(struct work *work) {
    struct vw_session *base = &work->kfold->session;
    enum vw_status status = all_begun(work) ? VW_OK : vw_session_decide_effects(work->params->common.config, base);
    for (uint32_t k = 0; !status && k < work->params->folds; k++) {
        struct vw_session *session = &work->folds[k].session;
        memcpy(session->devices, base->devices, sizeof session->devices);
        session->device_count = base->device_count;
        session->effect_count = base->effect_count;
        memcpy(session->effects, base->effects, sizeof session->effects);
    }
    return status;
}

// Trains the folds; the photos of a fold are in memory only while it trains.
static enum vw_status train(struct work *work) {
    vw_log_info("kfold    %u trainings, less what is done already; Ctrl-C keeps what is done", work->params->folds);
    return vw_run_group_make(&work->params->common, work->runs, work->params->folds);
}

// ---- Scores ---------------------------------------------------------------------------------------------------------

// Checks that views have the same index in all folds and in the open scene.
static enum vw_status check_images(const struct work *work, uint32_t k) {
    const struct vw_scene *scene = work->kfold->session.scene;
    const struct vw_value_input *input = &work->folds[k].input;
    bool same = input->image_count == scene->view_count;
    for (uint32_t i = 0; same && i < input->image_count; i++) {
        const struct vw_ledger_image *image = &input->images[i];
        same = image->image_id == i && !strcmp(image->name, scene->views[i].name) &&
               !strcmp(image->split, vw_split_name(split_in(work, k, i)));
    }
    if (same) return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "%s/%s: its ledger has other photos than the scene; repeat the command that made it",
                   work->params->common.out, work->runs[k].folder);
}

static void describe(const struct fold *fold, uint32_t number, struct vw_kfold_fold *about) {
    const struct vw_value_input *input = &fold->input;
    about->number = number;
    for (uint32_t i = 0; i < input->image_count; i++) {
        about->train_count += !strcmp(input->images[i].split, vw_split_name(VW_SPLIT_TRAIN));
        about->validation_count += !strcmp(input->images[i].split, vw_split_name(VW_SPLIT_VAL));
    }
    about->first_val_psnr_db = about->last_val_psnr_db = NAN;
    for (uint64_t i = 0; i < input->record_count; i++) {
        const struct vw_step_record *record = &input->records[i];
        about->steps += record->view != VW_RECORD_UNTRAINED;
        if (!isfinite(record->val_psnr)) continue;
        if (isnan(about->first_val_psnr_db)) about->first_val_psnr_db = record->val_psnr;
        about->last_val_psnr_db = record->val_psnr;
    }
}

// Reads a fold, which may have more epochs than are asked for.
static enum vw_status read_fold(struct work *work, uint32_t k) {
    const struct vw_experiment_params *params = &work->params->common;
    struct fold *fold = &work->folds[k];
    enum vw_status status = vw_run_group_open_ledger(params->out, work->runs[k].folder, &fold->ledger);
    if (!status) status = vw_scoring_load(fold->ledger, params->config, &fold->input);
    if (!status) status = check_images(work, k);
    if (status) return status;
    fold->input = vw_value_input_truncate(&fold->input, params->config->epochs);
    describe(fold, k + 1, &work->kfold->folds[k]);
    return vw_value_score(&fold->input, &fold->scores, &fold->score_count);
}

static enum vw_status compare_folds(struct work *work) {
    uint32_t folds = work->params->folds, photos = work->kfold->session.scene->view_count;
    double *values = vw_allocate((size_t)folds * photos, sizeof *values);
    struct vw_agreement_summary pearson;
    if (!values) return VW_ERROR_MEMORY;
    for (size_t i = 0; i < (size_t)folds * photos; i++) values[i] = NAN;
    for (uint32_t k = 0; k < folds; k++)
        for (uint32_t i = 0; i < work->folds[k].score_count; i++) {
            const struct vw_ledger_score *score = &work->folds[k].scores[i];
            if (!strcmp(score->method, vw_value_default_method) && score->visits)
                values[(size_t)k * photos + score->image_id] = score->value;
        }
    enum vw_status status = vw_agreement_of_runs(values, folds, photos, &pearson, &work->kfold->agreement);
    free(values);
    return status;
}

static enum vw_status score(struct work *work) {
    struct vw_fold_scores scores[VW_FOLDS_MOST];
    enum vw_status status = VW_OK;
    for (uint32_t k = 0; !status && k < work->params->folds; k++) {
        status = read_fold(work, k);
        scores[k] = (struct vw_fold_scores){work->folds[k].scores, work->folds[k].score_count};
    }
    if (!status) status = compare_folds(work);
    if (status) return status;
    return vw_fold_scores_pool(scores, work->params->folds, &work->kfold->scores, &work->kfold->score_count);
}

// ---- Tables ---------------------------------------------------------------------------------------------------------

static enum vw_status list_images(struct work *work) {
    const struct vw_scene *scene = work->kfold->session.scene;
    work->images = vw_allocate(scene->view_count, sizeof *work->images);
    if (!work->images) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        const struct vw_view *view = &scene->views[v];
        if (work->fold_of[v] != UINT32_MAX)
            work->images[work->image_count++] = (struct vw_ledger_image){
                .image_id = v, .name = view->name, .split = vw_split_name(VW_SPLIT_TRAIN), .provider = view->provider};
    }
    return VW_OK;
}

static enum vw_status begin_matrix(const struct work *work, struct vw_matrix *matrix, uint32_t **places) {
    size_t count = work->image_count;
    *matrix = (struct vw_matrix){.photos = vw_allocate(count, sizeof *matrix->photos),
                                 .views = vw_allocate(count, sizeof *matrix->views),
                                 .photo_count = work->image_count,
                                 .view_count = work->image_count,
                                 .psnr = vw_allocate(count * count, sizeof *matrix->psnr),
                                 .l1 = vw_allocate(count * count, sizeof *matrix->l1)};
    *places = vw_allocate(work->kfold->session.scene->view_count, sizeof **places);
    if (!matrix->photos || !matrix->views || !matrix->psnr || !matrix->l1 || !*places) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < work->image_count; i++) {
        matrix->photos[i] = matrix->views[i] = work->images[i].image_id;
        (*places)[work->images[i].image_id] = i;
    }
    for (size_t i = 0; i < count * count; i++) matrix->psnr[i] = matrix->l1[i] = NAN;
    return VW_OK;
}

static void take_matrix(const struct vw_matrix *of_fold, const uint32_t *places, struct vw_matrix *matrix) {
    for (uint32_t p = 0; p < of_fold->photo_count; p++)
        for (uint32_t v = 0; v < of_fold->view_count; v++) {
            size_t from = (size_t)p * of_fold->view_count + v;
            size_t to = (size_t)places[of_fold->photos[p]] * matrix->view_count + places[of_fold->views[v]];
            matrix->psnr[to] = of_fold->psnr[from];
            matrix->l1[to] = of_fold->l1[from];
        }
}

// Returns the standard error of the mean of the known values.
static double stderr_of(const double *row, uint32_t count) {
    double sum = 0, squares = 0;
    uint32_t known = 0;
    for (uint32_t i = 0; i < count; i++) known += isfinite(row[i]);
    for (uint32_t i = 0; i < count; i++) sum += isfinite(row[i]) ? row[i] : 0;
    for (uint32_t i = 0; i < count; i++)
        squares += isfinite(row[i]) ? (row[i] - sum / known) * (row[i] - sum / known) : 0;
    return known > 1 ? sqrt(squares / known / (known - 1)) : NAN;
}

static enum vw_status write_matrix(struct work *work) {
    struct vw_matrix matrix;
    uint32_t *places = NULL;
    double *errors = vw_allocate(work->image_count, sizeof *errors);
    enum vw_status status = begin_matrix(work, &matrix, &places);
    if (!errors) status = VW_ERROR_MEMORY;
    for (uint32_t k = 0; !status && k < work->params->folds; k++) {
        struct vw_matrix of_fold;
        status = vw_value_matrix(work->folds[k].ledger, &work->folds[k].input, &of_fold);
        if (!status) take_matrix(&of_fold, places, &matrix);
        vw_matrix_clear(&of_fold);
    }
    for (uint32_t p = 0; !status && p < matrix.photo_count; p++)
        errors[p] = stderr_of(&matrix.psnr[(size_t)p * matrix.view_count], matrix.view_count);
    if (!status)
        status = vw_table_write_matrix(work->kfold->matrix_path, &matrix, errors, work->images, work->image_count);
    vw_matrix_clear(&matrix);
    free(places);
    free(errors);
    return status;
}

static void print_list(FILE *stream, const void *context) {
    const struct work *work = context;
    fputs("name,score\n", stream);
    for (uint32_t i = 0; i < work->kfold->score_count; i++) {
        const struct vw_ledger_score *score = &work->kfold->scores[i];
        if (!strcmp(score->method, vw_value_default_method))
            vw_csv_print(stream, "t,r\n", work->kfold->session.scene->views[score->image_id].name, score->value);
    }
}

static enum vw_status write_tables(struct work *work) {
    struct vw_kfold *kfold = work->kfold;
    const char *out = work->params->common.out;
    kfold->scores_path = vw_path_join(out, "scores.csv");
    kfold->matrix_path = vw_path_join(out, "matrix.csv");
    kfold->list_path = vw_path_join(out, "dv_psnr.csv");
    if (!kfold->scores_path || !kfold->matrix_path || !kfold->list_path) return VW_ERROR_MEMORY;
    enum vw_status status = list_images(work);
    if (!status)
        status =
            vw_report_write_csv(kfold->scores_path, kfold->scores, kfold->score_count, work->images, work->image_count);
    if (!status) status = write_matrix(work);
    return status ? status : vw_csv_write_file(kfold->list_path, print_list, work);
}

// ---- All of it ------------------------------------------------------------------------------------------------------

static enum vw_status check(const struct vw_kfold_params *params) {
    if (params->folds < VW_FOLDS_LEAST || params->folds > VW_FOLDS_MOST)
        return vw_fail(VW_ERROR_USAGE, "--kfold %u: takes %d to %d folds", params->folds, VW_FOLDS_LEAST,
                       VW_FOLDS_MOST);
    if (params->common.scene.corrupt)
        return vw_fail(VW_ERROR_USAGE,
                       "--corrupt: corrupts train photos, and every fold trains on others; leave it out "
                       "with --kfold, or use a recipe with defects");
    enum vw_status status = vw_experiment_check(&params->common, params->folds, true);
    return status ? status : vw_run_group_check_out(params->common.out);
}

static enum vw_status check_weights(const struct work *work) {
    if (!work->params->common.scene.val_weights && !vw_scene_has_weights(work->kfold->session.scene)) return VW_OK;
    return vw_fail(VW_ERROR_USAGE,
                   "--kfold: every photo validates in turn, all with weight 1; leave out --val-weights and the weights "
                   "in the file of --splits");
}

static enum vw_status make(struct work *work) {
    const struct vw_experiment_params *params = &work->params->common;
    enum vw_status status = vw_experiment_open_session(params, &work->kfold->session);
    if (!status) status = check_weights(work);
    if (!status)
        status = vw_kfold_divide(work->kfold->session.scene, params->config->seed, work->params->folds, &work->fold_of);
    if (!status) status = plan(work);
    if (!status) status = share_session(work);
    if (!status) status = train(work);
    if (!status) status = score(work);
    return status ? status : write_tables(work);
}

static void free_work(struct work *work) {
    for (uint32_t k = 0; k < VW_FOLDS_MOST; k++) {
        struct fold *fold = &work->folds[k];
        for (uint32_t i = 0; i < LIST_COUNT; i++) free(fold->lists[i]);
        vw_scene_close(&fold->session.scene);
        vw_scoring_unload(&fold->input);
        vw_ledger_close(&fold->ledger);
        free(fold->scores);
    }
    free(work->fold_of);
    free(work->images);
}

enum vw_status vw_kfold_make(const struct vw_kfold_params *params, struct vw_kfold *kfold) {
    *kfold = (struct vw_kfold){.params = params};
    struct work *work = vw_allocate(1, sizeof *work);
    struct vw_out_lock *lock = NULL;
    if (!work) return VW_ERROR_MEMORY;
    work->params = params;
    work->kfold = kfold;
    enum vw_status status = check(params);
    if (!status) status = vw_out_lock_take(params->common.out, &lock);
    if (!status) status = make(work);
    free_work(work);
    free(work);
    const struct vw_report_params report = {.device = params->common.devices.first, .options = params->common.report};
    if (!status) kfold->report_path = vw_report_folder_finish(params->common.out, &report, NULL, NULL);
    vw_out_lock_release(&lock);
    return status;
}

void vw_kfold_free(struct vw_kfold *kfold) {
    free(kfold->scores);
    free(kfold->scores_path);
    free(kfold->matrix_path);
    free(kfold->list_path);
    free(kfold->report_path);
    vw_session_close(&kfold->session);
}
