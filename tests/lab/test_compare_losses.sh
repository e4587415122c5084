#!/usr/bin/env bash
# The comparison of losses (scripts/lab/compare_losses), on a tiny scene: it measures what the runs recorded, and says when it cannot.
# Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
command -v python3 >/dev/null || { echo "SKIPPED: python3 is missing; apt-get install python3"; exit 77; }

compare() { VIEWWORTH=$program VIEWWORTH_LAB=$lab "$root/scripts/lab/compare_losses" "$@" >"$folder/stdout" 2>"$folder/stderr"; }
tiny() { compare "$folder/out" 4 huber:0.3 "$root/tests/support/tiny.json" -- --epochs 2 "${small[@]}" --val-rays 64 --device llvmpipe; }
value() { sqlite3 :memory: ".mode csv" ".import '$folder/out/losses.csv' t" ".mode list" \
    "SELECT value FROM t WHERE loss = '$1' AND measure = '$2'"; } # value LOSS MEASURE
recorded() { sqlite3 "$folder/out/tiny/$1" "$2"; }                # recorded DATABASE SQL

check "runs with a loss are made" tiny
check "with its own length" test "$(recorded huber-0.3/seed_0/ledger.db \
    "SELECT json_extract(config_json, '\$.huber_length') FROM run")" = 0.3
check "a table has a column for it" grep -q '^| | huber:0.3 |$' "$folder/stdout"
check "the level is that of trainings on all photos" near "$(value huber:0.3 'test PSNR of all photos, dB')" \
    "$(recorded huber-0.3/retrainings.db 'SELECT avg(test_psnr) FROM retraining WHERE view_count = 6 AND seed > 4')"
check "what corruption costs is measured on the recipe without defects" near \
    "$(value huber:0.3 'validation PSNR lost by corruption, dB')" "$(for run in huber-0.3-clean huber-0.3; do for seed in 0 1 2 3; do
        recorded $run/seed_$seed/ledger.db 'SELECT avg(val_psnr) FROM step WHERE step IN (6, 12)'; done; done |
        awk '{ sum += (NR <= 4 ? $1 : -$1) / 4 } END { printf "%.12f", sum }')"
agreement=$(value huber:0.3 'leave-one-out, test: reliability, one seed')
check "longer means are as reliable as Spearman and Brown say" near \
    "$(value huber:0.3 'leave-one-out, test: of means of 8 (from one seed'"''"'s)')" \
    "$(awk -v OFMT=%.15g -v r="$agreement" 'BEGIN { print (r > 0 ? 8 * r / (1 + 7 * r) : r) }')"
trainings() { recorded huber-0.3/retrainings.db 'SELECT count(*) FROM retraining'; }
before=$(trainings)
check "the runs are swept" test "$(value huber:0.3 'lasting_psnr: agreement of two seeds')" != ''
scores() { "$root/scripts/lab/compare_scores" "$folder/out/tiny/huber-0.3" >"$folder/scores"; }
check "scores are compared by the same benchmark" scores
check "by the mean of the seeds" test "$(awk -F' \\| ' '/^\| lasting_psnr/ { print $3 }' "$folder/scores")" = \
    "$(printf %.2f "$(value huber:0.3 'lasting_psnr, mean of seeds: Spearman, validation')")"
check "below a ceiling" grep -q '^| ceiling |' "$folder/scores"
check "the same command resumes" tiny
check "and trains nothing anew" test "$before" = "$(trainings)"
check "three seeds are refused" test "$(compare "$folder/out" 3 l1 scene; grep -c usage "$folder/stderr")" = 1
check "a loss that there is not is refused" test "$(compare "$folder/none" 4 l3 "$root/tests/support/tiny.json"
    grep -c -- --loss "$folder/stderr")" = 1
conclude "$program"
