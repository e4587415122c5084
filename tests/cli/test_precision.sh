#!/usr/bin/env bash
# --table-precision float32 costs nothing (design, decision 7): the passes that touch the grid have, in their usual form, the code of passes
# that know of no other. Takes the program's path. What the half form computes: build/test_passes update_grid_half and the other two.
# label: once
. "$(dirname "$0")/../support/program_test.sh"

command -v glslangValidator >/dev/null || { echo "SKIPPED: glslangValidator is missing; scripts/install_packages installs it"; exit 77; }
plain=$folder/shaders # what a reader of floats alone would have written
cp -r "$root/shaders" "$plain"
rm "$plain/field_hash/grid_pair.glsl"
sed -i -E '/grid_pair\.glsl/d; s/GRID_PAIR/vec2/g; s/(LOAD|STORE)_PAIR\(moved\)/moved/g; s/LOAD_PAIR\((grid\[[a-z]+\])\)/\1/g;
    s/STORE_PAIR\((.*)\);/\1;/' "$plain"/*/*.comp "$plain"/*/*.glsl "$plain"/*/*/*.comp

# compile FOLDER STEM OUT [ARGUMENT]...
compile() {
    printf '%s\n' '#version 460' '#extension GL_GOOGLE_include_directive : require' '#include "common.glsl"' \
        "#include \"$2.comp\"" >"$folder/pass.comp" # as CMakeLists.txt has it
    glslangValidator --quiet --target-env vulkan1.2 "-I$1" "${@:4}" -o "$3" "$folder/pass.comp"
}

same_code() {
    compile "$root/shaders" "$1" "$folder/usual.spv" && compile "$plain" "$1" "$folder/plain.spv" && cmp "$folder"/{usual,plain}.spv
}
other_code() { compile "$root/shaders" "$1" "$folder/half.spv" -DVW_HALF_GRID && ! cmp -s "$folder"/{usual,half}.spv; }

mapfile -t stems < <(sed -nE 's/^viewworth_add_shader\(([a-z_/]+) VARIANT half DEFINE VW_HALF_GRID\).*/\1/p' "$root/shaders/list.cmake")
check "four passes touch the grid" test "${stems[*]}" = \
    "effects/occupancy/refresh_occupancy field_hash/forward_field effects/pose/gradient_positions field_hash/update_grid"
check "the plain sources know of floats alone" \
    bash -c "! grep -q 'HALF_GRID\|_PAIR(' '$plain'/*/*.comp '$plain'/*/*/*.comp '$plain/field_hash/hash_grid.glsl'"
check "and no other pass includes what knows more" \
    test "$(cd "$root/shaders" && grep -l 'grid_pair\.glsl"' -- */*.comp */*.glsl */*/*.comp | wc -l)" -eq 4
for stem in "${stems[@]}"; do
    check "$stem on floats is as if there were no other form" same_code "$stem"
    check "$stem on halves is not" other_code "$stem"
done

# ---- From outside ---------------------------------------------------------------------------------------------------------

value() { "$program" value "$root/scenes/clean.json" --out "$folder/$1" --epochs 3 "${small[@]}" --quiet "${@:2}"; }
field_bytes() { stat -c %s "$folder/$1/field.vwf"; }
recorded() { query "$1" "SELECT json_extract(config_json, '\$.table_precision') FROM run"; }

check "a run on floats" run value floats --table-precision float32
check "says so" test "$(recorded floats)" = float32
check "a run on halves" run value halves --table-precision float16
check "says so" test "$(recorded halves)" = float16
check "and keeps a smaller field" test "$(field_bytes halves)" -lt $((3 * $(field_bytes floats) / 4))
check "which is rendered" run "$program" render "$folder/halves" --to "$folder/view.png" --quiet
check "its first steps come again" run "$program" verify "$folder/halves" --replay 5
check "it goes on with halves alone" fails 2 'table_precision = "float16", not "float32"' value halves --resume
check "and the other with floats" fails 2 'table_precision = "float32", not "float16"' value floats --resume --table-precision float16
cp "$folder/floats/field.vwf" "$folder/halves/field.vwf"
check "a field of the other precision is refused" fails 2 'field.vwf: trained with another configuration' \
    "$program" render "$folder/halves" --to "$folder/view.png" --quiet
check "a precision that there is not is refused" fails 2 '"float8" is not one of float32\|float16' value none --table-precision float8
check "the help knows both" prints '--table-precision float32\|float16$' "$program" value --help-all
conclude
