// What verify finds in the folder of a run: forged rows with a chain that fits, tables and fields that were edited or
// exchanged, and signatures. One small run is made, and every case changes a copy of its folder.
#include "support/ledger_chain.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>

#include "base/inside.h"
#include "base/signing.h"
#include "run/sign.h"
#include "run/verify/verify.h"
#include "support/small_run.h"
#include "support/temporary_folder.h"
#include "viewworth/viewworth.h"

struct fixture {
    char *folder;                             // holds "whole", "other", "copy", "key" and "key.pub"
    char out[300], key[300], public_key[300]; // of the copy, and the key files
};

// ---- Runs ----------------------------------------------------------------------------------------------------------

static void make_run(const char *folder, const char *name, uint64_t seed, bool resume, uint32_t epochs,
                     const char *key) {
    const struct vw_config config = small_config(seed, epochs);
    char out[300];
    snprintf(out, sizeof out, "%s/%s", folder, name);
    const struct vw_run_params params = {
        .scene = {.path = SMALL_SCENE, .providers = temporary_path(folder, "providers.csv")},
        .config = &config,
        .out = out,
        .payout = "100",
        .lasting = {.wanted = true, .no_gate = true, .matrix = true},
        .sign_key_path = key,
        .resume = resume};
    struct vw_run *run = NULL;
    ASSERT_OK(vw_run_open(&params, &run));
    ASSERT_OK(vw_run_advance(run, UINT64_MAX));
    ASSERT_OK(vw_run_finish(run));
    vw_run_close(&run);
}

static int set_up(void **state) {
    struct fixture *fixture = vw_allocate(1, sizeof *fixture);
    char text[VW_PUBLIC_KEY_TEXT_BYTES];
    fixture->folder = temporary_folder_create();
    snprintf(fixture->out, sizeof fixture->out, "%s/copy", fixture->folder);
    snprintf(fixture->key, sizeof fixture->key, "%s/key", fixture->folder);
    snprintf(fixture->public_key, sizeof fixture->public_key, "%s/key.pub", fixture->folder);
    ASSERT_OK(vw_keys_make(fixture->key, text));
    temporary_file(fixture->folder, "providers.csv", "name,provider\nview_001,anna\nview_002,bob\nview_003,anna\n");
    make_run(fixture->folder, "whole", 1, false, 4, fixture->key);
    make_run(fixture->folder, "other", 2, false, 4, NULL);
    *state = fixture;
    return 0;
}

static int tear_down(void **state) {
    struct fixture *fixture = *state;
    temporary_folder_remove(fixture->folder);
    free(fixture);
    return 0;
}

static void copy_file(const char *from_folder, const char *to_folder, const char *name) {
    char from[600], to[600];
    void *data = NULL;
    size_t size_bytes = 0;
    snprintf(from, sizeof from, "%s/%s", from_folder, name);
    snprintf(to, sizeof to, "%s/%s", to_folder, name);
    ASSERT_OK(vw_file_read(from, (size_t)1 << 30, &data, &size_bytes));
    ASSERT_OK(vw_file_write(to, data, size_bytes));
    free(data);
}

// A fresh copy of the run.
static struct fixture *renew(void **state) {
    static const char *const names[] = {"ledger.db",         "scores.csv",     "matrix.csv", "providers.csv",
                                        "payout.csv",        "report.html",    "field.vwf",  "duplicates.csv",
                                        "payout_photos.csv", VW_SIGNATURE_FILE};
    struct fixture *fixture = *state;
    ASSERT_OK(vw_folder_create(fixture->out));
    for (size_t i = 0; i < VW_ARRAY_COUNT(names); i++)
        copy_file(temporary_path(fixture->folder, "whole"), fixture->out, names[i]);
    return fixture;
}

static const char *in_copy(const struct fixture *fixture, const char *name) {
    return temporary_path(fixture->out, name);
}

static enum vw_status verify(const struct fixture *fixture, const char *key) {
    struct vw_verification verification = {0};
    enum vw_status status = vw_run_verify(&(struct vw_verify_params){.out = fixture->out, .key = key}, &verification);
    vw_verification_free(&verification);
    return status;
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
        const char *name, *plain, *with_key;
    } rows[] = {{"score rows", "intact", "intact"},
                {"order of methods", "intact", "intact"},
                {"identity", "intact", "intact"},
                {"scene, shaders, device", "claimed", "claimed"},
                {"scores.csv", "intact", "intact"},
                {"matrix.csv", "intact", "intact"},
                {"providers.csv", "intact", "intact"},
                {"payout.csv", "intact", "intact"},
                {"payout_photos.csv", "intact", "intact"},
                {"duplicates.csv", "not checked", "intact"},
                {"report.html", "not checked", "intact"},
                {"field.vwf", "intact", "intact"},
                {"chain as a whole", "not checked", "intact"},
                {"signature", "not checked", "intact"}};
    const struct fixture *fixture = renew(state);
    for (int keyed = 0; keyed < 2; keyed++) {
        struct vw_verification verification = {0};
        ASSERT_OK(vw_run_verify(
            &(struct vw_verify_params){.out = fixture->out, .key = keyed ? fixture->public_key : NULL}, &verification));
        for (size_t i = 0; i < VW_ARRAY_COUNT(rows); i++)
            assert_string_equal(result_of(&verification, rows[i].name), keyed ? rows[i].with_key : rows[i].plain);
        assert_int_equal(verification.is_signed, keyed);
        vw_verification_free(&verification);
    }
}

// ---- Forged rows, sealed anew --------------------------------------------------------------------------------------

TEST(forged_rows_with_a_chain_that_fits_are_found) {
#define RENAME(table) "UPDATE " table " SET run_id = (SELECT run_id FROM run);"
#define RENAME_ALL                                                                                                     \
    RENAME("step")                                                                                                     \
    RENAME("view")                                                                                                     \
    RENAME("score") RENAME("lasting") RENAME("lasting_step") RENAME("lasting_photo") RENAME("lasting_view")
    static const struct {
        const char *what, *sql, *word;
    } cases[] = {
        {"another order of methods", "UPDATE score SET rowid = -rowid", "or its place"},
        {"another run_id", "UPDATE run SET run_id = replace(run_id, '0', '1');" RENAME_ALL, "run_id is not that of"},
        {"another scene",
         "UPDATE run SET scene_hash = replace(scene_hash, '0', '1'); UPDATE image SET scene_hash = "
         "(SELECT scene_hash FROM run)",
         "run_id is not that of"},
        {"a hash that is none", "UPDATE run SET shader_hash = upper(shader_hash)", "is no hash"},
        {"other shaders", "UPDATE run SET shader_hash = replace(shader_hash, '0', '1')", "run_id is not that of"},
        {"another device", "UPDATE run SET device = 'another'", "run_id is not that of"},
        {"another driver", "UPDATE run SET driver = 'another'", "run_id is not that of"},
        {"another version", "UPDATE run SET version = '0.0.9'", "run_id is not that of"},
        {"another config", "UPDATE run SET config_json = replace(config_json, '\"rays\":32', '\"rays\":64')",
         "run_id is not that of"},
        {"another seed", "UPDATE run SET seed = 5", "seed is not that of its config"},
        {"another seed, in the config, too",
         "UPDATE run SET seed = 5, config_json = replace(config_json, '\"seed\":1', '\"seed\":5')",
         "run_id is not that of"},
        {"other effects", "UPDATE run SET effects_json = replace(effects_json, '\"on\":false', '\"on\":true')",
         "has no box of four numbers"},
        {"a photo of another name",
         "UPDATE image SET name = 'view_999' WHERE split = 'train' AND image_id = "
         "(SELECT max(image_id) FROM image WHERE split = 'train')",
         "subset_hash is not that"},
        {"one photo less to train on",
         "UPDATE image SET split = 'excluded' WHERE image_id = (SELECT max(image_id) "
         "FROM image WHERE split = 'train')",
         "scores where its steps give"},
        {"another field", "UPDATE run SET field_sha256 = run_id", "field.vwf: is not the field"},
        {"no field", "UPDATE run SET field_sha256 = NULL", "no hash of its field"},
        {"another score", "UPDATE score SET value = value + 0.5 WHERE rowid = 1", "or its place"},
        {"another provider", "UPDATE image SET provider = 'carl' WHERE provider = 'anna'", "scores.csv: is not what"},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        const struct fixture *fixture = renew(state);
        sql_change(in_copy(fixture, "ledger.db"), cases[i].sql);
        chain_rewrite(in_copy(fixture, "ledger.db"));
        assert_refused(verify(fixture, NULL), cases[i].what, cases[i].word);
    }
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
    ASSERT_OK(verify(fixture, NULL));
    assert_refused(vw_run_verify(&params, &verification), "another photo", "image rows are not the photos");
}

// What no check without a key finds: a text that nothing follows from.
TEST(a_chain_rewritten_whole_needs_the_head_or_a_key) {
    const struct fixture *fixture = renew(state);
    char *head = sql_ask(in_copy(fixture, "ledger.db"), SQL_FINAL_HASH);
    sql_change(in_copy(fixture, "ledger.db"), "UPDATE run SET started_utc = '2020-01-01T00:00:00Z'");
    chain_rewrite(in_copy(fixture, "ledger.db"));
    ASSERT_OK(verify(fixture, NULL));
    struct vw_verification verification = {0};
    assert_refused(vw_run_verify(&(struct vw_verify_params){.out = fixture->out, .expect = head}, &verification),
                   "--expect", "not the one that --expect gives");
    assert_refused(verify(fixture, fixture->public_key), "--key", "of another state of the run");
    free(head);
}

// ---- Files ---------------------------------------------------------------------------------------------------------

// Replaces the first `old` in a file by a text of the same length.
static void edit(const struct fixture *fixture, const char *name, const char *old, const char *new) {
    void *data = NULL;
    size_t size_bytes = 0;
    ASSERT_OK(vw_file_read(in_copy(fixture, name), (size_t)1 << 30, &data, &size_bytes));
    char *place = memmem(data, size_bytes, old, strlen(old));
    assert_non_null(place);
    assert_int_equal(strlen(old), strlen(new));
    memcpy(place, new, strlen(new));
    ASSERT_OK(vw_file_write(in_copy(fixture, name), data, size_bytes));
    free(data);
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
    } edits[] = {{"scores.csv", ",anna,", ",otto,"},
                 {"scores.csv", "view_001", "view_002"},
                 {"scores.csv", ",dB,", ",dC,"},
                 {"matrix.csv", "view_001", "view_002"},
                 {"matrix.csv", "dv_psnr", "dv_loss"},
                 {"providers.csv", "anna", "otto"},
                 {"payout.csv", "anna", "otto"},
                 {"payout_photos.csv", "view_001", "view_002"},
                 {"matrix.csv", "lasting_psnr", "lasting_loss"}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(edits); i++) {
        const struct fixture *fixture = renew(state);
        edit(fixture, edits[i].name, edits[i].old, edits[i].new);
        assert_refused(verify(fixture, NULL), edits[i].old, edits[i].name);
    }
    for (size_t i = 0; i < VW_ARRAY_COUNT(tables); i++) {
        const struct fixture *fixture = renew(state);
        append(fixture, tables[i], "x");
        assert_refused(verify(fixture, NULL), "a letter more", tables[i]);
        renew(state);
        ASSERT_OK(vw_file_write(in_copy(fixture, tables[i]), "", 0));
        assert_refused(verify(fixture, NULL), "an empty file", tables[i]);
        unlink(in_copy(fixture, tables[i]));
        ASSERT_OK(verify(fixture, NULL)); // which is told
        assert_refused(verify(fixture, fixture->public_key), "a signed file is missing", tables[i]);
    }
}

// The second field from the end of a line of a table, changed by `factor`.
static void scale_number(const struct fixture *fixture, const char *name, double factor) {
    void *data = NULL;
    size_t size_bytes = 0;
    ASSERT_OK(vw_file_read(in_copy(fixture, name), 1 << 20, &data, &size_bytes));
    char *text = data, *field = strstr(text, "\nview_");
    for (int commas = 0; commas < 6; field++) commas += *field == ',';
    char *end = NULL, *changed = NULL;
    double number = strtod(field, &end);
    changed = vw_format_text("%.*s%.17g%s", (int)(field - text), text, number * factor, end);
    assert_true(number != 0 && strcmp(changed, text) != 0);
    ASSERT_OK(vw_file_write(in_copy(fixture, name), changed, strlen(changed)));
    free(changed);
    free(data);
}

TEST(the_matrix_may_differ_by_rounding_alone) {
    const struct fixture *fixture = renew(state);
    scale_number(fixture, "matrix.csv", 1 + 1e-13);
    ASSERT_OK(verify(fixture, NULL));
    scale_number(fixture, "matrix.csv", 1 + 1e-5);
    assert_refused(verify(fixture, NULL), "a changed number", "matrix.csv");
}

// The payout must be the division of the amount that the file states, whatever it is.
TEST(a_payout_is_divided_again) {
    const struct fixture *fixture = renew(state);
    void *data = NULL;
    size_t size_bytes = 0;
    ASSERT_OK(vw_file_read(in_copy(fixture, "payout.csv"), 1 << 20, &data, &size_bytes));
    char *line = strchr(data, '\n') + 1, *amount = strchr(line, '\n');
    while (amount[-1] != ',') amount--;
    char *less = vw_format_text("%.*s%s%s", (int)(amount - (char *)data), (char *)data, "1.23", strchr(amount, '\n'));
    ASSERT_OK(vw_file_write(in_copy(fixture, "payout.csv"), less, strlen(less)));
    assert_refused(verify(fixture, NULL), "a cut amount", "payout.csv");
    free(less);
    free(data);
    make_run(fixture->folder, "whole", 1, true, 4, NULL); // pays again, the same
    renew(state);
    ASSERT_OK(verify(fixture, NULL));
}

TEST(a_field_of_another_run_is_found) {
    const struct fixture *fixture = renew(state);
    copy_file(temporary_path(fixture->folder, "other"), fixture->out, "field.vwf");
    assert_refused(verify(fixture, NULL), "the field of another run", "field.vwf: is not the field");
    unlink(in_copy(fixture, "field.vwf"));
    ASSERT_OK(verify(fixture, NULL));
}

TEST(links_are_not_followed) {
    static const char *const names[] = {"scores.csv", "field.vwf", VW_SIGNATURE_FILE};
    for (size_t i = 0; i < VW_ARRAY_COUNT(names); i++) {
        const struct fixture *fixture = renew(state);
        char target[600];
        snprintf(target, sizeof target, "%s/whole/%s", fixture->folder, names[i]);
        unlink(in_copy(fixture, names[i]));
        assert_int_equal(symlink(target, in_copy(fixture, names[i])), 0);
        enum vw_status status = verify(fixture, fixture->public_key);
        if (!status) fail_msg("a link %s was followed", names[i]);
        unlink(in_copy(fixture, names[i]));
    }
}

// ---- Signatures ----------------------------------------------------------------------------------------------------

TEST(every_flipped_bit_of_a_signature_is_found) {
    const struct fixture *fixture = renew(state);
    struct vw_verification whole = {0};
    void *data = NULL;
    size_t size_bytes = 0;
    uint8_t key[VW_PUBLIC_KEY_BYTES];
    ASSERT_OK(vw_run_verify(&(struct vw_verify_params){.out = fixture->out, .to_sign = true}, &whole));
    ASSERT_OK(vw_public_key_read(fixture->public_key, key));
    ASSERT_OK(vw_statement_check(&whole.statement, fixture->out, key, NULL));
    ASSERT_OK(vw_file_read(in_copy(fixture, VW_SIGNATURE_FILE), 1 << 16, &data, &size_bytes));
    int descriptor = open(in_copy(fixture, VW_SIGNATURE_FILE), O_WRONLY | O_CLOEXEC);
    for (size_t bit = 0; bit < 8 * size_bytes; bit++) {
        uint8_t byte = ((uint8_t *)data)[bit / 8], flipped = (uint8_t)(byte ^ 1u << bit % 8);
        assert_int_equal(pwrite(descriptor, &flipped, 1, (off_t)(bit / 8)), 1);
        if (!vw_statement_check(&whole.statement, fixture->out, key, NULL))
            fail_msg("bit %zu of byte %zu (%c): the signature holds", bit % 8, bit / 8, byte);
        assert_int_equal(pwrite(descriptor, &byte, 1, (off_t)(bit / 8)), 1);
    }
    for (size_t bit = 0; bit < 8 * sizeof key; bit++) {
        key[bit / 8] ^= (uint8_t)(1u << bit % 8);
        if (!vw_statement_check(&whole.statement, fixture->out, key, NULL)) fail_msg("bit %zu of the key", bit);
        key[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    ASSERT_OK(vw_statement_check(&whole.statement, fixture->out, key, NULL));
    close(descriptor);
    free(data);
    vw_verification_free(&whole);
}

// What there is now, and a key to check its signature by.
struct signed_run {
    const struct fixture *fixture;
    struct vw_statement now;
    uint8_t key[VW_PUBLIC_KEY_BYTES];
    char *text; // owned: of the signature
};

// Replaces the first `old` of the signature by `new`, so that it says what there is now.
static void assert_signed(const struct signed_run *run, const char *old, const char *new) {
    char *place = strstr(run->text, old);
    if (!place) fail_msg("the signature lacks %s", old);
    char *changed = vw_format_text("%.*s%s%s", (int)(place - run->text), run->text, new, place + strlen(old));
    assert_refused(vw_statement_check(&run->now, run->fixture->out, run->key, NULL), old, ""); // of something else
    ASSERT_OK(vw_file_write(in_copy(run->fixture, VW_SIGNATURE_FILE), changed, strlen(changed)));
    assert_refused(vw_statement_check(&run->now, run->fixture->out, run->key, NULL), new, "does not fit what it is of");
    ASSERT_OK(vw_file_write(in_copy(run->fixture, VW_SIGNATURE_FILE), run->text, strlen(run->text)));
    free(changed);
}

static void assert_number_signed(struct signed_run *run, const char *name, uint64_t *number) {
    char *old = vw_format_text("\"%s\": %llu", name, (unsigned long long)*number);
    char *new = vw_format_text("\"%s\": %llu", name, (unsigned long long)++*number);
    assert_signed(run, old, new);
    --*number;
    free(old);
    free(new);
}

static void assert_hash_signed(struct signed_run *run, char *hash) {
    char old[VW_HASH_HEX_BYTES], first = *hash;
    memcpy(old, hash, sizeof old);
    *hash = first == '0' ? '1' : '0';
    assert_signed(run, old, hash);
    *hash = first;
}

// Whoever changes the run and its signature alike is found by the key alone.
TEST(whatever_a_statement_says_is_signed) {
    struct signed_run run = {.fixture = renew(state)};
    struct vw_verification whole = {0};
    void *data = NULL;
    size_t size_bytes = 0;
    ASSERT_OK(vw_run_verify(&(struct vw_verify_params){.out = run.fixture->out, .to_sign = true}, &whole));
    ASSERT_OK(vw_public_key_read(run.fixture->public_key, run.key));
    ASSERT_OK(vw_file_read(in_copy(run.fixture, VW_SIGNATURE_FILE), 1 << 16, &data, &size_bytes));
    run.text = data;
    run.now = whole.statement;
    struct vw_ledger_counts *counts = &run.now.counts;
    assert_number_signed(&run, "schema", &counts->schema_version);
    assert_number_signed(&run, "steps", &counts->steps);
    assert_number_signed(&run, "images", &counts->images);
    assert_number_signed(&run, "views", &counts->views);
    assert_number_signed(&run, "probes", &counts->probes);
    assert_number_signed(&run, "scores", &counts->scores);
    assert_hash_signed(&run, run.now.run_id);
    assert_hash_signed(&run, run.now.head);
    strcpy(run.now.status, "interrupted");
    assert_signed(&run, "finished", "interrupted");
    strcpy(run.now.status, "finished");
    for (size_t i = 0; i < VW_SIGNED_FILE_COUNT; i++) {
        if (!run.now.files[i].present) fail_msg("%s is not there", run.now.files[i].name);
        assert_number_signed(&run, "size_bytes", &run.now.files[i].size_bytes);
        assert_hash_signed(&run, run.now.files[i].sha256);
    }
    ASSERT_OK(vw_statement_check(&run.now, run.fixture->out, run.key, NULL));
    free(data);
    vw_verification_free(&whole);
}

// Texts that differ from the signature in one place, which a lenient reader would pass over.
TEST(a_signature_file_is_read_strictly) {
    static const struct {
        const char *what, *old, *new;
    } cases[] = {
        {"a field more", "{\n", "{\"more\": 1,"},
        {"a field twice", "  \"status\"", "  \"head\": \"\", \"status\""},
        {"a field less", "  \"status\": \"finished\",\n", ""},
        {"another type", "\"views\": ", "\"views\": \"\", \"x\": "},
        {"a number as text", "\"schema\": 9", "\"schema\": \"9\""},
        {"a real number", "\"schema\": 9", "\"schema\": 9.0"},
        {"a negative number", "\"size_bytes\": ", "\"size_bytes\": -"},
        {"another status", "finished", "running"},
        {"a file of another name", "\"scores.csv\"", "\"../scores.csv\""},
        {"files in another order", "\"scores.csv\"", "\"field.vwf\""},
        {"trailing data", "\n}\n", "\n}\n{}"},
        {"a broken file", "\n}\n", "\n"},
    };
    const struct fixture *fixture = renew(state);
    void *data = NULL;
    size_t size_bytes = 0;
    ASSERT_OK(vw_file_read(in_copy(fixture, VW_SIGNATURE_FILE), 1 << 16, &data, &size_bytes));
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        char *text = data, *place = strstr(text, cases[i].old);
        assert_non_null(place);
        char *changed =
            vw_format_text("%.*s%s%s", (int)(place - text), text, cases[i].new, place + strlen(cases[i].old));
        ASSERT_OK(vw_file_write(in_copy(fixture, VW_SIGNATURE_FILE), changed, strlen(changed)));
        assert_refused(verify(fixture, fixture->public_key), cases[i].what, VW_SIGNATURE_FILE);
        free(changed);
    }
    free(data);
}

TEST(every_signed_file_is_compared) {
    static const char *const names[] = {"report.html", "duplicates.csv", "field.vwf", "scores.csv"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(names); i++) {
        const struct fixture *fixture = renew(state);
        append(fixture, names[i], " ");
        assert_refused(verify(fixture, fixture->public_key), "a byte more", names[i]);
        unlink(in_copy(fixture, names[i]));
        assert_refused(verify(fixture, fixture->public_key), "missing", names[i]);
    }
    const struct fixture *fixture = renew(state);
    unlink(in_copy(fixture, "duplicates.csv"));
    ASSERT_OK(vw_run_sign(fixture->out, fixture->key, NULL));
    temporary_file(fixture->out, "duplicates.csv", "group,name\n");
    assert_refused(verify(fixture, fixture->public_key), "added since", "duplicates.csv");
}

TEST(signatures_of_others_are_refused) {
    const struct fixture *fixture = renew(state);
    char text[VW_PUBLIC_KEY_TEXT_BYTES], other[300], other_public[310];
    snprintf(other, sizeof other, "%s/other_key", fixture->folder);
    snprintf(other_public, sizeof other_public, "%s.pub", other);
    ASSERT_OK(vw_keys_make(other, text));
    assert_refused(verify(fixture, other_public), "another key", "is signed by another key");
    ASSERT_OK(vw_run_sign(fixture->out, other, NULL));
    ASSERT_OK(verify(fixture, other_public));
    assert_refused(verify(fixture, fixture->public_key), "another signer", text);
    unlink(in_copy(fixture, VW_SIGNATURE_FILE));
    assert_refused(verify(fixture, fixture->public_key), "an unsigned run", "the run is not signed");
}

// What was changed since the run ended is not vouched for.
TEST(only_an_intact_run_that_has_ended_is_signed) {
    const struct fixture *fixture = renew(state);
    append(fixture, "scores.csv", "x");
    assert_refused(vw_run_sign(fixture->out, fixture->key, NULL), "an edited table", "scores.csv");
    renew(state);
    unlink(in_copy(fixture, "field.vwf"));
    sql_change(in_copy(fixture, "ledger.db"), "DELETE FROM score; UPDATE run SET status = 'running', finished_utc = "
                                              "NULL, field_sha256 = NULL");
    chain_rewrite(in_copy(fixture, "ledger.db"));
    ASSERT_OK(verify(fixture, NULL));
    assert_int_equal(vw_run_sign(fixture->out, fixture->key, NULL), VW_ERROR_INPUT);
    assert_non_null(strstr(vw_error_message(), "the run is running"));
}

TEST(new_steps_remove_the_signature) {
    const struct fixture *fixture = renew(state);
    make_run(fixture->folder, "copy", 1, true, 5, NULL);
    assert_false(vw_file_exists(in_copy(fixture, VW_SIGNATURE_FILE)));
    ASSERT_OK(verify(fixture, NULL));
    copy_file(temporary_path(fixture->folder, "whole"), fixture->out, VW_SIGNATURE_FILE);
    assert_refused(verify(fixture, fixture->public_key), "an earlier signature", "of another state of the run");
    make_run(fixture->folder, "copy", 1, true, 5, fixture->key); // of a run that is finished already
    ASSERT_OK(verify(fixture, fixture->public_key));
}

TEST_GROUP(set_up, tear_down)
