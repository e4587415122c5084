// Changes that verify finds in the folder of a run: forged rows with a chain that fits, tables and fields that were
// edited or exchanged, and the list of checksums. One small run is made, and every case changes a copy of its folder.
#include "support/ledger_chain.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>

#include "base/inside.h"
#include "run/outputs/checksums.h"
#include "run/scoring.h"
#include "run/verify/verify.h"
#include "support/small_run.h"
#include "viewworth/viewworth.h"

struct fixture {
    char *folder;  // holds "whole", "other" and "copy"
    char out[300]; // folder of the copy
};

// ---- Runs ----------------------------------------------------------------------------------------------------------

enum { EPOCHS = 4 };

static void make_paid_run(const char *folder, const char *name, uint64_t seed, bool resume, const char *amount) {
    const struct vw_config config = small_config(seed, EPOCHS);
    const char *out = temporary_path(folder, name);
    const struct vw_run_params params = {
        .scene = {.path = SMALL_SCENE, .providers = temporary_path(folder, "providers.csv")},
        .config = &config,
        .out = out,
        .payout = amount,
        .lasting = {.wanted = true, .no_gate = true, .matrix = true},
        .resume = resume};
    AUTO(vw_run_close) struct vw_run *run = small_run_make(&params);
}

// Plants retrainings on subsets of the photos, by which view_001 is worth much and view_002 little.
static void plant_worth(const char *out, uint64_t seed) {
    enum { PHOTOS = 6, COUNT = 32 };
    static const double given_db[PHOTOS] = {1, 9, 1, 2, 1, 1};
    const struct vw_config config = small_config(seed, EPOCHS);
    struct vw_ledger_retraining *rows = vw_allocate(COUNT, sizeof *rows + PHOTOS * sizeof(uint32_t));
    uint32_t *ids = (uint32_t *)(rows + COUNT);
    struct vw_scoring scoring;
    for (uint32_t i = 0; i < COUNT; i++, ids += PHOTOS) {
        double sum = 0;
        rows[i] = (struct vw_ledger_retraining){.seed = 1 + i, .epochs = EPOCHS, .image_ids = ids};
        for (uint32_t photo = 0; photo < PHOTOS; photo++) {
            if (i % 8 && photo == i % PHOTOS) continue;
            if (i % 8 && i % 3 && photo == (i / 2 + 3) % PHOTOS) continue;
            ids[rows[i].image_count++] = photo;
            sum += given_db[photo];
        }
        rows[i].val_psnr = 20 + sum / rows[i].image_count;
    }
    AUTO(vw_ledger_close) struct vw_ledger *ledger = test_ledger_open_to_append(temporary_path(out, "ledger.db"));
    ASSERT_OK(vw_scoring_make(ledger, &config, &scoring));
    ASSERT_OK(vw_scoring_set_retrainings(&scoring, rows, COUNT));
    ASSERT_OK(vw_ledger_add_retrainings(ledger, rows, COUNT, scoring.scores, scoring.score_count));
    vw_scoring_free(&scoring);
}

static void make_run(const char *folder, const char *name, uint64_t seed) {
    make_paid_run(folder, name, seed, false, NULL);
    plant_worth(temporary_path(folder, name), seed);
    make_paid_run(folder, name, seed, true, "100");
}

static int set_up(void **state) {
    struct fixture *fixture = vw_allocate(1, sizeof *fixture);
    fixture->folder = temporary_folder_create();
    snprintf(fixture->out, sizeof fixture->out, "%s/copy", fixture->folder);
    temporary_file(fixture->folder, "providers.csv", "name,provider\nview_001,anna\nview_002,1000\nview_003,anna\n");
    make_run(fixture->folder, "whole", 1);
    make_run(fixture->folder, "other", 2);
    *state = fixture;
    return 0;
}

static int tear_down(void **state) {
    AUTO_FREE struct fixture *fixture = *state;
    temporary_folder_remove(fixture->folder);
    return 0;
}

static void copy_file(const char *from_folder, const char *to_folder, const char *name) {
    size_t size_bytes = 0;
    AUTO_FREE void *data = temporary_read(temporary_path(from_folder, name), &size_bytes);
    ASSERT_OK(vw_file_write(temporary_path(to_folder, name), data, size_bytes));
}

static const char *const result_names[] = {"ledger.db",   "scores.csv",        "matrix.csv",     "providers.csv",
                                           "payout.csv",  "report.html",       "field.vwf",      "duplicates.csv",
                                           "map.json",    "payout_photos.csv", "residuals.json", "reconstruction.json",
                                           "splits.json", "advice.csv"};

// Returns a fresh copy of the run.
static struct fixture *renew(void **state) {
    struct fixture *fixture = *state;
    ASSERT_OK(vw_folder_create(fixture->out));
    for (size_t i = 0; i < VW_ARRAY_COUNT(result_names); i++)
        copy_file(temporary_path(fixture->folder, "whole"), fixture->out, result_names[i]);
    copy_file(temporary_path(fixture->folder, "whole"), fixture->out, VW_CHECKSUMS_FILE);
    return fixture;
}

static const char *in_copy(const struct fixture *fixture, const char *name) {
    return temporary_path(fixture->out, name);
}

static enum vw_status verify(const struct fixture *fixture) {
    AUTO(vw_verification_free) struct vw_verification verification = {0};
    return vw_run_verify(&(struct vw_verify_params){.out = fixture->out}, &verification);
}

// Lets changes pass that only the list tells.
static void unlist(const struct fixture *fixture) { unlink(in_copy(fixture, VW_CHECKSUMS_FILE)); }

// Lists what is in the folder, as a forger would.
static void list_again(const struct fixture *fixture) {
    AUTO(vw_ledger_close) struct vw_ledger *ledger = test_ledger_open(in_copy(fixture, "ledger.db"));
    ASSERT_OK(vw_checksums_write(fixture->out, ledger));
}

static void assert_refused(enum vw_status status, const char *what, const char *word) {
    if (status != VW_ERROR_MISMATCH) fail_msg("%s: gave %d", what, (int)status);
    if (!strstr(vw_error_message(), word)) fail_msg("%s: the message lacks \"%s\": %s", what, word, vw_error_message());
}

// ---- The table -----------------------------------------------------------------------------------------------------

static const char *result_of(const struct vw_verification *verification, const char *name) {
    for (uint32_t i = 0; i < verification->item_count; i++)
        if (strcmp(verification->items[i].name, name) == 0) return verification->items[i].result;
    return "(missing)";
}

TEST(the_table_says_what_was_checked) {
    static const struct {
        const char *name, *unlisted, *listed;
    } rows[] = {{"score rows", "intact", "intact"},
                {"order of methods", "intact", "intact"},
                {"scene, shaders, device", "claimed", "claimed"},
                {"scores.csv", "intact", "intact"},
                {"matrix.csv", "intact", "intact"},
                {"providers.csv", "intact", "intact"},
                {"payout.csv", "intact", "intact"},
                {"payout_photos.csv", "intact", "intact"},
                {"duplicates.csv", "not checked", "intact"},
                {"advice.csv", "not checked", "intact"},
                {"report.html", "not checked", "intact"},
                {"field.vwf", "intact", "intact"},
                {"chain as a whole", "not checked", "not checked"},
                {VW_CHECKSUMS_FILE, "absent", "intact"}};
    const struct fixture *fixture = renew(state);
    for (int listed = 1; listed >= 0; listed--) {
        struct vw_verification verification = {0};
        ASSERT_OK(vw_run_verify(&(struct vw_verify_params){.out = fixture->out}, &verification));
        for (size_t i = 0; i < VW_ARRAY_COUNT(rows); i++)
            assert_string_equal(result_of(&verification, rows[i].name), listed ? rows[i].listed : rows[i].unlisted);
        vw_verification_free(&verification);
        unlist(fixture);
    }
}

// ---- Forged rows, sealed anew --------------------------------------------------------------------------------------

// The scores must be those of the steps, whatever status a forger claims.
TEST(forged_rows_with_a_chain_that_fits_are_found) {
#define WITHOUT_LASTING                                                                                                \
    "DELETE FROM retraining; DELETE FROM lasting_view; DELETE FROM lasting_check; DELETE FROM lasting_step;"           \
    "DELETE FROM lasting; DELETE FROM payout_request;"
    static const struct {
        const char *what, *sql, *word;
    } cases[] = {
        {"another order of methods", "UPDATE score SET rowid = -rowid", "or its place"},
        {"one photo less to train on",
         "DELETE FROM retraining; UPDATE image SET split = 'excluded' WHERE image_id = (SELECT max(image_id) "
         "FROM image WHERE split = 'train')",
         "scores where its steps give"},
        {"another field", "UPDATE run SET field_sha256 = run_id", "field.vwf: is not the field"},
        {"no field", "UPDATE run SET field_sha256 = NULL", "no hash of its field"},
        {"another score", "UPDATE score SET value = value + 0.5 WHERE rowid = 1", "or its place"},
        {"another provider", "UPDATE image SET provider = 'carl' WHERE provider = 'anna'", "scores.csv: is not what"},
        {"scores of a running run", "UPDATE score SET value = value + 1; UPDATE run SET status = 'running'",
         "or its place"},
        {"no scores of an interrupted run", WITHOUT_LASTING "DELETE FROM score; UPDATE run SET status = 'interrupted'",
         "holds 0 scores where its steps"},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        const struct fixture *fixture = renew(state);
        sql_change(in_copy(fixture, "ledger.db"), cases[i].sql);
        chain_rewrite(in_copy(fixture, "ledger.db"));
        assert_refused(verify(fixture), cases[i].what, cases[i].word);
    }
}

// Makes a copy whose steps alone remain, with the scores that they give.
static void keep_steps(const struct fixture *fixture, const char *sql) {
    AUTO(vw_ledger_close) struct vw_ledger *ledger = NULL;
    const struct vw_config config = small_config(1, 4);
    const char *path = in_copy(fixture, "ledger.db");
    struct vw_scoring scoring;
    for (size_t f = 1; f < VW_ARRAY_COUNT(result_names); f++) unlink(in_copy(fixture, result_names[f]));
    unlist(fixture);
    sql_change(path, WITHOUT_LASTING "DELETE FROM score");
    chain_rewrite(path);
    ASSERT_OK(vw_ledger_open_to_append(path, &ledger));
    ASSERT_OK(vw_scoring_make(ledger, &config, &scoring));
    ASSERT_OK(vw_ledger_finish(ledger, "interrupted", "2026-11-21T04:00:00Z", scoring.scores, scoring.score_count));
    vw_scoring_free(&scoring);
    sql_change(path, sql);
    chain_rewrite(path);
}

TEST(an_interrupted_run_has_neither_a_list_nor_a_field_of_its_own) {
    const struct fixture *fixture = renew(state);
    keep_steps(fixture, "UPDATE run SET field_sha256 = NULL");
    ASSERT_OK(verify(fixture));
    list_again(fixture);
    assert_refused(verify(fixture), "a list", "lists the results of a run that is interrupted");
    unlist(fixture);
    copy_file(temporary_path(fixture->folder, "other"), fixture->out, "field.vwf");
    assert_refused(verify(fixture), "a field", "field.vwf: is not the field");
}

// Only the scene tells what its photos are.
TEST(a_replay_looks_at_the_photos) {
    const struct fixture *fixture = renew(state);
    struct vw_verification verification = {0};
    const struct vw_verify_params params = {.out = fixture->out, .replay_steps = 3};
    ASSERT_OK(vw_run_verify(&params, &verification));
    assert_int_equal(verification.replayed_steps, 3);
    vw_verification_free(&verification);
    sql_change(in_copy(fixture, "ledger.db"), "UPDATE image SET sha256 = scene_hash WHERE image_id = 3");
    chain_rewrite(in_copy(fixture, "ledger.db"));
    unlist(fixture);
    ASSERT_OK(verify(fixture));
    assert_refused(vw_run_verify(&params, &verification), "another photo", "image rows are not the photos");
}

// Edits a text that nothing follows from, which only the head can tell.
TEST(a_chain_rewritten_whole_has_another_head) {
    const struct fixture *fixture = renew(state);
    AUTO_FREE char *head = sql_ask(in_copy(fixture, "ledger.db"), SQL_FINAL_HASH);
    sql_change(in_copy(fixture, "ledger.db"), "UPDATE run SET started_utc = '2020-01-01T00:00:00Z'");
    chain_rewrite(in_copy(fixture, "ledger.db"));
    assert_refused(verify(fixture), "the list", "of another state of the run");
    unlist(fixture);
    ASSERT_OK(verify(fixture));
    struct vw_verification verification = {0};
    assert_refused(vw_run_verify(&(struct vw_verify_params){.out = fixture->out, .expect = head}, &verification),
                   "--expect", "not the one that --expect gives");
}

// ---- Files ---------------------------------------------------------------------------------------------------------

// Replaces the first `old` in a file by a text of the same length.
static void edit(const struct fixture *fixture, const char *name, const char *old, const char *new) {
    size_t size_bytes = 0;
    AUTO_FREE void *data = temporary_read(in_copy(fixture, name), &size_bytes);
    char *place = memmem(data, size_bytes, old, strlen(old));
    assert_non_null(place);
    assert_int_equal(strlen(old), strlen(new));
    memcpy(place, new, strlen(new));
    ASSERT_OK(vw_file_write(in_copy(fixture, name), data, size_bytes));
}

// Replaces the first `old` in a text by one of any length.
static void replace(const struct fixture *fixture, const char *name, const char *old, const char *new) {
    AUTO_FREE void *data = temporary_read(in_copy(fixture, name), NULL);
    char *text = data, *place = strstr(text, old);
    assert_non_null(place);
    AUTO_FREE char *changed = vw_format_text("%.*s%s%s", (int)(place - text), text, new, place + strlen(old));
    ASSERT_OK(vw_file_write(in_copy(fixture, name), changed, strlen(changed)));
}

static void append(const struct fixture *fixture, const char *name, const char *text) {
    FILE *file = fopen(in_copy(fixture, name), "a");
    assert_non_null(file);
    fputs(text, file);
    assert_int_equal(fclose(file), 0);
}

TEST(edited_tables_are_found) {
    static const char *const tables[] = {"scores.csv", "matrix.csv", "providers.csv", "payout.csv",
                                         "payout_photos.csv"};
    static const struct {
        const char *name, *old, *new;
    } edits[] = {{"scores.csv", ",anna,", ",otto,"},   {"scores.csv", "view_001", "view_002"},
                 {"scores.csv", ",dB,", ",dC,"},       {"matrix.csv", "view_001", "view_002"},
                 {"matrix.csv", "dv_psnr", "dv_loss"}, {"providers.csv", "anna", "otto"},
                 {"payout.csv", "anna", "otto"},       {"payout_photos.csv", "view_001", "view_002"},
                 {"payout.csv", "\n1000,", "\n1e03,"}, {"matrix.csv", "lasting_psnr", "lasting_loss"}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(edits); i++) {
        const struct fixture *fixture = renew(state);
        edit(fixture, edits[i].name, edits[i].old, edits[i].new);
        assert_refused(verify(fixture), edits[i].old, edits[i].name);
    }
    for (size_t i = 0; i < VW_ARRAY_COUNT(tables); i++) {
        const struct fixture *fixture = renew(state);
        append(fixture, tables[i], "x");
        assert_refused(verify(fixture), "a letter more", tables[i]);
        renew(state);
        ASSERT_OK(vw_file_write(in_copy(fixture, tables[i]), "", 0));
        assert_refused(verify(fixture), "an empty file", tables[i]);
        unlink(in_copy(fixture, tables[i]));
        assert_refused(verify(fixture), "a listed file is missing", tables[i]);
        unlist(fixture);
        ASSERT_OK(verify(fixture)); // the table tells that it is absent
    }
}

TEST(a_field_of_another_run_is_found) {
    const struct fixture *fixture = renew(state);
    copy_file(temporary_path(fixture->folder, "other"), fixture->out, "field.vwf");
    assert_refused(verify(fixture), "the field of another run", "field.vwf: is not the field");
    unlink(in_copy(fixture, "field.vwf"));
    assert_refused(verify(fixture), "no field", "field.vwf: is missing");
    unlist(fixture);
    ASSERT_OK(verify(fixture));
}

TEST(links_are_not_followed) {
    static const char *const names[] = {"scores.csv", "field.vwf", VW_CHECKSUMS_FILE};
    for (size_t i = 0; i < VW_ARRAY_COUNT(names); i++) {
        const struct fixture *fixture = renew(state);
        const char *target = temporary_path(temporary_path(fixture->folder, "whole"), names[i]);
        unlink(in_copy(fixture, names[i]));
        assert_int_equal(symlink(target, in_copy(fixture, names[i])), 0);
        enum vw_status status = verify(fixture);
        if (!status) fail_msg("a link %s was followed", names[i]);
        unlink(in_copy(fixture, names[i]));
    }
}

// ---- SHA256SUMS ----------------------------------------------------------------------------------------------------

// Edits that sha256sum would pass over, or take for another file.
TEST(the_list_is_read_strictly) {
    static const struct {
        const char *what, *old, *new;
    } cases[] = {
        {"another comment", "# viewworth", "# another\n# viewworth"},
        {"no comment", "# viewworth chain head ", ""},
        {"a line less", "\n", ""},
        {"an empty line", "scores.csv\n", "scores.csv\n\n"},
        {"a file of another name", "scores.csv", "../scores.csv"},
        {"a file twice", "scores.csv\n", "report.html\n"},
        {"a binary mark", "  scores.csv", " *scores.csv"},
        {"no end of line", "scores.csv\n", "scores.csv"},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        const struct fixture *fixture = renew(state);
        replace(fixture, VW_CHECKSUMS_FILE, cases[i].old, cases[i].new);
        assert_refused(verify(fixture), cases[i].what, VW_CHECKSUMS_FILE ": was edited");
    }
}

TEST(a_flipped_bit_of_the_list_is_found) {
    const struct fixture *fixture = renew(state);
    struct vw_checksums_found found;
    size_t size_bytes = 0;
    AUTO(vw_ledger_close) struct vw_ledger *ledger = test_ledger_open(in_copy(fixture, "ledger.db"));
    ASSERT_OK(vw_checksums_check(fixture->out, ledger, NULL, &found));
    vw_checksums_found_free(&found);
    AUTO_FREE void *data = temporary_read(in_copy(fixture, VW_CHECKSUMS_FILE), &size_bytes);
    int descriptor = open(in_copy(fixture, VW_CHECKSUMS_FILE), O_WRONLY | O_CLOEXEC);
    for (size_t bit = 0; bit < 8 * size_bytes; bit += 9) { // another bit of each byte
        uint8_t byte = ((uint8_t *)data)[bit / 8], flipped = (uint8_t)(byte ^ 1u << bit % 8);
        assert_int_equal(pwrite(descriptor, &flipped, 1, (off_t)(bit / 8)), 1);
        if (!vw_checksums_check(fixture->out, ledger, NULL, &found))
            fail_msg("bit %zu of byte %zu (%c): the list holds", bit % 8, bit / 8, byte);
        vw_checksums_found_free(&found);
        assert_int_equal(pwrite(descriptor, &byte, 1, (off_t)(bit / 8)), 1);
    }
    close(descriptor);
}

// A payout is of what the last command was asked with.
TEST(a_payout_that_nobody_asked_for_is_found) {
    static const char *const amounts[] = {NULL, "99"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(amounts); i++) {
        const struct fixture *fixture = renew(state);
        make_paid_run(fixture->folder, "copy", 1, true, amounts[i]);
        assert_int_equal(vw_file_exists(in_copy(fixture, "payout.csv")), amounts[i] != NULL);
        ASSERT_OK(verify(fixture));
        copy_file(temporary_path(fixture->folder, "whole"), fixture->out, "payout.csv");
        copy_file(temporary_path(fixture->folder, "whole"), fixture->out, "payout_photos.csv");
        list_again(fixture);
        assert_refused(verify(fixture), "another amount", "payout.csv: is not what the ledger");
    }
}

TEST_GROUP(set_up, tear_down)
