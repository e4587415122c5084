// Replays the inputs that are kept in corpus/: made by hand, found by scripts/fuzz as reaching code that others do not,
// or once crashing. The last name printed is that of the input at fault.
#include "support/cmocka_test.h"

#include <dirent.h>

#include "base/file.h"
#include "fuzz/fuzz.h"

enum { INPUT_LIMIT_BYTES = 1 << 20 };

static int is_input(const struct dirent *entry) { return entry->d_name[0] != '.'; }

static void replay(const char *name, fuzz_target *target) {
    char corpus[1024], path[2048];
    struct dirent **entries = NULL;
    snprintf(corpus, sizeof corpus, "%s/tests/fuzz/corpus/%s", VW_SOURCE_FOLDER, name);
    int count = scandir(corpus, &entries, is_input, alphasort);
    if (count <= 0) fail_msg("%s: no inputs", corpus);
    for (int i = 0; i < count; i++) {
        AUTO_FREE void *data = NULL;
        size_t size_bytes = 0;
        snprintf(path, sizeof path, "%s/%s", corpus, entries[i]->d_name);
        fprintf(stderr, "%s\n", path);
        if (vw_file_read(path, INPUT_LIMIT_BYTES, &data, &size_bytes)) fail_msg("%s", vw_error_message());
        target(data, size_bytes);
        free(entries[i]);
    }
    free(entries);
    fuzz_remove_folder();
}

TEST(the_transforms_corpus_passes) { (void)state, replay("transforms", fuzz_transforms); }
TEST(the_binary_colmap_corpus_passes) { (void)state, replay("colmap_binary", fuzz_colmap_binary); }
TEST(the_text_colmap_corpus_passes) { (void)state, replay("colmap_text", fuzz_colmap_text); }
TEST(the_tsv_corpus_passes) { (void)state, replay("tsv", fuzz_tsv); }
TEST(the_photo_corpus_passes) { (void)state, replay("photo", fuzz_photo); }
TEST(the_recipe_corpus_passes) { (void)state, replay("recipe", fuzz_recipe); }
TEST(the_ledger_corpus_passes) { (void)state, replay("ledger", fuzz_ledger); }
TEST(the_store_corpus_passes) { (void)state, replay("store", fuzz_store); }
TEST(the_checkpoint_corpus_passes) { (void)state, replay("checkpoint", fuzz_checkpoint); }
TEST(the_field_corpus_passes) { (void)state, replay("field", fuzz_field); }
TEST(the_splats_corpus_passes) { (void)state, replay("splats", fuzz_splats); }
TEST(the_features_corpus_passes) { (void)state, replay("features", fuzz_features); }
TEST(the_step_log_corpus_passes) { (void)state, replay("steps", fuzz_steps); }
TEST(the_providers_corpus_passes) { (void)state, replay("providers", fuzz_providers); }
TEST(the_list_corpus_passes) { (void)state, replay("lists", fuzz_lists); }
TEST(the_table_corpus_passes) { (void)state, replay("tables", fuzz_tables); }
TEST(the_comparison_corpus_passes) { (void)state, replay("compare", fuzz_compare); }
TEST(the_jobs_corpus_passes) { (void)state, replay("jobs", fuzz_jobs); }
