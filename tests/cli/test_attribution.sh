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
    ! "$@" >"$folder/stdout" 2>"$folder/stderr" && grep -q 'duplicates\.csv: is not a file' "$folder/stderr" &&
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
    prints '^payout of 1000\.01: nobody is paid, .*: viewworth worth .*/run --retrainings M --payout 1000\.01$' \
    "${resume[@]}" --providers "$folder/providers.csv" --payout 1000.01
check "there is no table of payouts" test ! -e "$out/payout.csv" -a ! -e "$out/payout_photos.csv"
"${resume[@]}" --providers "$folder/providers.csv" --payout 5 --json --quiet >"$folder/answer.json"
check "--json says why nobody is paid" test "$(sqlite3 :memory: "SELECT j ->> '\$.unpaid.reason', j -> '\$.payout' IS NULL,
    json_array_length(j, '\$.duplicates') = 0, (SELECT count(*) FROM json_each(j, '\$.providers') WHERE value ->> 'method' = 'dv_psnr')
    FROM (SELECT CAST(readfile('$folder/answer.json') AS TEXT) AS j)")" = 'no retrainings|1|1|4'
check "it takes no step, and the ledger records what was asked" test "$(query run 'SELECT group_concat(row_hash) FROM step')$(query run \
    "SELECT cents FROM payout_request")" = "${steps}500"
check "a command that is asked for no payout leaves none" eval 'run "${resume[@]}" --providers "$folder/providers.csv" --quiet &&
    [[ ! -e $out/payout.csv && ! -e $out/payout_photos.csv ]] && run "$program" verify "$out" --quiet'
sed 's/,chris$/,dora/' "$folder/providers.csv" >"$folder/others.csv"
check "providers may be named afterwards" prints ' dora( |$)' "${resume[@]}" --providers "$folder/others.csv" --payout 5
check "that they differ from the ledger's is said" grep -q '^warning: providers are those given now' "$folder/stderr"
check "verify names tables of other providers than the ledger's" fails 1 'providers\.csv: .* or made with other --providers' \
    "$program" verify "$out"
check "and knows them by those" prints '^providers\.csv +intact +made again from the ledger and --providers$' "$program" verify "$out" \
    --providers "$folder/others.csv"
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
