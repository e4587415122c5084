#!/usr/bin/env bash
# value --until-stable from outside: where it stops, that this is the same whatever interrupts it, and that it goes on. Takes the program's
# path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"

value() { # value OUT EPOCHS [OPTION]...: by the absolute loss, whose scores settle before the last of 40 epochs here
    "$program" value "$root/scenes/clean.json" --out "$folder/$1" --epochs "$2" --loss l1 "${small[@]}" --quiet "${@:3}"
}
steps() { query "$1" 'SELECT max(step) FROM step'; }
status() { query "$1" 'SELECT status FROM run'; }
refuses() { # refuses R: and leaves nothing
    fails 2 '--until-stable takes' value refused 20 --until-stable "$1" && [[ ! -e $folder/refused ]]
}
photos=12 # to train on, in clean.json

# The epochs that a run of 40 takes until its scores rank as half of them did.
wanted=0.85
check "a run that stops" run value stable 40 --until-stable "$wanted"
check "says so" says '^stable .* after epoch [0-9]+: .*wanted 0\.85\)'
epochs=$(($(steps stable) / photos))
check "at the end of an epoch" test "$((epochs * photos))" = "$(steps stable)"
check "after at least ten that count, and before the last ($epochs)" test "$epochs" -ge 11 -a "$epochs" -lt 40
check "as a finished run" test "$(status stable)" = finished
check "that is intact" eval '"$program" verify "$folder/stable" >/dev/null'
check "a run of so many epochs" run value plain "$epochs"
check "is the same, field and all" same_run plain stable

# Not earlier: the runs of all epochs before were not stable, by the same measure.
check "a run of one epoch less" run value less "$((epochs - 1))" --until-stable "$wanted"
check "is not stable" says '^not stable'
check "and goes on to where the other stopped" run value less 40 --until-stable "$wanted" --resume
check "with the same rows" same_run stable less

before=$(checksums stable)
check "the same command again" run value stable 40 --until-stable "$wanted" --resume
check "does nothing" test "$before" = "$(checksums stable)"

check "it goes on by --resume without the option" run value stable "$((epochs + 2))" --resume
check "a run of so many epochs" run value plain "$((epochs + 2))" --resume
check "is that run" same_run plain stable

check "as JSON" run value json 40 --until-stable "$wanted" --json
check "it tells the correlation" test "$(sqlite3 :memory: "
    WITH answer AS (SELECT CAST(readfile('$folder/stdout') AS TEXT) ->> '\$.stability' AS j)
    SELECT j ->> 'stable' = 1 AND j ->> 'correlation' >= $wanted AND j ->> 'epochs' = $epochs - 1
           AND j ->> 'earlier_epochs' = ($epochs - 1) / 2 AND j ->> 'wanted' = $wanted FROM answer")" = 1
check "too few epochs are never stable" run value few 10 --until-stable 0.01
check "and say so" says '^not stable: only 9 epochs count, and stability needs at least 10'
check "0 is to take all epochs" eval 'run value all 3 --until-stable 0 && ! grep -q stable "$folder/stdout" && [[ $(steps all) == 36 ]]'
for number in 1 1.5 -0.5 nan x; do check "--until-stable $number is refused" refuses "$number"; done
conclude "$@"
