#!/usr/bin/env bash
# render --view: photos by a part of their name, the image's default name, and a folder of folds; and the format that info notes. Takes the
# program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"

refuses() { fails 2 "$1" "$program" "${@:2}" --quiet; } # refuses PATTERN ARGUMENT...

photos=(a/0001.png a/0007.png a/0020.png a/0021.png b/0007.png b/0030.png c/0007.png d/0007.png)
frames=()
for i in "${!photos[@]}"; do
    mkdir -p "$folder/scene/$(dirname "${photos[i]}")"
    write_photo "$folder/scene/${photos[i]}"
    frames+=("{\"file_path\": \"${photos[i]}\", \"transform_matrix\": [[1,0,0,$i],[0,1,0,0],[0,0,1,4],[0,0,0,1]]}")
done
(IFS=, && printf '{"fl_x": 8, "frames": [%s]}\n' "${frames[*]}") >"$folder/scene/transforms.json"
printf '%s\n' a/0001.png a/0020.png >"$folder/val.txt"
printf '%s\n' a/0007.png b/0007.png b/0030.png c/0007.png d/0007.png >"$folder/train.txt"
check "value gives a run" run "$program" value "$folder/scene" --out "$folder/out" "${small[@]}" --epochs 1 --val "$folder/val.txt" \
    --train "$folder/train.txt" --quiet

shows() { answers "j ->> '\$.view' = '$1' AND j ->> '\$.image' LIKE '%/$2'" "$program" render "$folder/out" --view "$3" --json --quiet; }
for name in 0030 0030.png b/0030 b/0030.png; do
    check "--view $name finds the photo" shows b/0030.png render_0030.png "$name"
done
check "a number is a place among the validation photos" shows a/0020.png render_0020.png 1
check "a number with a zero before it is a name first" shows a/0001.png render_0001.png 0001
check "and a place where no photo has it" shows a/0020.png render_0020.png 01
check "the image of a name that others have, too, is named in full" shows b/0007.png render_b_0007.png.png b/0007
check "a name that fits several is refused with the first three" \
    refuses '0007: is short for 4 photos: a/0007\.png, b/0007\.png, c/0007\.png, \.\.\.; write' render "$folder/out" --view 0007
check "the end of a name is none" refuses '--view 030: no photo' render "$folder/out" --view 030

# ---- Formats --------------------------------------------------------------------------------------------------------------

# Without a device, which would time steps.
info() { VK_DRIVER_FILES=/dev/null "$program" info "$folder/scene" "$@" 2>&1 || echo "read as nothing"; }
check "a scene that one format fits has no note on it" test "$(info | grep -c 'read as')" = 0
mkdir "$folder/scene/dense"
printf 'filename\tid\tsplit\tdataset\n' >"$folder/scene/list.tsv"
check "info says which format was taken, and which fits, too" \
    test "$(info | grep 'read as')" = 'note     read as transforms; --format phototourism fits, too'
check "but not after a choice" test "$(info --format transforms | grep -c 'read as')" = 0
conclude "$@"
