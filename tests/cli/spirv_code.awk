# Reads a disassembled SPIR-V module (spirv-dis --raw-id) and prints what its functions do, so that two modules with the same code print the
# same: ids inside functions by the order of their appearance, those outside (types, constants, buffers) by what they are. What no function
# refers to is not printed.

# What an id outside functions is, in words of its definition.
function meaning(id,    words, count, i, text) {
    if (id in told) return told[id]
    if (!(id in definition)) return id
    told[id] = "(recursive)"
    count = split(definition[id], words, " ")
    text = words[1]
    for (i = 2; i <= count; i++) text = text " " (words[i] ~ /^%/ ? meaning(words[i]) : words[i])
    return told[id] = "(" text decorations[id] ")"
}

function print_function_line(    i, text) {
    for (i = 1; i <= NF; i++) {
        if ($i !~ /^%/) text = text " " $i
        else if ($i in definition) text = text " " meaning($i)
        else {
            if (!($i in number)) number[$i] = ++last
            text = text " #" number[$i]
        }
    }
    print text
}

/^ *OpDecorate |^ *OpMemberDecorate / {
    id = $2
    $1 = $2 = ""
    decorations[id] = decorations[id] ";" $0
    next
}
/^ *OpExecutionMode / || /^ *OpCapability / { if (/ExecutionMode/) $2 = "main"; print; next }
$3 == "OpFunction" { inside = 1 }
inside { print_function_line(); next }
$2 == "=" {
    id = $1
    $1 = $2 = ""
    definition[id] = $0
}
