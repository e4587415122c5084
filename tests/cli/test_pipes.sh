#!/usr/bin/env bash
# Pipes, devices and folders in the place of every file that is read: refused, or passed over, and never waited for. Takes the program's
# path.
. "$(dirname "$0")/../support/program_test.sh"
scene=$folder/scene
tiny=("${small[@]}" --epochs 2 --quiet)

# ends WHAT COMMAND...: by itself within 20 s, with exit code 1 or 2, nothing on stdout and one line on stderr.
ends() {
    local what=$1 code=0
    shift
    timeout 20 "$program" "$@" >"$folder/stdout" 2>"$folder/stderr" </dev/null || code=$?
    [[ $code -eq 1 || $code -eq 2 ]] && [[ ! -s $folder/stdout && $(wc -l <"$folder/stderr") -eq 1 ]] && return
    echo "$what: exit code $code"
    cat "$folder/stdout" "$folder/stderr"
    return 1
}

# ---- Scenes ---------------------------------------------------------------------------------------------------------------

check "a run to begin with" run "$program" value "$root/tests/support/tiny.json" --out "$folder/run" "${tiny[@]}"
reset() { # three photos, a COLMAP model, a TSV and masks
    local i
    rm -rf "$scene"
    mkdir -p "$scene/images" "$scene/masks" "$scene/sparse/0" "$scene/dense/sparse" "$scene/dense/images"
    for i in 0 1 2; do cp "$folder/photo.png" "$scene/images/$i.png" && cp "$folder/photo.png" "$scene/masks/$i.png"; done
    cp "$folder/photo.png" "$scene/dense/images/0.png"
    printf '{"fl_x": 8, "frames": [{"file_path": "images/0.png", "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]}' \
        >"$scene/transforms.json"
    printf '1 PINHOLE 8 6 8 8 4 3\n' >"$scene/sparse/0/cameras.txt"
    printf '1 1 0 0 0 0 0 0 1 0.png\n\n' >"$scene/sparse/0/images.txt"
    : >"$scene/sparse/0/points3D.txt"
    cp "$scene"/sparse/0/* "$scene/dense/sparse/"
    printf 'filename\tid\tsplit\n0.png\t1\ttrain\n' >"$scene/splits.tsv"
}
write_photo "$folder/photo.png"

# instead WHAT FILE: FILE becomes WHAT.
instead() {
    rm -rf "$2"
    case $1 in
    pipe) mkfifo "$2" ;;
    device) ln -s /dev/zero "$2" ;; # a link leads out of the scene, too; to make a device takes rights
    folder) mkdir "$2" ;;
    esac
}
for what in pipe device folder; do
    while read -r file format; do
        reset
        instead "$what" "$scene/$file"
        check "a $what for $file" ends "$file" info "$scene" --format "$format" "${small[@]: -2}" --quiet
    done <<'FILES'
transforms.json transforms
images/0.png transforms
masks/0.png transforms
sparse/0/cameras.txt colmap
sparse/0/images.txt colmap
sparse/0/points3D.txt colmap
splits.tsv phototourism
dense/sparse/images.txt phototourism
dense/images/0.png phototourism
FILES
done

# ---- Files that the user names ----------------------------------------------------------------------------------------------

mkfifo "$folder/pipe"
for file in "$folder/pipe" /dev/zero "$folder"; do
    for option in --train --val --test --splits --providers; do
        check "$option ${file##*/}" ends "$option" info "$root/tests/support/tiny.json" "$option" "$file" --quiet --device llvmpipe
    done
    check "a recipe ${file##*/}" ends recipe info "$file" --format recipe --quiet --device llvmpipe
    check "a log ${file##*/}" ends log import-steps "$file" --out "$folder/imported"
    check "which leaves nothing" test ! -e "$folder/imported"
done

# ---- Results ----------------------------------------------------------------------------------------------------------------

for what in pipe device folder; do
    for name in ledger.db field.vwf; do
        rm -rf "$folder/copy" && cp -r "$folder/run" "$folder/copy"
        instead "$what" "$folder/copy/$name"
        check "a $what for $name" ends "$name" render "$folder/copy" --quiet --device llvmpipe
    done
    rm -rf "$folder/copy" && cp -r "$folder/run" "$folder/copy"
    instead "$what" "$folder/copy/ledger.db"
    for command in verify report; do
        check "$command, a $what for ledger.db" ends "$command" "$command" "$folder/copy" --quiet
    done
    for name in compare.json benchmark.csv; do
        rm -rf "$folder/copy" && mkdir "$folder/copy"
        instead "$what" "$folder/copy/$name"
        check "a $what for $name" ends "$name" report "$folder/copy" --quiet
    done
done
conclude
