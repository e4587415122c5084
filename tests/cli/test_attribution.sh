#!/usr/bin/env bash
# Providers, payouts, near-duplicates and the matrix from outside, on a run and afterwards on a finished one. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
scene=$root/scenes/clean.json
tiny=("${small[@]}" --epochs 4)
out=$folder/run

refuses() { fails 2 "$1" "$program" "${@:2}" --quiet; } # refuses PATTERN ARGUMENT...

# fails_to_remove COMMAND...: it fails, names duplicates.csv, and adds no step to the ledger.
fails_to_remove() {
    ! "$@" >"$folder/stdout" 2>"$folder/stderr" && grep -q 'duplicates\.csv: cannot remove' "$folder/stderr" &&
        [[ $(query run 'SELECT status, final_hash FROM run') == "finished|$head" ]] && return
    cat "$folder/stdout" "$folder/stderr"
    return 1
}

# table FILE SQL: the answer to a query on OUT/FILE as the table t.
table() { sqlite3 :memory: ".mode csv" ".import '$out/$1' t" ".mode list" "$2"; }

printf 'name,provider\n' >"$folder/providers.csv"
for i in 01 02 03; do echo "view_0$i,anna" >>"$folder/providers.csv"; done
for i in 05 06 07 09; do echo "view_0$i,\"Smith, \"\"Jo\"\"\"" >>"$folder/providers.csv"; done
for i in 10 11; do echo "view_0$i,chris" >>"$folder/providers.csv"; done
printf 'view_000,anna\nview_004,anna\nview_008,dan\n' >>"$folder/providers.csv" # which validate, and is kept for tests

# ---- Before any step ----------------------------------------------------------------------------------------------------

check "--payout without providers is refused" refuses 'no photo to train on has a provider' value "$scene" --out "$out" "${tiny[@]}" \
    --payout 10
check "--payout 1.005 is refused" refuses '--payout takes an amount' value "$scene" --out "$out" "${tiny[@]}" \
    --providers "$folder/providers.csv" --payout 1.005 # test_payout.c has other texts
check "--payout of a run without scores is refused" refuses '--payout: .*no epoch after --burn-in 4' \
    value "$scene" --out "$out" "${tiny[@]}" --providers "$folder/providers.csv" --payout 10 --burn-in 4
check "--pay-anyway and --payout-floor without --payout are refused" eval '
    refuses "pay-anyway needs --payout" value "$scene" --out "$out" "${tiny[@]}" --pay-anyway &&
    refuses "payout-floor needs --payout" value "$scene" --out "$out" "${tiny[@]}" --payout-floor equal'
check "refused runs leave nothing" test ! -e "$out"

# ---- A run --------------------------------------------------------------------------------------------------------------

check "value with providers shows them" prints '^providers \(dv_psnr' "$program" value "$scene" --out "$out" "${tiny[@]}" \
    --providers "$folder/providers.csv"
each=' dB  (anna \(3 photos\)|Smith, "Jo" \(4 photos\)|chris \(2 photos\)|\(no provider\) \(3 photos\))$'
check "each is there with its photos" test "$(grep -cE "$each" "$folder/stdout")" = 4
check "providers.csv holds their sums" test "$(table providers.csv "ATTACH '$out/ledger.db' AS run;
    SELECT count(*), max(abs(t.value - s.value)) < 1e-9, min(t.photos = s.photos), max(abs(t.stderr - s.stderr)) < 1e-9 FROM t
    JOIN (SELECT coalesce(provider, '') AS provider, method, sum(value) AS value, count(*) AS photos, sqrt(sum(stderr * stderr)) AS stderr
        FROM run.score JOIN run.image USING (image_id) GROUP BY 1, 2) AS s USING (provider, method)")" = \
    "$((4 * $(query run "SELECT count(DISTINCT method) FROM score WHERE method NOT IN ('quality', 'train_fit')")))|1|1|1"
check "without --payout nobody is paid" test ! -e "$out/payout.csv"
check "unlike photos are no duplicates" test ! -e "$out/duplicates.csv"
check "matrix.csv has two rows per photo" test "$(table matrix.csv "SELECT count(*), count(DISTINCT name) FROM t")" = '24|12'
check "its means are the photos' dv_psnr" test "$(table matrix.csv "ATTACH '$out/ledger.db' AS run;
    SELECT count(*), max(abs(t.mean - s.value)) < 1e-9 FROM t JOIN run.image AS i USING (name)
    JOIN run.score AS s ON s.image_id = i.image_id AND s.method = t.measure WHERE t.measure = 'dv_psnr'")" = '12|1'
check "it has a column per validation photo" grep -q ',view_000,view_008$' <(head -n 1 "$out/matrix.csv")
check "how far the ranking holds for other views is told" grep -qE 'by [0-9]+ other validation photos would agree' "$folder/stdout"

# ---- A finished run -----------------------------------------------------------------------------------------------------

steps=$(query run 'SELECT group_concat(row_hash) FROM step')
resume=("$program" value "$scene" --out "$out" "${tiny[@]}" --resume)
check "without retrainings nobody is paid, and how many to begin with is said" \
    prints '^payout of 1000\.01: nobody is paid, .*: viewworth worth OUT --retrainings 24 --payout 1000\.01; or --pay-anyway$' \
    "${resume[@]}" --providers "$folder/providers.csv" --payout 1000.01
check "there is no table of payouts" test ! -e "$out/payout.csv" -a ! -e "$out/payout_photos.csv"
check "photos that were not valued are named, and how they would be" test "$(grep -cE \
    '^  unvalued, so not paid: of (anna 1 that validate, 1 kept|dan 1 that validate, 0 kept)|value --kfold K' "$folder/stdout")" = 3
"${resume[@]}" --providers "$folder/providers.csv" --payout 5 --json --quiet >"$folder/answer.json"
check "--json says why nobody is paid" test "$(sqlite3 :memory: "SELECT j ->> '\$.unpaid.reason', j ->> '\$.unpaid.retrainings_enough',
    j -> '\$.payout' IS NULL FROM (SELECT CAST(readfile('$folder/answer.json') AS TEXT) AS j)")" = 'no retrainings|24|1'
check "--pay-anyway pays by credit" prints '^payout of 1000\.01 by dv_psnr' "${resume[@]}" --providers "$folder/providers.csv" \
    --payout 1000.01 --pay-anyway
check "it takes no step, and the ledger records what was asked" test "$(query run 'SELECT group_concat(row_hash) FROM step')$(query run \
    "SELECT cents FROM payout_request")" = "${steps}100001"
check "payout.csv adds up to the cent" test "$(table payout.csv "SELECT printf('%.2f', sum(amount)), count(*), sum(photos), sum(validating),
    sum(tests) FROM t")" = '1000.01|4|9|2|1'
check "a score that is not positive gets nothing, the others are in proportion" test "$(table payout_photos.csv "SELECT count(*),
    max(CASE WHEN value + 0 > 0 THEN abs(amount - 1000.01 * value / (SELECT sum(value) FROM t WHERE value + 0 > 0))
    ELSE amount + 0 END) <= 0.01 FROM t")" = '9|1'
check "providers get the sums of their photos to the cent" test "$(sqlite3 -cmd '.mode csv' -cmd ".import '$out/payout.csv' p" \
    -cmd ".import '$out/payout_photos.csv' t" :memory: "SELECT count(*), max(CAST(round(100 * p.amount) AS INTEGER) <> coalesce(paid, 0))
    FROM p LEFT JOIN (SELECT provider, sum(CAST(round(100 * amount) AS INTEGER)) AS paid FROM t GROUP BY provider)
    USING (provider)")" = '4,0'
check "intervals hold the amounts" test "$(table payout.csv "SELECT min(ci_low <= amount + 0 AND amount + 0 <= ci_high) FROM (SELECT
    ci_low + 0 AS ci_low, ci_high + 0 AS ci_high, amount FROM t)")" = 1
cp "$out/payout.csv" "$out/payout_photos.csv" "$folder"
check "paying again pays the same" prints '^payout of ' "${resume[@]}" --providers "$folder/providers.csv" --payout 1000.01 --pay-anyway
check "to the byte" cmp "$out/payout.csv" "$folder/payout.csv"
# The same photos under one name, and under one each: no photo is paid more or less, nor is its interval another.
paid_by_photo() { cut -d, -f 1,4- "$1" | sort; }
for names in 's/^\(view_0..\),.*/\1,one/' 's/^\(view_0..\),.*/\1,of \1/'; do
    sed -e "$names" -e '1s/.*/name,provider/' "$folder/providers.csv" >"$folder/names.csv"
    check "other names ($(tail -n 1 "$folder/names.csv"))" prints '^payout of ' "${resume[@]}" --providers "$folder/names.csv" \
        --payout 1000.01 --pay-anyway
    sed 's/"Smith, ""Jo"""/jo/' "$folder/payout_photos.csv" >"$folder/photos.csv"
    check "change no photo's payout" cmp <(paid_by_photo "$out/payout_photos.csv") <(paid_by_photo "$folder/photos.csv")
done
"${resume[@]}" --providers "$folder/providers.csv" --payout 77 --pay-anyway --json --quiet >"$folder/answer.json"
check "--json tells the same" bash -c "sqlite3 :memory: \"SELECT (SELECT sum(value ->> 'cents') FROM json_each(j, '\$.payout')) = 7700
        AND (SELECT count(*) FROM json_each(j, '\$.providers') WHERE value ->> 'method' = 'dv_psnr') = 4
        AND json_array_length(j, '\$.duplicates') = 0 AND json_array_length(j, '\$.validation_views') = 2
        AND j ->> '\$.validation_views[0].ranking_without' <= 1 AND j ->> '\$.validation_views[1].far' = 0
        FROM (SELECT CAST(readfile('$folder/answer.json') AS TEXT) AS j)\" | grep -qx 1"
check "a command that is asked for no payout leaves none" eval 'run "${resume[@]}" --providers "$folder/providers.csv" --quiet &&
    [[ ! -e $out/payout.csv && ! -e $out/payout_photos.csv ]] && run "$program" verify "$out" --quiet'
sed 's/,chris$/,dora/' "$folder/providers.csv" >"$folder/others.csv"
check "providers may be named afterwards" prints ' dora( |$)' "${resume[@]}" --providers "$folder/others.csv" --payout 5 --pay-anyway
check "that they differ from the ledger's is said" grep -q '^warning: providers are those given now' "$folder/stderr"
check "verify names tables of other providers than the ledger's" fails 1 'providers\.csv: .* or made with other --providers' \
    "$program" verify "$out"
check "and knows them by those" prints '^payout\.csv +intact +made again from the ledger and --providers$' "$program" verify "$out" \
    --providers "$folder/others.csv"
rm "$out/payout.csv"
check "half a payout is none" fails 1 'payout\.csv: is missing' "$program" verify "$out" --providers "$folder/others.csv"
printf 'name,provider\nview_001,anna\nview_002,Anna\n' >"$folder/alike.csv"
check "providers that look alike are refused" refuses 'alike.csv:3: provider "Anna" looks like "anna" of line 2' "${resume[@]:1}" \
    --providers "$folder/alike.csv"
mkdir "$out/duplicates.csv"
head=$(query run 'SELECT final_hash FROM run')
check "what cannot be removed stops a run before it is extended" fails_to_remove "${resume[@]}" --epochs 5 --quiet
rmdir "$out/duplicates.csv"
echo old >"$out/duplicates.csv"
check "the run is extended" prints '' "${resume[@]}" --epochs 5 --quiet
check "new steps make the old tables void" test "$(cd "$out" && echo *.csv)" = 'advice.csv matrix.csv scores.csv'
check "and the matrix is new" test "$(table matrix.csv "ATTACH '$out/ledger.db' AS run;
    SELECT count(*), max(abs(t.mean - s.value)) < 1e-9 FROM t JOIN run.image AS i USING (name)
    JOIN run.score AS s ON s.image_id = i.image_id AND s.method = t.measure WHERE t.measure = 'dv_psnr'")" = '12|1'

# ---- Near-duplicates ----------------------------------------------------------------------------------------------------

# The same orbit twice, by two providers: every photo has a copy, which trains, validates or is kept for tests like its original.
sed 's/"count": 16, "field_of_view_deg": 50}/"count": 16, "field_of_view_deg": 50, "provider": "anna"},\
    {"path": "orbit", "centre": [0, 0, -0.2], "radius": 2.6, "elevation_deg": [25, 45], "turns": 2, "count": 16,\
     "field_of_view_deg": 50, "provider": "bob"}/' "$scene" >"$folder/twice.json"
out=$folder/twice
check "a scene of copies is valued" prints '^near-duplicates, together ' "$program" value "$folder/twice.json" --out "$out" "${tiny[@]}" \
    --payout 100
check "every group is found" test "$(table duplicates.csv 'SELECT count(*), count(DISTINCT "group") FROM t')" = '24|12'
check "copies stand beside their originals" test "$(table duplicates.csv "SELECT DISTINCT count(*), min(provider), max(provider),
    abs(sum(value) - max(group_value)) < 1e-9 FROM t GROUP BY \"group\"")" = '2|anna|bob|1'
check "that they are of two providers is said" grep -q '^warning: 12 groups .* with several providers (first: view_001)' \
    "$folder/stderr"
printf 'view_016\nview_008\n' >"$folder/val.txt"
printf 'view_00%d\n' 0 1 2 3 4 5 6 7 >"$folder/train.txt"
out=$folder/leak
check "copies of validation photos are valued" prints '' "$program" value "$folder/twice.json" --out "$out" "${tiny[@]}" \
    --train "$folder/train.txt" --val "$folder/val.txt"
check "that they know what is validated is said" \
    grep -q '^warning: 1 group of .* with both training and validation photos (first: view_000)' "$folder/stderr"
conclude "$@"
