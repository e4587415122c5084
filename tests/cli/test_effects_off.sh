#!/usr/bin/env bash
# An effect that is off costs nothing (decision 7 of src/README.md): every shader, specialised with the effect off and optimised, has the
# same code as one from which the effect is compiled out. Loops over the effects that the program lists and the shaders in
# shaders/list.cmake.
# test_effects_off.sh PROGRAM [EFFECT]...: these alone. Skipped while shaders and effects are as they were when it last passed.
# In the second form the switch is no specialization constant but 0, and VW_WITHOUT_<EFFECT> is defined for what else wants to be left out.
# label: unsanitized
set -uo pipefail
program=$(realpath "$1")
cd "$(dirname "$0")/../.."
. tests/support/shell_test.sh

for tool in glslangValidator spirv-opt spirv-dis; do
    command -v "$tool" >/dev/null || { echo "SKIPPED: $tool is missing; scripts/install_packages installs it"; exit 77; }
done

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

list_effects() { # in the registry's order, as a message has them
    "$program" train scenes/clean.json --out "$work/none" --effects none-such --quiet 2>&1 | sed -n 's/.*; known are: //p' | tr ' ' '\n'
}
list_effects >"$work/effects"

# What the comparison depends on. Chosen effects are always compared.
if [[ $# -eq 1 ]]; then
    spirv-opt --version >"$work/tool"
    # shellcheck disable=SC2046
    skip_unchanged "$(dirname "$program")/test_effects_off.passed" tests/cli/test_effects_off.sh tests/cli/spirv_code.awk \
        "$work/tool" "$work/effects" $(find shaders -type f | sort)
fi

mapfile -t effects <"$work/effects"
# "stem define" of every shader.
mapfile -t shaders < <(sed -nE 's/^viewworth_add_shader\(([a-z_/]+)( VARIANT [a-z]+ DEFINE ([A-Z_]+))?\).*/\1 \3/p' shaders/list.cmake)

# The constant id of an effect's switch; nothing for one that the host does alone.
constant_of() {
    sed -nE "s/^ *X\(([0-9]+), EFFECT_${1^^}, .*/\1/p" shaders/interface.h
}

# compile SHADERS_FOLDER SHADER OUT [ARGUMENT]...
compile() {
    local folder=$1 stem=${2% *} define=${2#* } out=$3
    printf '%s\n' '#version 460' '#extension GL_GOOGLE_include_directive : require' '#include "common.glsl"' \
        "#include \"$stem.comp\"" >"$out.comp" # as CMakeLists.txt has it
    glslangValidator --quiet --target-env vulkan1.2 "-I$folder" ${define:+"-D$define"} "${@:4}" -o "$out" "$out.comp"
}

# text IN OUT: the code of a module as text.
text() { spirv-dis --raw-id --no-header "$1" | awk -f tests/cli/spirv_code.awk >"$2"; }

# Optimisation. The simple one is a hundred times as fast, and enough for nearly all: what it makes equal, the full one does, too.
simple="--eliminate-dead-branches --merge-blocks --eliminate-dead-functions --eliminate-dead-const --eliminate-dead-code-aggressive"
full=-O

# code OPTIMISATION IN OUT [ID:VALUE]...: the same, specialised with these values (the others have their defaults) and optimised.
code() {
    # shellcheck disable=SC2086
    spirv-opt --strip-debug --set-spec-const-default-value="${*:4}" --freeze-spec-const --fold-spec-const-op-composite $1 \
        "$2" -o "$2.opt" && text "$2.opt" "$3"
}

# A copy of the shaders without the effect.
without() {
    local folder=$1 upper=EFFECT_${2^^}
    cp -r shaders "$folder"
    sed -i -E "/^ *X\([0-9]+, $upper, /d; s/^VW_SPECIALIZATION\(VW_DECLARE_CONSTANT\)/&\nconst uint $upper = 0u;/" "$folder/interface.h"
}

# Values of the other constants: training with all other effects on; with --full also without them, and both for validation.
settings_for() {
    local others="" other id
    for other in "${effects[@]}"; do
        id=$(constant_of "$other")
        [[ -n $id && $other != "$1" ]] && others+=" $id:1"
    done
    echo "6:1$others"
    [[ -z ${VIEWWORTH_FULL:-} ]] || printf '%s\n' "6:1" "6:0" "6:0$others"
}

# compiled SHADER: the shader as it is, compiled once for all effects: leaves $whole.spv and $whole.txt.
compiled() {
    whole="$work/whole ${1//[ \/]/-}"
    [[ -s $whole.txt ]] || { compile shaders "$1" "$whole.spv" && text "$whole.spv" "$whole.txt"; }
}

# knows EFFECT: whether the code of $whole depends on the effect's switch, or any source asks whether there is the effect at all. Where
# neither is so, the second form differs by a declaration that nothing refers to.
knows() {
    grep -qE "SpecId $(constant_of "$1")\b" "$whole.txt" || grep -rq "VW_WITHOUT_${1^^}" shaders
}

# equal OPTIMISATION: whether $whole and $work/without.spv have the same code with that setting, if they have any.
equal() {
    : >"$work/difference"
    # shellcheck disable=SC2086
    code "$1" "$whole.spv" "$work/with.txt" "$id:0" $setting && code "$1" "$work/without.spv" "$work/without.txt" $setting &&
        [[ -s $work/with.txt ]] && diff "$work/with.txt" "$work/without.txt" >"$work/difference"
}

# same_code EFFECT SHADER: compares all settings; says which differs.
same_code() {
    local effect=$1 shader=$2 id setting whole
    id=$(constant_of "$effect")
    compiled "$shader" && [[ -s $whole.txt ]] || return 1
    knows "$effect" || return 0
    known=$((known + 1))
    compile "$work/$effect" "$shader" "$work/without.spv" "-DVW_WITHOUT_${effect^^}" || return 1
    while read -r setting; do
        equal "$simple" || equal "$full" && continue
        [[ -s $work/with.txt ]] && echo "differs with $id:0 $setting:" || echo "no code came out"
        head -20 "$work/difference" | cut -c1-200
        return 1
    done < <(settings_for "$effect")
}

# So that the comparison itself is no empty one: an effect that is on changes the code of the pass that it is in.
sees_a_difference() {
    compile shaders "rays/composite_rays " "$work/with.spv" && code "$full" "$work/with.spv" "$work/off.txt" 17:0 &&
        code "$full" "$work/with.spv" "$work/on.txt" 17:1 18:0.5 && ! cmp -s "$work/off.txt" "$work/on.txt"
}

check "the program lists effects" test "${#effects[@]}" -ge 8
check "shaders are listed" test "${#shaders[@]}" -ge 17
check "every switch in the interface is an effect's" test \
    "$(grep -cE '^ *X\([0-9]+, EFFECT_' shaders/interface.h)" = "$(for e in "${effects[@]}"; do constant_of "$e"; done | wc -l)"
check "the comparison sees an effect that is on" sees_a_difference
chosen=("${@:2}")
[[ $# -gt 1 ]] || chosen=("${effects[@]}")
for effect in "${chosen[@]}"; do
    if [[ -z $(constant_of "$effect") ]]; then
        check "$effect: no shader knows it" test -z "$(grep -rliE "EFFECT_$effect" shaders)"
        continue
    fi
    without "$work/$effect" "$effect"
    known=0
    for shader in "${shaders[@]}"; do check "$effect off: $shader" same_code "$effect" "$shader"; done
    check "some shader knows $effect" test "$known" -ge 1
done
conclude
