#include "cli/output/results.h"

#include <math.h>
#include <string.h>

#include "base/json.h"
#include "base/text.h"
#include "cli/output/print.h"
#include "ledger/find_image.h"
#include "value/verdict.h"

enum { SHOWN_AT_EACH_END = 3, JSON_AT_EACH_END = 5 };

// A row: a photo with its score. A number that is NaN, and a rank that is 0, is not shown.
struct row {
    const char *name, *provider, *ground_truth;
    const struct vw_ledger_score *score;
    double quality, share_percent;
};

#define OF_ROW(member, kind)                                                                                           \
    { VW_CELL(#member, struct row, kind, member) }
#define OF_SCORE(name, kind, member)                                                                                   \
    { VW_CELL_VIA(name, struct row, score, kind, struct vw_ledger_score, member) }
static const struct vw_column columns[] = {
    OF_ROW(name, TEXT),
    OF_ROW(provider, TEXT_OR_NULL),
    OF_ROW(ground_truth, TEXT_OR_NULL),
    OF_SCORE("method", TEXT, method),
    OF_SCORE("value", REAL_OR_NULL, value),
    OF_SCORE("unit", TEXT, unit),
    OF_SCORE("stderr", REAL_OR_NULL, standard_error),
    OF_SCORE("ci_low", REAL_OR_NULL, ci_low),
    OF_SCORE("ci_high", REAL_OR_NULL, ci_high),
    OF_SCORE("rank_ci_low", COUNT, rank_ci_low),
    OF_SCORE("rank_ci_high", COUNT, rank_ci_high),
    OF_SCORE("visits", COUNT, visits),
    OF_ROW(quality, REAL_OR_NULL),
    OF_ROW(share_percent, REAL_OR_NULL), // the last, which only credit has
};

static double find_quality(const struct vw_ranking *ranking, uint32_t image_id) {
    for (uint32_t i = 0; i < ranking->quality_count; i++) {
        const struct vw_ledger_score *score = &ranking->qualities[i];
        if (score->image_id == image_id && score->visits && !strcmp(score->method, "quality")) return score->value;
    }
    return NAN;
}

static struct row row_at(const struct vw_ranking *ranking, uint32_t place, size_t folder_length) {
    const struct vw_ledger_score *score = &ranking->scores[place];
    struct row row = {.name = "?", .score = score, .quality = find_quality(ranking, score->image_id)};
    const struct vw_ledger_image *image = vw_ledger_find_image(ranking->images, ranking->image_count, score->image_id);
    const struct vw_view *view = ranking->scene ? &ranking->scene->views[score->image_id] : NULL;
    if (!view && !image) return row;
    row.name = (view ? view->name : image->name) + folder_length;
    row.provider = view ? view->provider : image->provider;
    row.ground_truth = view ? view->ground_truth : image->ground_truth;
    return row;
}

static uint32_t count_at_each_end(const struct vw_ranking *ranking, uint32_t most) {
    uint32_t half = ranking->count > 1 ? ranking->count / 2 : ranking->count;
    return half < most ? half : most;
}

static uint32_t count_judges(const struct vw_ranking *ranking) {
    uint32_t count = ranking->scene ? ranking->scene->split_count[VW_SPLIT_VAL] : 0;
    if (ranking->judge_count) return ranking->judge_count;
    for (uint32_t i = 0; !ranking->scene && i < ranking->image_count; i++)
        count += strcmp(ranking->images[i].split, vw_split_name(VW_SPLIT_VAL)) == 0;
    return count;
}

// Returns how many bytes of every name are the folder that all photos share.
static size_t shared_folder(const struct vw_ranking *ranking) {
    uint32_t count = ranking->scene ? ranking->scene->view_count : ranking->image_count;
    const char *first = NULL;
    size_t length = 0;
    for (uint32_t i = 0; i < count; i++) {
        const char *name = ranking->scene ? ranking->scene->views[i].name : ranking->images[i].name;
        if (!first) first = name, length = strlen(name);
        length = vw_text_shared_folder(first, length, name);
    }
    return length;
}

// Returns the factor by which credit becomes a share of what the training gained, in percent; 1 for other scores.
static double factor_of(const struct vw_ranking *ranking, const struct vw_ledger_score *score) {
    return strcmp(score->method, "dv_psnr") == 0 && ranking->gain_db > 0 ? 100 / ranking->gain_db : 1;
}

// Prints a score and its interval: shares with one decimal.
static void print_value(const struct vw_ledger_score *score, double factor) {
    bool share = factor != 1;
    vw_print(share ? "  %+9.1f " : "  %+9" VW_SCORE_DIGITS "f ", factor * score->value);
    if (isfinite(score->ci_low) && isfinite(score->ci_high))
        vw_print(share ? "[%+9.1f, %+9.1f] " : "[%+9" VW_SCORE_DIGITS "f, %+9" VW_SCORE_DIGITS "f] ",
                 factor * score->ci_low, factor * score->ci_high);
    vw_print("%s", share ? "%" : score->unit);
}

static void print_row(const struct row *row, double factor, bool ranks) {
    const struct vw_ledger_score *score = row->score;
    print_value(score, factor);
    if (ranks && score->rank_ci_low) vw_print("  rank %u-%u", score->rank_ci_low, score->rank_ci_high);
    if (isfinite(row->quality)) vw_print("  quality %.2f", row->quality);
    vw_print("  %s", row->name);
    if (row->ground_truth) vw_print(" (%s)", row->ground_truth);
    vw_print("\n");
}

void vw_ranking_print(const struct vw_ranking *ranking, const char *highest, const char *lowest) {
    uint32_t shown = count_at_each_end(ranking, SHOWN_AT_EACH_END), judges = count_judges(ranking);
    bool ranks = judges >= VW_AGREEMENT_VIEWS_MIN;
    size_t folder_length = shared_folder(ranking);
    for (uint32_t i = 0; i < 2 * shown; i++) {
        struct row row = row_at(ranking, i < shown ? i : ranking->count - 1 - (i - shown), folder_length);
        if (i == 0 || i == shown) vw_print("%s\n", i ? lowest : highest);
        print_row(&row, factor_of(ranking, row.score), ranks);
    }
    if (!ranks && ranking->count && ranking->scores[0].rank_ci_low)
        vw_print("no rank intervals: %u validation photo%s cannot tell how others would rank (at least %d can)\n",
                 judges, vw_plural(judges), VW_AGREEMENT_VIEWS_MIN);
}

json_t *vw_ranking_to_json(const struct vw_ranking *ranking, enum vw_ranking_rows rows) {
    uint32_t count = rows == VW_RANKING_ALL ? ranking->count : count_at_each_end(ranking, JSON_AT_EACH_END);
    json_t *array = json_array();
    for (uint32_t i = 0; i < count; i++) {
        struct row row = row_at(ranking, rows == VW_RANKING_LOWEST ? ranking->count - 1 - i : i, 0);
        double factor = factor_of(ranking, row.score);
        struct vw_rows shown = VW_ROWS(columns, &row, 1);
        row.share_percent = factor * row.score->value;
        shown.column_count -= factor == 1;
        vw_json_append(&array, vw_row_to_json(&shown, 0));
    }
    return array;
}
