#!/usr/bin/env bash
# value --accuracy and --budget from outside: what is chosen, that the time is kept, that a run goes on with what was chosen, and that the
# printed options give the same bits. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
photos=12 # to train on, in clean.json
tiny=(--rays 64 --samples 16 --importance-samples 0 --val-rays 64 --levels 4 --effects none --device llvmpipe)
# What a machine that does other work besides may add to a budget, and take from one: between its start and its first look at the clock,
# and from one look to the next, it may be slowed down at will.
allowance_s=4

value() { # value OUT [OPTION]...
    "${by:-$program}" value "$root/scenes/clean.json" --out "$folder/$1" --quiet "${@:2}"
}
steps() { query "$1" 'SELECT max(step) FROM step'; }
status() { query "$1" 'SELECT status FROM run'; }
config() { query "$1" "SELECT config_json ->> '\$.$2' FROM run"; }
again() { sed -n 's/^again    the same bits by //p' "$folder/stdout"; }
refuses() { # refuses PATTERN [OPTION]...: and leaves nothing
    fails 2 "$1" value refused "${@:2}" && [[ ! -e $folder/refused ]]
}

# ---- What cannot be ----------------------------------------------------------------------------------------------------------

check "a budget without a unit is refused with the remedy" refuses '"90" 90s or 90min' --budget 90
check "so is one that is too short" refuses '--budget takes' --budget 9s # test_budget_plan.c has other texts
check "an unknown accuracy is refused, with those there are" refuses '"best" is not one of draft, .*reference' --accuracy best
check "epochs that leave none to score are refused" refuses '--burn-in 1 to score; take more' --budget 90s --epochs 1
check "what a budget cannot buy is refused" refuses 'allow more time' --budget 10s --burn-in 50000 --epochs 60000 "${tiny[@]}"
check "train takes neither" fails 2 'unknown option "--budget"' "$program" train "$root/scenes/clean.json" --out "$folder/refused" \
    --budget 9h

check "splats take a budget" run value splats --field splats --budget 10s --epochs 2 --rays 256 \
    --splats 50 --effects none
check "over whose epochs the rate falls" test "$(config splats learning_rate_decay) $(config splats decay_epochs)" = '0.1 2'

# ---- An accuracy -------------------------------------------------------------------------------------------------------------

check "an accuracy, beside options before and after it" run value draft --epochs 2 --accuracy draft --rays 64 --effects none \
    --device llvmpipe
setting() { for key in rays samples importance_samples val_rays log2_table levels width epochs; do config "$1" $key; done | tr '\n' ' '; }
check "sets what is not given" test "$(setting draft)" = '64 8 8 1024 14 8 32 2 '
check "is recorded" test "$(query draft "SELECT plan_json ->> '\$.accuracy' FROM run")" = draft
read -ra options <<<"$(again)"
check "says what gives the same" run value plain_draft "${options[@]}" --effects none --device llvmpipe
check "which does" same_run draft plain_draft
check "without it none is recorded" test "$(query plain_draft "SELECT plan_json ->> '\$.accuracy' IS NULL FROM run")" = 1
before=$(checksums draft)
check "going on needs no --accuracy" run value draft --effects none --device llvmpipe --resume
check "and has nothing to do" test "$before" = "$(checksums draft)"
check "another accuracy is refused" fails 2 'another --accuracy' value draft --accuracy standard --effects none --resume
check "so is one for a run without" fails 2 'another --accuracy' value plain_draft --accuracy draft --effects none --resume
check "it is extended" run value draft --accuracy draft --epochs 3 --effects none --device llvmpipe --resume
check "by an epoch" test "$(steps draft)" = $((3 * photos))
query plain_draft "UPDATE run SET plan_json = '{\"accuracy\":\"draft\"}'"
check "an edited plan is found" fails 1 'run row' "$program" verify "$folder/plain_draft"

# ---- A budget ----------------------------------------------------------------------------------------------------------------

budget_s=10
kept() { # kept SECONDS: the last command took about as long as it was given; epochs are of a tenth of a second
    awk -v took="$1" -v budget="$budget_s" -v allowance="$allowance_s" \
        'BEGIN {exit !(took <= 1.1 * budget + allowance && took >= 0.9 * budget - allowance)}' || { echo "took $1 s"; return 1; }
}
timed() { # timed COMMAND...: keeps the seconds it took in $took
    local started=$EPOCHREALTIME code=0
    "$@" || code=$?
    took=$(awk -v a="$started" -v b="$EPOCHREALTIME" 'BEGIN {print b - a}')
    return "$code"
}
is_whole() { # is_whole OUT: a finished run of whole epochs, as its config says
    [[ $(status "$1") == finished && $(steps "$1") == $(($(config "$1" epochs) * photos)) && $(config "$1" epochs) -gt 1 ]]
}
check "a budget" timed run value timed --budget "${budget_s}s" "${tiny[@]}" --json
check "is kept" kept "$took"
check "at an epoch's end, and finished" is_whole timed
check "as JSON" test "$(sqlite3 :memory: "
    WITH answer AS (SELECT CAST(readfile('$folder/stdout') AS TEXT) ->> '\$.budget' AS j)
    SELECT j ->> 'budget_s' = $budget_s AND j ->> 'took_s' > 5 AND j ->> 'step_s' > 0 AND length(j ->> 'accuracy') > 0
           AND j ->> 'options' LIKE
               '%--rays 64 --samples 16 --importance-samples 0 --val-rays 64 % --epochs $(config timed epochs)%' FROM answer")" = 1
read -ra options <<<"$(sqlite3 :memory: "SELECT CAST(readfile('$folder/stdout') AS TEXT) ->> '\$.budget.options'")"
check "the report says what was chosen" grep -q '"budget_s": *10' "$folder/timed/report.html"
check "it is intact" eval '"$program" verify "$folder/timed" >/dev/null'
before=$(checksums timed)
check "the same command again" run value timed --budget "${budget_s}s" "${tiny[@]}" --resume
check "does nothing" test "$before" = "$(checksums timed)"
check "nor without --budget" eval 'run value timed "${tiny[@]}" --resume && [[ $before == "$(checksums timed)" ]]'
check "another budget is refused" fails 2 'another --accuracy or --budget' value timed --budget 1h "${tiny[@]}" --resume

if [[ -n ${VIEWWORTH_FULL:-} ]]; then
    check "the printed options for the one" run value plain_timed "${options[@]}" "${tiny[@]}"
    check "give the same, field and all" same_run timed plain_timed
    epochs=$(($(config timed epochs) + 2))
    check "by --epochs it is extended, whatever the time" run value timed --epochs "$epochs" "${tiny[@]}" --resume
    check "to so many" test "$(steps timed)" = $((epochs * photos))
fi
conclude "$@"
