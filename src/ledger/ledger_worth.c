#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "ledger/find_image.h"
#include "ledger/ledger_private.h"

// ---- Writing -------------------------------------------------------------------------------------------------------

struct adding {
    const struct vw_ledger_retraining *retrainings;
    uint32_t count;
};

static enum vw_status insert(struct vw_ledger *ledger, void *context) {
    const struct adding *adding = context;
    struct vw_insertion insertion;
    int64_t first = 0;
    enum vw_status status = vw_insertion_begin(&ledger->database, &vw_retraining_table, ledger->run.run_id, &insertion);
    if (!status) status = vw_database_read_number(&ledger->database, "SELECT count(*) FROM retraining", &first);
    for (uint32_t i = 0; !status && i < adding->count; i++) {
        const struct vw_ledger_retraining *retraining = &adding->retrainings[i];
        char *ids = vw_table_list_ids(retraining->image_ids, retraining->image_count);
        const struct vw_retraining_row row = {.retraining = (uint64_t)first + i,
                                              .seed = retraining->seed,
                                              .epochs = retraining->epochs,
                                              .image_ids = ids,
                                              .val_psnr = retraining->val_psnr};
        status = ids ? vw_insertion_add(&insertion, &row) : VW_ERROR_MEMORY;
        free(ids);
    }
    vw_insertion_end(&insertion);
    return status;
}

enum vw_status vw_ledger_add_retrainings(struct vw_ledger *ledger, const struct vw_ledger_retraining *retrainings,
                                         uint32_t count, const struct vw_ledger_score *scores, uint32_t score_count) {
    struct vw_ledger_state state = vw_ledger_state_with(ledger, scores, score_count);
    struct adding adding = {retrainings, count};
    if (!vw_ledger_has_finished(ledger))
        return vw_fail(VW_ERROR_USAGE, "%s: the run is not finished; finish it by --resume first",
                       ledger->database.path);
    return vw_ledger_change(ledger, &state, insert, &adding);
}

// ---- Reading: the rows may come from elsewhere ---------------------------------------------------------------------

static bool is_trained(const struct vw_ledger *ledger, uint64_t id) {
    const struct vw_ledger_image *image =
        id <= UINT32_MAX ? vw_ledger_find_image(ledger->images, ledger->image_count, (uint32_t)id) : NULL;
    return image && strcmp(image->split, "train") == 0;
}

static size_t count_words(const char *text) {
    size_t count = *text != 0;
    for (; *text; text++) count += *text == ' ';
    return count;
}

// Reads ids of train photos. They must ascend, with single spaces between them and nothing more. Returns their number;
// 0 if the list is invalid.
static uint32_t read_ids(const struct vw_ledger *ledger, const char *text, uint32_t *ids) {
    uint32_t count = 0;
    while (*text) {
        uint64_t id = 0;
        const char *digit = text;
        for (; *digit >= '0' && *digit <= '9' && id <= UINT32_MAX; digit++) id = id * 10 + (uint64_t)(*digit - '0');
        bool canonical =
            digit > text && (*text != '0' || digit == text + 1) && (!*digit || (*digit == ' ' && digit[1]));
        if (!canonical || (count && id <= ids[count - 1]) || !is_trained(ledger, id)) return 0;
        ids[count++] = (uint32_t)id;
        text = *digit ? digit + 1 : digit;
    }
    return count;
}

// Makes one block of all retrainings, followed by their ids.
static enum vw_status take_rows(const struct vw_ledger *ledger, const struct vw_retraining_row *rows, uint64_t count,
                                struct vw_ledger_retraining **retrainings) {
    size_t id_count = 0;
    for (uint64_t i = 0; i < count; i++) id_count += count_words(rows[i].image_ids);
    struct vw_ledger_retraining *taken = vw_allocate(count * sizeof *taken + id_count * sizeof(uint32_t), 1);
    if (!taken) return VW_ERROR_MEMORY;
    uint32_t *ids = (uint32_t *)(taken + count);
    for (uint64_t i = 0; i < count; i++) {
        taken[i] = (struct vw_ledger_retraining){.seed = rows[i].seed,
                                                 .epochs = rows[i].epochs,
                                                 .image_ids = ids,
                                                 .image_count = read_ids(ledger, rows[i].image_ids, ids),
                                                 .val_psnr = rows[i].val_psnr};
        ids += taken[i].image_count;
        if (rows[i].retraining == i && taken[i].image_count) continue;
        free(taken);
        return vw_fail(VW_ERROR_INPUT,
                       "%s: damaged: row %" PRIu64 " of table retraining has an invalid number or list of photos; "
                       "restore the file from a copy",
                       ledger->database.path, i);
    }
    *retrainings = taken;
    return VW_OK;
}

enum vw_status vw_ledger_get_retrainings(struct vw_ledger *ledger, struct vw_ledger_retraining **retrainings,
                                         uint32_t *count) {
    struct vw_retraining_row *rows = NULL;
    uint64_t row_count = 0;
    enum vw_status status = vw_ledger_load_images(ledger);
    if (!status) status = vw_ledger_read_table(ledger, &vw_retraining_table, NULL, NULL, (void **)&rows, &row_count);
    if (!status) status = take_rows(ledger, rows, row_count, retrainings);
    if (!status) *count = (uint32_t)row_count;
    free(rows);
    return status;
}

// ---- The payout request --------------------------------------------------------------------------------------------

struct requesting {
    const struct vw_payout_request *request;
    char final_hash[VW_HASH_HEX_BYTES]; // filled
};

static enum vw_status replace_request(struct vw_ledger *ledger, void *context) {
    struct requesting *requesting = context;
    struct vw_database *database = &ledger->database;
    enum vw_status status = vw_database_run(database, "DELETE FROM payout_request");
    if (!status)
        status = vw_table_insert(database, &vw_payout_request_table, ledger->run.run_id, requesting->request,
                                 requesting->request->cents > 0, NULL);
    return status ? status
                  : vw_ledger_write_final_hash(database, ledger->run_hash, ledger->head, requesting->final_hash);
}

enum vw_status vw_ledger_set_payout_request(struct vw_ledger *ledger, const struct vw_payout_request *request) {
    struct requesting requesting = {.request = request};
    enum vw_status status = vw_ledger_change(ledger, NULL, replace_request, &requesting);
    if (!status) memcpy(ledger->final_hash, requesting.final_hash, sizeof ledger->final_hash);
    return status;
}

enum vw_status vw_ledger_get_payout_request(struct vw_ledger *ledger, struct vw_payout_request *request) {
    struct vw_payout_request *rows = NULL;
    uint64_t count = 0;
    enum vw_status status = vw_ledger_read_table(ledger, &vw_payout_request_table, NULL, NULL, (void **)&rows, &count);
    if (!status) *request = count ? *rows : (struct vw_payout_request){0};
    free(rows);
    return status;
}
