#!/usr/bin/env bash
# Runs of `--field splats` from outside: the same bits on any number of threads, after a kill and by trainings together; what is left is
# verified, rendered and swept; other points are another run; what splats cannot have is refused by name. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
splats=(--field splats --rays 256 --val-rays 512 --splats 200 --effects none --device llvmpipe --quiet)

value() { (exec_value "$@"); } # value OUT EPOCHS [OPTION]...
exec_value() { exec "$program" value "$scene" --out "$folder/$1" --epochs "$2" "${splats[@]}" "${@:3}"; } # signals reach it
on_threads() { LP_NUM_THREADS=$1 "${@:2}"; }

# ---- The same bits ----

check "a run without interruption" run value whole 60
check "on one thread" run on_threads 1 value one 60
check "has the same bits" same_run whole one
check "on two threads" run on_threads 2 value two 60
check "has the same bits" same_run whole two
kills=0
for part in 4 3 2; do # each time further on
    (exec_value killed 60 --resume) >"$folder/stdout" 2>"$folder/stderr" &
    until [[ $(sqlite3 -readonly "$folder/killed/ledger.db" 'SELECT count(*) FROM step' 2>/dev/null || echo 0) -ge $((360 / part)) ]]; do
        kill -0 $! 2>/dev/null || break
        sleep 0.02
    done
    kill -KILL $! && kills=$((kills + 1))
    wait $! 2>/dev/null
done
check "is killed three times" test "$kills" = 3
check "and resumed" run value killed 60 --resume
check "has the same bits" same_run whole killed
check "a run whose rates stay" run value extended 4 --learning-rate-decay 1
check "is extended" run value extended 8 --learning-rate-decay 1 --resume
check "a longer one" run value longer 8 --learning-rate-decay 1
check "is the extended one" same_run longer extended

# What trainings leave, by their photos and seed.
trainings() {
    sqlite3 "$folder/$1/retrainings.db" 'SELECT views, seed, epochs, val_psnr, test_psnr, val_l1 FROM retraining ORDER BY 1, 2, 3'
}
worth() { run "$program" worth "$folder/$1" --retrainings 4 --together "$2" --device llvmpipe --quiet; }
cp -r "$folder/longer" "$folder/alone"
cp -r "$folder/longer" "$folder/together"
check "retrainings one by one" worth alone 1
check "three at a time" worth together 3
check "are the same" diff <(trainings alone) <(trainings together)
check "and there are some" test "$(trainings alone | wc -l)" -ge 4

# ---- What is left ----

check "a run is verified and its steps taken again" run "$program" verify "$folder/whole" --replay 4000000000
check "to the last one" grep -q '^replay   360 repeated steps gave the same bits' "$folder/stdout"
check "a run with a share of SSIM" run value ssim 3 --ssim-weight 0.2
check "is replayed" run "$program" verify "$folder/ssim" --replay 4000000000
check "a view is rendered" run "$program" render "$folder/whole" --device llvmpipe
check "with the field's PSNR" grep -q 'PSNR' "$folder/stdout"
check "a sweep" run "$program" tradeoff "$scene" --out "$folder/sweep" --seeds 2 --epochs 4 \
    --parameters rays,samples,width,epochs "${splats[@]}"
check "of what splats have" test "$(cd "$folder/sweep/configurations" && echo *)" = "base epochs-2 epochs-8 full_resolution rays-512"

# ---- What is another run ----

write_model() { # write_model POINT...: a COLMAP model of five photos, and these lines of points
    local i
    mkdir -p "$folder/model/sparse" "$folder/model/images"
    echo '1 PINHOLE 8 6 9 9 4 3' >"$folder/model/sparse/cameras.txt"
    for i in 1 2 3 4 5 6; do
        write_photo "$folder/model/images/$i.png"
        printf '%s 1 0 0 0 0.%s 0 5 1 %s.png\n%s\n' "$i" "$i" "$i" "3 3 7 4 4 8"
    done >"$folder/model/sparse/images.txt"
    printf '%s\n' "$@" >"$folder/model/sparse/points3D.txt"
}
first='7 0.1 0 0 200 10 10 0.5 2 0 3 0 4 0' second='8 0 0.2 0 10 200 10 0.5 2 1 3 1 4 1'
model() { "$program" value "$folder/model" --out "$folder/model_out" --epochs "$1" "${splats[@]}" --learning-rate-decay 1 --resume; }
write_model "$first" "$second"
check "a run on points" run model 3
write_model "$first" "${second/0 0.2 0/0 0.3 0}"
check "does not go on with another points file" fails 2 'another scene, or one that has changed since' model 4
check "nor is it replayed with it" fails 2 'no longer the scene that' \
    "$program" verify "$folder/model_out" --replay 3 --quiet
write_model "$first" "$second"
check "with its own it goes on" run model 4

# ---- What is refused ----

for effect in unbounded wide_box appearance_code visibility transient pose appearance_encoder; do
    check "$effect is refused by name" fails 2 "--effects: .*$effect" value refused 2 --effects "$effect"
done
check "rays that are no squares are refused" fails 2 '--rays: a multiple of 256' value refused 2 --rays 300
check "so are samples" fails 2 '--samples: needs --field hash or mlp, not splats' value refused 2 --samples 24
check "SSIM is refused without splats" fails 2 '--ssim-weight: needs --field splats, not hash' \
    value refused 2 --field hash --ssim-weight 0.2
check "and lasting credit" fails 2 'cannot go back through splats' value refused 2 --lasting
check "more splats than can be" fails 2 '--splats' value refused 2 --splats 1048577
check "nothing is left of them" test ! -e "$folder/refused/ledger.db"
conclude "$@"
