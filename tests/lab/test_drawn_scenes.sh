#!/usr/bin/env bash
# Scenes drawn for the evaluation of methods (scripts/lab/draw_scenes): the same for a seed, of the kinds that it promises, and all of them
# open. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
command -v python3 >/dev/null || { echo "SKIPPED: python3 is missing; apt-get install python3"; exit 77; }
cd "$folder" || exit 1

draw() { "$root/scripts/lab/draw_scenes" "$@"; }
has_photos() { # has_photos SCENE: as many of each split as there should be
    local counts
    rm -rf "$folder/run"
    run "$program" train "$1" --out "$folder/run" --epochs 1 "${small[@]}" --quiet || return
    counts=$(query run "SELECT sum(split = 'train') BETWEEN 24 AND 40, sum(split = 'val'), sum(split = 'test') FROM image")
    [[ $counts == '1|8|8' ]] || { echo "$counts"; return 1; }
}

check "scenes are drawn" draw 7 4 first
check "again" draw 7 4 second
check "the same seed draws the same scenes" diff -r first second
check "another seed" draw 8 4 other
check "another seed draws other scenes" test "$(cat first/* other/* | sha256sum)" != "$(cat first/* first/* | sha256sum)"
check "every third one has no defects" test "$(grep -c '"defects"' first/*.json | grep -c ':0')" = 2
for scene in first/*.json; do check "$scene opens" has_photos "$scene"; done
check "captures are drawn, of as many photos as are asked for" draw 7 4 captures captures 50
for scene in captures/*.json; do
    check "$scene has them" test "$(sqlite3 :memory: "SELECT sum(value ->> '\$.count') FROM
        json_each(CAST(readfile('$scene') AS TEXT), '\$.cameras')")" = 50
done
check "nothing is overwritten" test "$(draw 7 4 first >/dev/null 2>&1; echo $?)" = 1
check "wrong words are refused" test "$(draw 7 many third 2>&1 | grep -c usage)" = 1
conclude "$@"
