#!/usr/bin/env bash
# What a default run says of its own ranking, held against trainings of ten times the cost on scenes that are drawn for
# it: 95 % intervals of ranks contain the rank in the better training for at least 85 % of the photos, and the predicted
# agreement misses the true one by at most 0.3 in the mean (0.18 over 22 scenes). Takes the program's path. SEED=N draws other scenes.
# label: unsanitized
set -uo pipefail
. "$(dirname "$0")/../support/program_test.sh"
seed=${SEED:-20261128}
echo "seed $seed"

value() { # value SCENE NAME OPTION...
    "$program" value "$1" --out "$folder/$2" --pilot-steps 0 --effects unbounded --quiet --json "${@:3}" >"$folder/$2.json"
}
ranks() { # ranks NAME: photo|interval|interval|place
    query "$1" "SELECT image_id, rank_ci_low, rank_ci_high, rank() OVER (ORDER BY value DESC) FROM score
        WHERE method = 'dv_psnr' ORDER BY image_id"
}
contained() { # contained NAME: share of its intervals with the rank in NAME.better
    paste -d '|' <(ranks "$1") <(ranks "$1.better") |
        awk -F '|' '$1 != $5 {exit 1} {n++; inside += $8 >= $2 && $8 <= $3} END {if (n < 20) exit 1; print inside / n}'
}
agreement() { # agreement NAME: Spearman, by ranks without ties
    paste -d '|' <(ranks "$1") <(ranks "$1.better") |
        awk -F '|' '{n++; squares += ($4 - $8) ^ 2} END {print 1 - 6 * squares / (n * (n * n - 1))}'
}
predicted() {
    python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["verdict"]["ranking"]["better_training"])' \
        "$folder/$1.json" | grep -v None
}
mean_at_least() { awk -v limit="$1" '{sum += $1} END {print sum / NR; exit !(NR && sum / NR >= limit)}' "$2"; }
mean_at_most() { awk -v limit="$1" '{sum += $1} END {print sum / NR; exit !(NR && sum / NR <= limit)}' "$2"; }

check "scenes are drawn" run "$root/scripts/lab/draw_scenes" "$seed" 3 "$folder/scenes" captures
check "others with corrupted photos" run "$root/scripts/lab/draw_scenes" "$seed" 2 "$folder/scenes"
for scene in "$folder"/scenes/*.json; do
    name=$(basename "$scene" .json)
    check "$name is valued" value "$scene" "$name"
    check "$name is trained better" value "$scene" "$name.better" --accuracy reference
    check "$name has intervals" eval 'contained "$name" >>"$folder/contained"'
    check "$name predicts" eval 'told=$(predicted "$name")'
    true=$(agreement "$name")
    echo "$name: in the intervals $(tail -1 "$folder/contained"), predicted $told, true $true"
    awk -v told="$told" -v true="$true" 'BEGIN {print sqrt((told - true) ^ 2)}' >>"$folder/missed"
done
check "intervals contain ranks of better trainings" mean_at_least 0.85 "$folder/contained"
check "their agreement is predicted" mean_at_most 0.3 "$folder/missed"
conclude "$@"
