#!/usr/bin/env bash
# worth and value --retrainings from outside: retrainings on subsets of a run's photos, and the scores from them. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
tiny=(--rays 16 --samples 8 --importance-samples 0 --lr 0.003 --learning-rate-decay 1 --val-rays 64 --levels 2 --log2-table 6 --width 16
    --effects none --device llvmpipe --epochs 5 --no-thumbnails)
printf 'name,provider\n' >"$folder/providers.csv"
for i in 0 1 2 3 4 5; do echo "view_00$i,p$((i / 2))" >>"$folder/providers.csv"; done
sed 's/,p.$/,one/' "$folder/providers.csv" >"$folder/one.csv"

value() { "$program" value "$scene" --out "$folder/$1" "${tiny[@]}" --quiet "${@:2}"; }             # value OUT [OPTION]...
worth() { "$program" worth "$folder/$1" --device llvmpipe --no-thumbnails --quiet "${@:2}"; }        # worth OUT [OPTION]...
intact() { run "$program" verify "$folder/$1" --quiet; }                                             # intact OUT
retrained() { query "$1" 'SELECT seed, epochs, image_ids, val_psnr FROM retraining'; } # retrained OUT
head_of() { query "$1" 'SELECT final_hash FROM run'; }                                               # head_of OUT
fresh() { rm -rf "${folder:?}/$1" && cp -r "$folder/before" "$folder/$1"; }                          # fresh OUT: the run without worth

check "a run with providers" run value before --providers "$folder/providers.csv"
check "and one without" run value nameless
fresh run
before=$(head_of run)

# ---- Retrainings ---------------------------------------------------------------------------------------------------------

check "without retrainings worth is a score of the run" \
    prints '^worth without retrainings is its prior alone: (dv|lasting)_psnr, whose level is unknown' worth run
check "and changes nothing" test "$(head_of run)" = "$before"
check "24 retrainings" prints '^worth from 24 retrainings, 3 of them on all photos$' "$program" worth "$folder/run" --device llvmpipe \
    --no-thumbnails --retrainings 24
check "their price is told first" grep -qE '^24 trainings, about [0-9.]+ (s|min|h); Ctrl-C keeps what is done$' "$folder/stderr"
check "their accuracy is told" grep -qE '^ *([+-]?[0-9.]+ +){4}worth_psnr$' "$folder/stdout"
check "and that of the scores" grep -qE '^ *([+-]?[0-9.]+ +){3}- +dv_psnr$' "$folder/stdout"
check "and the noise" grep -qE '^noise    3 trainings on all photos differ by [0-9.]+ dB' "$folder/stdout"
check "the ledger has them, each with a seed of its own" test "$(query run 'SELECT count(*), count(DISTINCT seed), min(seed) > (SELECT seed
    FROM run), min(epochs), max(epochs) FROM retraining')" = '24|24|1|5|5'
check "every eighth is on all photos" test "$(query run "SELECT count(*) FROM retraining WHERE retraining % 8 = 0 AND
    image_ids = (SELECT group_concat(image_id, ' ') FROM image WHERE split = 'train')")" = 3
check "the run is intact" intact run
head24=$(head_of run)
cp "$folder/run/scores.csv" "$folder/scores24.csv"
check "every photo has a worth with an interval" test "$(query run "SELECT count(*), min(ci_low < value AND value < ci_high AND stderr > 0
    AND unit = 'dB') FROM score WHERE method = 'worth_psnr'")" = '6|1'
check "also in scores.csv" test "$(grep -c ',worth_psnr,.*,dB,' "$folder/run/scores.csv")" = 6
check "that of providers is the sum of their photos'" test "$(sqlite3 -cmd '.mode csv' -cmd ".import $folder/run/providers.csv t" \
    -cmd "ATTACH '$folder/run/ledger.db' AS run" :memory: "SELECT count(*), sum(abs(t.value - s.total) > 1e-9) FROM t JOIN (SELECT
    provider, sum(value) AS total FROM run.score JOIN run.image USING (image_id) WHERE method = 'worth_psnr' GROUP BY 1) AS s
    USING (provider) WHERE t.method = 'worth_psnr'")" = 3,0
check "the report has it" grep -q worth_psnr "$folder/run/report.html"
check "photos are selected by it" prints 'by worth_psnr: not-harmful' "$program" select "$folder/run" --method worth_psnr \
    --rule not-harmful --to "$folder/list.txt"
check "JSON says the same" run worth run --json
cp "$folder/stdout" "$folder/worth.json"
check "with the interval of the accuracy" test "$(sqlite3 :memory: "SELECT CAST(readfile('$folder/worth.json') AS TEXT) ->> '$.retrainings',
    json_array_length(CAST(readfile('$folder/worth.json') AS TEXT), '$.photos'),
    CAST(readfile('$folder/worth.json') AS TEXT) ->> '$.accuracy[0].method',
    (CAST(readfile('$folder/worth.json') AS TEXT) ->> '$.accuracy[0].ci_low') <=
    (CAST(readfile('$folder/worth.json') AS TEXT) ->> '$.accuracy[0].spearman')")" = '24|6|worth_psnr|1'

# ---- Names of providers --------------------------------------------------------------------------------------------------

scores_of() { query "$1" 'SELECT image_id, method, value, stderr, ci_low, ci_high FROM score'; } # scores_of OUT
check "more retrainings follow" run worth run --retrainings 32
# The same run without names of providers has the same retrainings, and the same worth of photos.
check "no names: the same retrainings" eval 'run worth nameless --retrainings 32 && [[ $(retrained nameless) == "$(retrained run)" ]]'
check "and the same worth" test "$(scores_of nameless)" = "$(scores_of run)"

# ---- Payouts -------------------------------------------------------------------------------------------------------------

rm -rf "$folder/swept" && cp -r "$folder/run" "$folder/swept"
check "retrainings that tell nobody apart pay nobody, and how more would is said" prints \
    '^payout of 100000.00: nobody is paid, since 32 retrainings tell no two photos apart; .*--retrainings 64 --payout 100000.00$' \
    worth swept --payout 100000
check "there is no table" test ! -e "$folder/swept/payout.csv"
check "nor an amount" test "$(grep -c '100000\|\[' <(sed -n '/^payout/,$p' "$folder/stdout"))" = 1
check "the backward pass of lasting credit keeps worth" run "$program" lasting "$folder/swept" --device llvmpipe --no-gate --quiet
check "which has it in its prior" prints ' lasting_psnr$' worth swept
check "and is intact" intact swept

# ---- Interruptions -------------------------------------------------------------------------------------------------------

fresh steps
check "8 retrainings" run worth steps --retrainings 8
check "and 16 more, on two devices" run "$program" worth "$folder/steps" --devices llvmpipe,llvmpipe --no-thumbnails --quiet \
    --retrainings 24
check "give the bits of 24 at once" test "$(head_of steps)" = "$head24"
fresh cut
interrupt() { # interrupts 24 retrainings after 9 at least, of which the ledger has 8 or 16
    local process
    (exec "$program" worth "$folder/cut" --device llvmpipe --no-thumbnails --quiet --retrainings 24) >"$folder/stdout" 2>"$folder/stderr" &
    process=$!
    until [[ $(sqlite3 -readonly "$folder/cut/retrainings.db" 'SELECT count(*) FROM retraining' 2>/dev/null || echo 0) -ge 9 ]]; do
        kill -CONT "$process" 2>/dev/null || return 1
        sleep 0.02
        kill -STOP "$process" 2>/dev/null
    done
    kill -INT "$process" && kill -CONT "$process"
    ! wait "$process" && grep -q 'interrupted; .* the same command resumes' "$folder/stderr"
}
check "an interrupted worth says how to go on" interrupt
check "and leaves a run that is intact" intact cut
check "with a table of the scores of its ledger" test "$(wc -l <"$folder/cut/scores.csv")" = "$(query cut 'SELECT 1 + count(*) FROM score')"
check "the same command goes on" run worth cut --retrainings 24
check "to the same bits" test "$(head_of cut)" = "$head24"
check "and the same table" cmp "$folder/cut/scores.csv" "$folder/scores24.csv"
rm "$folder/cut/report.html"
check "a report that a kill left out is made by the same command" eval 'run worth cut --retrainings 24 && [[ -e $folder/cut/report.html ]]'

# ---- In one command ------------------------------------------------------------------------------------------------------

check "value --retrainings" prints '^payout of 10.00: nobody is paid' value whole --providers "$folder/providers.csv" \
    --retrainings 24 --payout 10
check "makes the same retrainings" test "$(retrained whole)" = "$(retrained steps)"
check "it is intact" intact whole
check "one provider alone is paid by the same rule" prints '^payout of 6.00: nobody is paid' \
    value whole --providers "$folder/one.csv" --resume --payout 6
check "an accuracy that is not reached stops at the most" prints '^target   0.99 is not reached' \
    worth steps --retrainings 25 --until-confidence 0.99
check "after the last" test "$(query steps 'SELECT count(*) FROM retraining')" = 25
check "a run that is extended has no worth" run value whole --providers "$folder/providers.csv" --resume --epochs 6
check "since its retrainings are too short" test "$(query whole "SELECT (SELECT count(*) FROM retraining),
    (SELECT count(*) FROM score WHERE method = 'worth_psnr')")" = '0|0'

# ---- Edits and refusals --------------------------------------------------------------------------------------------------

sqlite3 "$folder/cut/ledger.db" 'UPDATE retraining SET val_psnr = val_psnr + 1 WHERE retraining = 3'
check "an edited retraining is found" fails 1 'a retraining row likewise' "$program" verify "$folder/cut" --quiet
check "more retrainings than there are subsets are refused" fails 2 '6 photos have only [0-9]+ subsets' worth run --retrainings 200
check "a run without scores is refused" eval 'run "$program" train "$scene" --out "$folder/trained" "${tiny[@]:0:14}" --quiet &&
    fails 2 "the run has no scores" worth trained --retrainings 8'
check "what cannot be paid or reached is refused before the run is trained" eval '
    fails 2 "payout takes an amount" value refused --retrainings 8 --payout abc &&
    fails 2 "until-confidence" value refused --retrainings 8 --until-confidence 1 && [[ ! -e $folder/refused/ledger.db ]]'
check "an accuracy of 1 is refused" fails 2 'until-confidence' worth run --retrainings 30 --until-confidence 1
conclude "$@"
