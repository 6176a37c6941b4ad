//! E012x and E013x: files and directives (genom3.md section 1).

use super::row::{Explanation, row};

pub(super) const ROWS: &[Explanation] = &[
    row(
        "E0120",
        "1.1",
        "an input file cannot be read",
        "It does not exist, is a directory, a FIFO or a device, or the system refuses to open it.",
        "",
    ),
    row(
        "E0121",
        "1.2",
        "an included file is not found",
        "`\"file\"` is looked for beside the including file, then like `<file>`: in the \
         directories given with `-I`, in order, then in those of `#pragma requires`. There is \
         no default directory.",
        "#include \"nowhere.gen\"",
    ),
    row(
        "E0122",
        "",
        "files include each other without end",
        "Write `#pragma once`, or `#ifndef`/`#define`/`#endif` guards.",
        "",
    ),
    row(
        "E0123",
        "1.2",
        "a directive is malformed",
        "The message says what the directive wants.",
        "#include types.gen",
    ),
    row(
        "E0124",
        "1.2",
        "a macro definition is malformed",
        "`#define NAME text` or `#define NAME(a, b, ...) text`, without a blank before the \
         parenthesis.",
        "#define max(a, b",
    ),
    row(
        "E0125",
        "1.2",
        "a macro is used with wrong arguments",
        "A macro takes as many arguments as it has parameters, between parentheses that close.",
        "#define square(x) x * x\nconst long n = square(2, 3);",
    ),
    row(
        "E0126",
        "1.2",
        "`##` makes no token",
        "What `##` glues must be one name, number or sign.",
        "#define glue(a, b) a##b\nconst long n = glue(x, \"y\");",
    ),
    row(
        "E0127",
        "",
        "macros expand without measure",
        "Expansion stops at about a million tokens, at 16 MiB of text and at a hundred \
         arguments inside each other.",
        "",
    ),
    row(
        "E0128",
        "1.2",
        "a condition cannot be evaluated",
        "`#if` takes integers, the operators of C, macros and `defined NAME`.",
        "#if 1 +\n#endif",
    ),
    row(
        "E0129",
        "1.2",
        "conditions are not balanced",
        "Each `#if`, `#ifdef` and `#ifndef` is closed by one `#endif` in the same file.",
        "#if 1\ncomponent demo;",
    ),
    row(
        "E0130",
        "1.2",
        "the description says `#error`",
        "Whoever wrote the description wants it refused here: read the message.",
        "#error define ROBOT first",
    ),
    row(
        "E0131",
        "1.3",
        "a required package is not found",
        "`#pragma requires` asks pkg-config where the .gen files of a package are. Install the \
         package, add its directory to PKG_CONFIG_PATH, or say where the files are with `-I`: \
         then a missing package is a warning.",
        "#pragma requires \"no-such-package >= 1.0\"",
    ),
    row(
        "E0132",
        "1.3",
        "a pragma is malformed",
        "`#pragma requires \"package\" ...`, `#pragma provides interface ...`, `#pragma \
         masquerade middleware type data`.",
        "#pragma requires",
    ),
    row(
        "E0133",
        "",
        "the text is too large",
        "The files of a description have at most 16 MiB in all. With macros expanded and all \
         that is included it has at most a million words and signs, and 32 MiB.",
        "",
    ),
];
