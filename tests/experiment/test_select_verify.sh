#!/usr/bin/env bash
# `viewworth select`, which verifies, on a tiny recipe: what it prints and writes, that it trains nothing twice, goes on after
# an interruption, and what it refuses. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"

# Four photos to validate, two of twelve to train on with poses that are far off.
sed 's/"count": 2, "start_deg": 30/"count": 4, "start_deg": 30/; s/"count": 6/"count": 12/
    s/"strength": 20, "views": \[4\]/"strength": 70, "views": [4, 7]/' \
    "$root/tests/support/tiny.json" >"$folder/tiny.json"
tiny=(--rays 32 --samples 8 --importance-samples 0 --lr 0.003 --learning-rate-decay 1 --levels 4 --log2-table 8 --width 16 --effects none
    --device llvmpipe)
cd "$folder" || exit 1

# refuses PATTERN ARGUMENT...: exit code 2, nothing on stdout, and one line on stderr that matches.
refuses() { fails 2 "$1" "$program" "${@:2}" --quiet; }
quietly() { "$@" >silent 2>&1 || { cat silent; return 1; }; }
retrainings() { sqlite3 "$1/retrainings.db" 'SELECT count(*) FROM retraining' 2>/dev/null || echo 0; }
verify() { # verify OUT LIST [OPTION]...: select, which verifies; what it prints is in stdout and stderr
    rm -f "$2"
    "$program" select "$1" --to "$2" "${@:3}" >stdout 2>stderr && return
    cat stderr
    return 1
}
says() { # says SQL: the expression on the JSON of stdout, called j
    test "$(sqlite3 :memory: "SELECT $1 FROM (SELECT CAST(readfile('stdout') AS TEXT) AS j)")" = 1
}

"$program" value tiny.json --out valued "${tiny[@]}" --epochs 12 --quiet >stdout || exit 1

# ---- What it prints and writes ----

check "lists are verified" verify valued list.txt
check "how is said" grep -q '^verified by trainings at equal steps with seeds 1 to 2: 2 and 2 validation photos$' stdout
check "all photos are the first candidate" grep -qE '^all +12 .*  the others are compared with it' stdout
check "other candidates have intervals" grep -qE '^[a-z]+[^ ]* +[0-9]+ +[-+][0-9.]+  [-+][0-9.]+ to [-+][0-9.]+$' stdout
check "thinning and random lists are among them" test "$(grep -oE '(thinned|random):(75|90)%' stdout | sort -u | wc -l)" = 4
check "a sentence says what was chosen and why" grep -qE '^chosen   (all photos: no list is better|[a-z].*: of the lists whose)' stdout
check "trainings, time and what Ctrl-C keeps are said first" grep -qE \
    "^$(retrainings valued) trainings, about [0-9.]+ (s|min|h); Ctrl-C keeps what is done$" stderr
check "the list is a list for --train" quietly "$program" train tiny.json --train list.txt --out trained "${tiny[@]}" --epochs 1 --quiet
cp stdout first
check "that lasting credit has none is said" grep -q 'viewworth lasting valued --lasting-matrix' stderr
made=$(retrainings valued)
check "every list was trained on twice" test "$((made > 3 && made % 2 == 0))" = 1
check "with seeds other than the run's" test "$(sqlite3 valued/retrainings.db "SELECT group_concat(seed) FROM
    (SELECT DISTINCT seed FROM retraining ORDER BY seed)")" = 1,2
check "the results of single photos are kept" test "$(sqlite3 valued/retrainings.db "SELECT count(*) FROM view WHERE image_id IN
    (12, 13, 14, 15) AND psnr > 5")" = "$((4 * made))"
check "the run stays intact" quietly "$program" verify valued --quiet

# ---- Resuming ----

check "the same command again" verify valued list.txt
check "prints the same" cmp stdout first
check "and trains nothing" test "$(retrainings valued)" = "$made"
cp -r valued interrupted
sqlite3 interrupted/retrainings.db "DELETE FROM retraining WHERE seed = 2; DELETE FROM view WHERE retraining_id NOT IN
    (SELECT retraining_id FROM retraining)"
check "half of the trainings are made again, on two devices" verify interrupted again.txt --devices llvmpipe,llvmpipe
check "which are announced" grep -qE "^$((made / 2)) trainings, about " stderr
check "to the same result" cmp <(head -n -2 stdout) <(head -n -2 first)
check "the same list" cmp list.txt again.txt
check "and as many trainings" test "$(retrainings interrupted)" = "$made"
check "a third seed adds to them" verify valued list.txt --seeds 3
check "half as many again" test "$(retrainings valued)" = "$((made * 3 / 2))"

# ---- JSON ----

check "--json prints one object" verify interrupted json.txt --json
check "with the list, its format and the verification" says "(SELECT group_concat(key) FROM json_each(j)) =
    'path,format,method,selected,verified' AND j ->> '\$.format' = 'text' AND
    (SELECT group_concat(key) FROM json_each(j, '\$.verified')) = 'candidates,chosen'"
check "candidates have names, photos, gains and intervals" says "(SELECT count(*) > 2 AND sum(value ->> '\$.photos' NOT BETWEEN 2 AND 12)
    = 0 AND sum(value ->> '\$.gain_db' NOT BETWEEN value ->> '\$.ci_low' AND value ->> '\$.ci_high') = 0
    FROM json_each(j, '\$.verified.candidates'))"
check "the chosen one is one of them, and is the list" says "(SELECT value ->> '\$.photos' = json_array_length(j, '\$.selected')
    FROM json_each(j, '\$.verified.candidates') WHERE value ->> '\$.name' = j ->> '\$.verified.chosen')"
check "all photos have no gain" says "j ->> '\$.verified.candidates[0].name' = 'all' AND
    j ->> '\$.verified.candidates[0].gain_db' = 0"

cp -r valued stopped
"$program" select stopped --to stopped.txt --seeds 50 >stdout 2>stderr &
process=$!
for ((i = 0; i < 600 && $(retrainings stopped) <= made * 3 / 2; i++)); do sleep 0.1; done
kill -INT "$process"
wait "$process"
check "Ctrl-C is said to keep the trainings" grep -q 'interrupted; stopped keeps the finished retrainings; the same command resumes' stderr
check "some are kept" test "$(retrainings stopped)" -gt $((made * 3 / 2))
check "no list is written" test ! -e stopped.txt

# ---- Few validation photos ----

printf 'view_012\nview_013\n' >two.txt
echo view_012 >one.txt
for few in two one; do
    "$program" value tiny.json --out $few "${tiny[@]}" --epochs 3 --quiet --val $few.txt >stdout 2>&1 || cat stdout
done
check "two photos are halves of one each" verify two list_of_two.txt
check "which is said to prove little" grep -q 'only 2 validation photos judge, which proves little' stdout
check "a sweep by validation photo" quietly "$program" lasting two --lasting-matrix --no-gate --quiet
check "gives lists by lasting credit" eval 'verify two list_of_lasting.txt && grep -qE "(^|[ ,])top:[79][05]%:lasting_psnr" stdout'
check "a single photo is refused, with a remedy" refuses \
    'has 1 validation photo, but a verified selection needs at least 2: .*or select with --quick' select one --to single.txt
check "without a training" test "$(retrainings one)" = 0

# ---- Refusals ----

check "--seeds without trainings" refuses '--seeds is of trainings' select valued --rule top:3 --seeds 3 --to r.txt
check "a list that is there, before any training" refuses 'list.txt: exists' select two --to list.txt --seeds 9
cp -r valued other
sqlite3 other/ledger.db "UPDATE image SET name = 'view_112' WHERE name = 'view_012'"
check "image rows that are not the scene's" eval '! "$program" select other --to r.txt --quiet 2>stderr &&
    grep -q "an image row was edited" stderr'
sqlite3 other/ledger.db "UPDATE image SET name = 'view_012' WHERE name = 'view_112'"
sed -i 's/"seed": 3/"seed": 4/' tiny.json
check "a scene that has changed" refuses 'no longer the scene' select other --to r.txt
rm tiny.json
check "a scene that is gone" refuses 'tiny.json' select other --to r.txt
check "nothing was written of what was refused" test ! -e r.txt
conclude "$@"
