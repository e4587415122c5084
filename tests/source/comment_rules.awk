# Prints every comment that breaks the rules of src/README.md, as "FILE:LINE: RULE: TEXT".
# awk -f tests/source/comment_rules.awk FILE...     (C, C++, GLSL and JavaScript)
#
# opener: a comment begins with a word that makes it a fragment about the name below it (What, Of, From, For, ...).
# verb: the comment directly above a function does not begin with a verb in the third person, a word that ends in "s".
# words: a comment or a text in quotes has a pattern that is not English ("is no X", "by itself", "in the mean", ...).

function report(line, rule, text) {
    print name ":" line ": " rule ": " substr(text, 1, 110)
    broken = 1
}

# Words that end in "s" without being a verb, and verbs that do not end in "s", at the start of a comment.
function is_verb(text,   first, second) {
    split(text, word, " ")
    first = word[1]
    second = word[2]
    if (first ~ /^(This|Its|As|Always|Thus|Unless|Less|Plus|Across|Others|Is|Was|Has|Does|Views|Photos|Steps|Rows)$/) return 0
    if (second ~ /^(of|are|whose|were|have)$/) return 0 # a noun in the plural
    return first ~ /^[A-Z][a-z-]*s,?$/
}

function check_opener(line, text) {
    if (text ~ /^(What|Whether|Of|Those|Whose|Beside|Where|That which|For what|For which|How|Which|Who) /) report(line, "opener", text)
    else if (text ~ /^(what|of|those|whose|beside|for what|that which) /) report(line, "opener", text)
    else if (text ~ /^(From|By|As|To|For) /) report(line, "opener", text)
    else if (text ~ /[.] (Of|Whose|Beside) [^,]*[.] *$/) report(line, "opener", text)
}

function check_words(line, text,   low) {
    low = " " tolower(text) " "
    gsub(/(every|any|no|some)thing else|who else|or else|everywhere else/, "", low)
    gsub(/there is no |there are no |(is|are) no (longer|more|less|later|larger|smaller|worse|better|way|need)/, "", low)
    gsub(/behind (the |a |its |every |one |an |this |all )?(transparent )?(camera|object|box|wall|lens|pixel|sample|scene)/, "", low)
    if (low ~ / (is|are|was|were|be) no [a-z]/) report(line, "words (is no)", text)
    if (low ~ / behind /) report(line, "words (behind)", text)
    if (low ~ / by (itself|themselves)[ .,;:]/) report(line, "words (by itself)", text)
    if (low ~ / in the mean[ .,;:]/) report(line, "words (in the mean)", text)
    if (low ~ / as far as /) report(line, "words (as far as)", text)
    if (low ~ / else[.;:]? *$/ || low ~ / else[.;:] /) report(line, "words (else)", text)
    if (low ~ / beyond all numbers| from which on | from then on what | where there are none/) report(line, "words (idiom)", text)
}

# A function at the start of a line: a parenthesis before any "=", "{" or ";", and not a macro, a type or an assertion.
function is_function(line) {
    if (line !~ /^[A-Za-z_]/ || line ~ /^(typedef|layout|_Static_assert|extern "C"|union \{|shared )/) return 0
    return line ~ /^[A-Za-z_][A-Za-z0-9_ *]*[ *][A-Za-z_][A-Za-z0-9_]*\(/
}

function end_block(next_line) {
    if (block == "") return
    if (block !~ /^(----|clang-format|NOLINT)/) {
        check_opener(block_line, block)
        if (is_function(next_line) && !is_verb(block)) report(block_line, "verb", block)
        check_words(block_line, block)
    }
    block = ""
}

# The texts in quotes of a line of code.
function check_strings(line, code,   text) {
    if (code ~ /^ *# *include/) return
    while (match(code, /"([^"\\]|\\.)*"/)) {
        text = substr(code, RSTART + 1, RLENGTH - 2)
        if (text ~ / /) check_words(line, text)
        code = substr(code, RSTART + RLENGTH)
    }
}

FNR == 1 {
    end_block("")
    name = FILENAME
    sub(/^\.\//, "", name)
}

/^ *\/\/ ?/ {
    text = $0
    sub(/^ *\/\/ ?/, "", text)
    if (block == "") {
        block_line = FNR
        block = text
    } else block = block " " text
    next
}

{
    end_block($0)
    code = $0
    trailing = match(code, / \/\/ /) ? substr(code, RSTART + 4) : ""
    if (trailing != "") {
        code = substr(code, 1, RSTART - 1)
        check_opener(FNR, trailing)
        check_words(FNR, trailing)
    }
    check_strings(FNR, code)
}

END {
    end_block("")
    exit broken
}
