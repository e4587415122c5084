#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "cli/commands/commands.h"
#include "cli/output/print.h"
#include "cli/output/results.h"
#include "cli/params.h"
#include "cli/program.h"
#include "experiment/verified_selection.h"
#include "ledger/find_image.h"
#include "run/imported/imported_run.h"
#include "run/recorded/scored_run.h"
#include "scene/formats/photo_list.h"
#include "viewworth/log.h"
#include "viewworth/value.h"

struct selection_job {
    const struct vw_options *options;
    bool verify;
    struct vw_selection_params params; // the rule that is asked for, or that of --quick
    struct vw_scored_run run;
    uint32_t train_count; // photos that the run was trained on
    struct vw_selection selection;
    struct vw_verified_selection verified; // where lists are verified; the selection is a part of it
};

// ---- What is asked for ---------------------------------------------------------------------------------------------

static uint32_t seeds_of(const struct vw_options *options) {
    return vw_options_have(options, "seeds") ? options->seeds : VW_VERIFIED_SELECTION_SEEDS;
}

static enum vw_status read_rule(struct selection_job *job) {
    const struct vw_options *options = job->options;
    if ((!options->to || !*options->to) && !options->copy)
        return vw_fail(VW_ERROR_USAGE, "select: --to is missing; name the list to write, or a folder by --copy");
    job->params = (struct vw_selection_params){.method = options->method, .rule = VW_SELECT_OUTLIERS};
    if (options->rule && !vw_selection_read_rule(options->rule, &job->params))
        return vw_fail(VW_ERROR_USAGE, "select: --rule takes one of %s, not \"%s\"", VW_SELECTION_RULES, options->rule);
    job->verify = !options->rule && !options->method && !options->quick;
    if (!job->verify && vw_options_have(options, "seeds"))
        return vw_fail(VW_ERROR_USAGE, "select: --seeds is of trainings, which --rule, --method and --quick leave out");
    if (job->verify && seeds_of(options) < 2)
        return vw_fail(VW_ERROR_USAGE, "select: a verified selection needs two --seeds or more, for an interval");
    return VW_OK;
}

// ---- What is said --------------------------------------------------------------------------------------------------

static const char *name_of(const struct selection_job *job, uint32_t image_id) {
    return vw_ledger_find_image(job->run.images, job->run.image_count, image_id)->name;
}

// Returns the scores that selected the photos, in words.
static const char *methods_of(const struct selection_job *job) {
    if (job->verify) return job->verified.lists.of[job->verified.chosen].method;
    if (job->params.method) return job->params.method;
    return job->selection.method ? job->selection.method : "train_fit, dv_psnr, dv_loss";
}

// Lists the scores of the photos left out, or of the lone views.
static json_t *outliers_to_json(const struct selection_job *job, bool lone) {
    json_t *photos = json_array();
    if (job->verify || job->params.rule != VW_SELECT_OUTLIERS) {
        json_decref(photos);
        return NULL;
    }
    for (uint32_t i = 0; i < job->selection.outlier_count; i++) {
        const struct vw_selection_outlier *outlier = &job->selection.outliers[i];
        if (outlier->lone != lone) continue;
        vw_json_append(&photos, json_pack("{s:s, s:s, s:o}", "name", name_of(job, outlier->image_id), "method",
                                          outlier->method, "z", vw_json_real(outlier->z)));
    }
    return photos;
}

static json_t *to_json(const struct selection_job *job) {
    json_t *names = json_array();
    for (uint32_t i = 0; i < job->selection.count; i++)
        vw_json_append(&names, json_string(name_of(job, job->selection.image_ids[i])));
    return json_pack("{s:s*, s:s*, s:s*, s:s, s:o, s:o*, s:o*, s:o*}", "path", job->options->to, "format",
                     job->options->to ? vw_photo_list_format(job->options->to) : NULL, "copy", job->options->copy,
                     "method", methods_of(job), "selected", names, "left_out", outliers_to_json(job, false),
                     "lone_views", outliers_to_json(job, true), "verified",
                     job->verify ? vw_verified_selection_to_json(&job->verified) : NULL);
}

// Prints the options of the scene that the list does not contain. Prints only known ones: a ledger may come from
// anybody, and a shell reads this.
static void print_scene_options(const struct selection_job *job) {
    json_int_t downscale = json_integer_value(json_object_get(job->run.scene_options, "downscale"));
    vw_print(" --downscale %" JSON_INTEGER_FORMAT, downscale ? downscale : 1); // not to be chosen anew
    static const char *const known[] = {"providers", "val-weights", "masks", "format", "pool", "val", "test"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(known); i++) {
        const json_t *value = json_object_get(job->run.scene_options, known[i]);
        if (value) vw_print(" --%s", known[i]);
        if (value) vw_print_shell_path(json_string_value(value) ? json_string_value(value) : "");
    }
}

static void print_next(const struct selection_job *job) {
    const struct vw_config *config = &job->run.recorded.config;
    if (vw_is_imported(&job->run.recorded.row)) return;
    vw_print("train    viewworth value");
    vw_print_shell_path(job->run.recorded.row.scene_path);
    if (json_is_string(json_object_get(job->run.scene_options, "splits"))) {
        vw_print(" --splits, with a copy of the run's splits.json in which the other photos are \"excluded\"\n");
        return;
    }
    vw_print(" --train");
    vw_print_shell_path(job->options->to);
    print_scene_options(job);
    vw_print(" --field %s", vw_field_name(config->field));
    vw_print(" --out ANOTHER\n");
}

// Prints a line per photo, with every score that leaves it out, or makes it a lone view.
static void print_outliers(const struct selection_job *job) {
    const struct vw_selection_outlier *outliers = job->selection.outliers;
    for (uint32_t i = 0; i < job->selection.outlier_count; i++) {
        bool named = false;
        for (uint32_t j = 0; j < i; j++) named |= outliers[j].image_id == outliers[i].image_id;
        if (named) continue;
        vw_print(outliers[i].lone ? "lone     %s, kept (it fits, but helps no other photo):" : "left out %s:",
                 name_of(job, outliers[i].image_id));
        for (uint32_t j = i; j < job->selection.outlier_count; j++)
            if (outliers[j].image_id == outliers[i].image_id)
                vw_print("%s %s z = %.1f", j > i ? "," : "", outliers[j].method, outliers[j].z);
        vw_print("\n");
    }
}

static void print_kept(const struct selection_job *job) {
    const struct vw_selection *selection = &job->selection;
    vw_print("kept     %u of %u photos to train on", selection->count, job->train_count);
    if (job->verify) {
        vw_print("\n");
        return;
    }
    vw_print(", by %s: %s\n", methods_of(job), job->options->rule ? job->options->rule : "without-outliers");
    print_outliers(job);
    if (job->params.rule != VW_SELECT_OUTLIERS && selection->scored_count < job->train_count)
        vw_print("         %u photos have no such score and were left out\n",
                 job->train_count - selection->scored_count);
}

static void print_unverified(const struct selection_job *job) {
    bool asked = job->options->rule || job->options->method;
    vw_print("nothing was verified: %s\n", asked ? "the rule was taken as asked; viewworth compare tests the list"
                                           : job->options->quick ? "--quick does not retrain"
                                                                 : "an imported run cannot be trained again");
}

static void print_text(const struct selection_job *job) {
    print_kept(job);
    if (!job->verify) print_unverified(job);
    if (job->options->copy) {
        vw_print("copy    ");
        vw_print_shell_path(job->options->copy);
        vw_print(" (images, masks, sparse/0, transforms.json)\n");
    }
    if (!job->options->to) return;
    vw_print("list    ");
    vw_print_shell_path(job->options->to);
    vw_print(" (%s)\n", vw_photo_list_format(job->options->to));
    print_next(job);
}

static enum vw_status verify(struct selection_job *job) {
    struct vw_device_list devices;
    enum vw_status status = vw_device_list_read(job->options, &devices);
    if (status) return status;
    const struct vw_verified_selection_params params = {.run = &job->run,
                                                        .devices = vw_device_list_choose(job->options, &devices),
                                                        .seeds = seeds_of(job->options),
                                                        .together = job->options->together,
                                                        .interrupt = vw_interrupt_watch()};
    status = vw_verified_selection_make(&params, &job->verified);
    if (status) return status;
    job->selection = job->verified.lists.of[job->verified.chosen].selections[VW_HALF_BOTH];
    return VW_OK;
}

// Refuses, before hours of training, and before one of the two is written, what cannot be written.
static enum vw_status check_outputs(const struct selection_job *job) {
    const struct vw_options *options = job->options;
    enum vw_status status = options->to ? vw_selection_list_write(&job->run, NULL, options->to) : VW_OK;
    return !status && options->copy ? vw_selection_copy_check(&job->run, options->copy) : status;
}

static enum vw_status copy(const struct selection_job *job) {
    const struct vw_interrupt interrupt = vw_interrupt_watch();
    return vw_selection_copy(&job->run, &job->selection, job->options->copy, &interrupt);
}

static enum vw_status print(const struct selection_job *job) {
    if (job->params.rule == VW_SELECT_POSITIVE)
        vw_log_warning("--rule positive: late in training the credits of all photos add up to about zero even if every "
                       "photo is good, so that this rule drops a third of a clean scene; without it, trainings verify "
                       "what to drop");
    if (job->options->json) return vw_json_print(to_json(job));
    if (job->verify) vw_verified_selection_print(&job->verified, seeds_of(job->options));
    print_text(job);
    return VW_OK;
}

enum vw_status vw_command_select(const struct vw_options *options) {
    struct selection_job job = {.options = options};
    enum vw_status status = read_rule(&job);
    if (status) return status;
    status = vw_scored_run_open(options->operand, &job.run);
    if (!status) vw_scored_run_warn(&job.run, 0); // no file that the list names was corrupted
    if (!status && vw_is_imported(&job.run.recorded.row)) job.verify = false;
    if (!status) status = check_outputs(&job);
    if (!status) status = job.verify ? verify(&job) : vw_scored_run_select(&job.run, &job.params, &job.selection);
    if (!status && options->copy) status = copy(&job); // the list last: while it is missing, the same command goes on
    if (!status && options->to) status = vw_selection_list_write(&job.run, &job.selection, options->to);
    job.train_count = status ? 0 : vw_scored_run_train_count(&job.run);
    if (!status) status = print(&job);
    if (job.verify) vw_verified_lists_free(&job.verified.lists);
    else vw_selection_free(&job.selection);
    vw_scored_run_close(&job.run);
    return status;
}
