// JOBS.json: the words that it gives each job, and what is refused.
#include "base/json.h"
#include "batch/batch.h"
#include "support/ledger_fixture.h"

static enum vw_status load(const char *folder, const char *text, struct vw_jobs *jobs) {
    const char *path = temporary_path(folder, "jobs.json");
    ASSERT_OK(vw_file_write(path, text, strlen(text)));
    return vw_jobs_load(path, jobs);
}

// Checks the words of a job, with spaces between them and without the folder of the file.
static void assert_words(const char *folder, const struct vw_job *job, const char *expected) {
    char text[1024] = "", scene[256], more[] = "--more", **words = vw_job_list_words(job, (char *[]){more, NULL});
    snprintf(scene, sizeof scene, "%s/", folder);
    for (uint32_t i = 1; words[i]; i++) {
        const char *word = words[i];
        if (!strncmp(word, scene, strlen(scene))) word += strlen(scene);
        snprintf(text + strlen(text), sizeof text - strlen(text), "%s ", word);
    }
    assert_string_equal(words[0], "viewworth");
    assert_int_equal(strncmp(text, expected, strlen(expected)), 0);
    assert_string_equal(text + strlen(expected), " --more ");
    free(words);
}

FOLDER_TEST(jobs_are_scenes_by_configs_by_seeds) {
    AUTO(vw_jobs_free) struct vw_jobs jobs;
    ASSERT_OK(load(*state,
                   "{\"defaults\": {\"epochs\": 16, \"quiet-not\": false, \"lasting\": true}, \"seeds\": [0, 7],"
                   " \"configs\": [{\"name\": \"short\", \"options\": {\"epochs\": 4}}, {\"name\": \"plain\"}],"
                   " \"jobs\": [{\"name\": \"fox\", \"scene\": \"a/fox\","
                   " \"options\": {\"lr\": 0.1, \"lasting\": false}},"
                   " {\"name\": \"toys\", \"scene\": \"/toys.json\", \"seeds\": [3], \"options\": {\"epochs\": 2,"
                   " \"effects\": \"+sky\"}}]}",
                   &jobs));
    assert_int_equal(jobs.count, 6);
    static const char *const names[] = {"fox/short/seed-0", "fox/short/seed-7",  "fox/plain/seed-0",
                                        "fox/plain/seed-7", "toys/short/seed-3", "toys/plain/seed-3"};
    for (uint32_t i = 0; i < jobs.count; i++) assert_string_equal(jobs.jobs[i].name, names[i]);
    assert_words(*state, &jobs.jobs[0], "value a/fox --seed=0 --epochs=4 --lr=0.1");
    assert_words(*state, &jobs.jobs[3], "value a/fox --seed=7 --epochs=16 --lr=0.1");
    assert_words(*state, &jobs.jobs[4], "value /toys.json --seed=3 --epochs=2 --lasting --effects=+sky");
}

FOLDER_TEST(a_scene_alone_is_a_job) {
    AUTO(vw_jobs_free) struct vw_jobs jobs;
    ASSERT_OK(load(*state, "{\"jobs\": [{\"name\": \"fox\", \"scene\": \"fox\"}]}", &jobs));
    assert_int_equal(jobs.count, 1);
    assert_string_equal(jobs.jobs[0].name, "fox/seed-0");
    assert_words(*state, &jobs.jobs[0], "value fox --seed=0");
}

#define JOBS(more) "{\"jobs\": [{\"name\": \"a\", \"scene\": \"a.json\"" more "}]}"

static enum vw_status try_jobs(const char *path) {
    AUTO(vw_jobs_free) struct vw_jobs jobs;
    return vw_jobs_load(path, &jobs);
}

FOLDER_TEST(an_error_of_the_file_is_named) {
    static const struct refused_text cases[] = {
        {"{\"jobs\": [", "jobs.json:1:"},
        {"[]", "expected an object with the keys: defaults seeds configs jobs"},
        {"{\"job\": []}", "job: unknown key"},
        {"{}", "jobs: expected an array of at most 4096 objects"},
        {"{\"jobs\": []}", "jobs: is empty"},
        {"{\"jobs\": [3]}", "jobs[0]: expected an object"},
        {"{\"jobs\": [{\"scene\": \"a\"}]}", "jobs[0].name: give 1 to 64 letters"},
        {"{\"jobs\": [{\"name\": \"a\"}]}", "jobs[0].scene: give the scene's"},
        {"{\"jobs\": [{\"name\": \"a/b\", \"scene\": \"a\"}]}", "jobs[0].name: "},
        {"{\"jobs\": [{\"name\": \"..\", \"scene\": \"a\"}]}", "jobs[0].name: "},
        {"{\"jobs\": [{\"name\": \"-a\", \"scene\": \"a\"}]}", "jobs[0].name: "},
        {"{\"jobs\": [{\"name\": 3, \"scene\": \"a\"}]}", "jobs[0].name: expected a text"},
        {"{\"jobs\": [{\"name\": \"a\", \"scene\": \"a\\nb\"}]}", "jobs[0].scene: "},
        {"{\"jobs\": [{\"name\": \"a\", \"scene\": \"a\"}, {\"name\": \"a\", \"scene\": \"b\"}]}",
         "jobs[1].name: \"a\" is the name of an earlier one"},
        {JOBS(", \"name\": \"b\""), "jobs.json:1:"},
        {JOBS(", \"sede\": 1"), "jobs[0].sede: unknown key"},
        {JOBS(", \"seeds\": 3"), "jobs[0].seeds: give an array"},
        {JOBS(", \"seeds\": []"), "jobs[0].seeds: give an array"},
        {JOBS(", \"seeds\": [-1]"), "jobs[0].seeds: a seed is"},
        {JOBS(", \"seeds\": [0.5]"), "jobs[0].seeds: a seed is"},
        {JOBS(", \"seeds\": [1, 2, 1]"), "jobs[0].seeds: 1 is named twice"},
        {JOBS(", \"options\": []"), "jobs[0].options: give an object"},
        {JOBS(", \"options\": {\"seed\": 3}"), "jobs[0].seed: no option of a job"},
        {JOBS(", \"options\": {\"out\": \"/tmp\"}"), "jobs[0].out: no option of a job"},
        {JOBS(", \"options\": {\"--epochs\": 3}"), "jobs[0].options: a key is not an option"},
        {JOBS(", \"options\": {\"a=b\": 3}"), "jobs[0].options: a key is not an option"},
        {JOBS(", \"options\": {\"epochs\": [3]}"), "jobs[0].epochs: give a number"},
        {JOBS(", \"options\": {\"epochs\": null}"), "jobs[0].epochs: give a number"},
        {JOBS(", \"options\": {\"train\": \"a\\nb\"}"), "jobs[0].train: give a number"},
        {"{\"defaults\": {\"resume\": true}, \"jobs\": []}", "resume: no option of a job"},
        {"{\"seeds\": [true], \"jobs\": []}", "seeds: a seed is"},
        {"{\"configs\": {}, \"jobs\": []}", "configs: expected an array"},
        {"{\"configs\": [{\"name\": \"x\"}, {\"name\": \"x\"}], \"jobs\": []}", "configs[1].name: "},
        {"{\"configs\": [{\"name\": \"x\", \"scene\": \"y\"}], \"jobs\": []}", "configs[0].scene: unknown key"},
    };
    ASSERT_TEXTS_REFUSED(*state, "jobs.json", cases, try_jobs(path));
}

FOLDER_TEST(absurd_numbers_of_jobs_are_refused) {
    static char text[1 << 16];
    AUTO(vw_jobs_free) struct vw_jobs jobs;
    int used = snprintf(text, sizeof text, "{\"seeds\": [0");
    for (int i = 1; i < VW_JOBS_MAX; i++) used += snprintf(text + used, sizeof text - (size_t)used, ",%d", i);
    snprintf(text + used, sizeof text - (size_t)used,
             "], \"jobs\": [{\"name\": \"a\", \"scene\": \"a\"},"
             " {\"name\": \"b\", \"scene\": \"b\", \"seeds\": [0]}]}");
    ASSERT_FAILS(load(*state, text, &jobs), VW_ERROR_INPUT, "jobs: more than 4096 valuations");
}

// Writes the record of job a and returns whether the job is done by it.
static bool is_done(const char *folder, const struct vw_jobs *jobs, const char *format, const char *words) {
    AUTO(vw_batch_free) struct vw_batch batch;
    char record[512];
    snprintf(record, sizeof record, format, words);
    ASSERT_OK(vw_file_write(temporary_path(folder, "a/seed-0.json"), record, strlen(record)));
    ASSERT_OK(vw_batch_look(jobs, folder, &batch));
    assert_int_equal(batch.done, batch.rows.rows[0].state == VW_JOB_DONE);
    if (!batch.done) assert_int_equal(batch.rows.rows[0].state, VW_JOB_WAITING);
    return batch.done;
}

FOLDER_TEST(a_job_is_done_by_a_record_of_its_words_and_its_run) {
    static const char whole[] = "{\"words\": %s, \"exit_code\": 0, \"seconds\": 2.5, \"message\": null}";
    static const char *const broken[] = {"",
                                         "{",
                                         "[]",
                                         "{\"words\": 3, \"exit_code\": 0, \"seconds\": 1}",
                                         "{\"words\": %s, \"exit_code\": 1, \"seconds\": 1, \"message\": \"why\"}",
                                         "{\"words\": %s, \"exit_code\": 0, \"seconds\": -1, \"message\": \"\"}"};
    AUTO(vw_jobs_free) struct vw_jobs jobs, others;
    ASSERT_OK(load(*state, JOBS(", \"options\": {\"epochs\": 4}"), &others));
    ASSERT_OK(load(*state, JOBS(", \"options\": {\"epochs\": 3}"), &jobs));
    ASSERT_OK(vw_folder_create(temporary_path(*state, "a/seed-0")));
    char *words = vw_json_to_text(jobs.jobs[0].words, JSON_COMPACT);
    assert_false(is_done(*state, &jobs, whole, words)); // its run is not there
    ASSERT_OK(vw_file_write(temporary_path(*state, "a/seed-0/ledger.db"), "", 0));
    assert_true(is_done(*state, &jobs, whole, words));
    assert_false(is_done(*state, &others, whole, words));
    for (size_t i = 0; i < VW_ARRAY_COUNT(broken); i++) assert_false(is_done(*state, &jobs, broken[i], words));
    free(words);
}
