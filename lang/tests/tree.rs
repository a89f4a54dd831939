//! The tree is complete for every text, and nothing panics or hangs on the way.

use kinora_lang::diagnostic::{Style, render, render_short, to_json};
use kinora_lang::source::{FileId, Source};
use kinora_lang::syntax::{Tree, ast, parse, parse_value};

const HELLO: &str = include_str!("scenes/hello.kin");
const CORNELL: &str = include_str!("scenes/cornell.kin");
const DOMINOES: &str = include_str!("scenes/dominoes.kin");
const BROKEN: &str = include_str!("scenes/broken.kin");

/// Parses, lowers and renders: what holds for every text.
fn check(text: &str) -> Tree {
    let source = Source::new(FileId(0), "test.kin", text);
    let tree = parse(&source);
    let leaves: String = tree.root().tokens().map(|token| token.text()).collect();
    assert_eq!(leaves, text, "the leaves are not the text");
    assert!(error_nodes(&tree) == 0 || !tree.errors().is_empty(), "an error node is not reported: {text:?}");
    let mut lines = Vec::new();
    for error in tree.errors() {
        lines.push(error.place().map(|(_, span)| source.position(span.start).line));
        assert!(error.labels.iter().all(|label| label.span.end <= source.len()), "{error:?}");
    }
    assert!(
        lines.is_sorted() && lines.windows(2).all(|pair| pair[0] != pair[1]),
        "more than one error a line: {text:?}"
    );
    if let Some(error) = tree.errors().first() {
        let sources = [source.clone()];
        render(error, &sources, Style::default());
        render_short(error, &sources);
        to_json(tree.errors(), &sources, &sources);
    }
    tree
}

fn error_nodes(tree: &Tree) -> usize {
    tree.root().all().filter(|part| part.kind().is_error()).count()
}

#[test]
fn samples_have_no_error_node() {
    for text in [HELLO, CORNELL, DOMINOES] {
        let tree = check(text);
        assert_eq!(error_nodes(&tree), 0, "{text}");
        assert_eq!(tree.errors(), []);
        assert!(!tree.file().items.is_empty());
    }
}

#[test]
fn broken_has_eleven_error_nodes() {
    assert_eq!(error_nodes(&check(BROKEN)), 11);
}

/// Values written with every pair of brackets that precedence puts.
fn shape(expr: &ast::Expr) -> String {
    use ast::ExprKind::*;
    match &expr.kind {
        Missing => "?".to_string(),
        Number(number) => format!("{}{}", number.value, number.unit.as_ref().map_or("", |unit| &unit.name.text)),
        Path(path) => path.segments.iter().map(|name| &*name.text).collect::<Vec<_>>().join("."),
        Tuple(values) => format!("tuple({})", values.iter().map(shape).collect::<Vec<_>>().join(", ")),
        List(values) => format!("[{}]", values.iter().map(shape).collect::<Vec<_>>().join(", ")),
        Unary { op, value, .. } => format!("({}{})", if *op == ast::UnaryOp::Neg { "-" } else { "!" }, shape(value)),
        Binary { first, rest } => {
            rest.iter().fold(shape(first), |left, step| format!("({left} {} {})", step.op.text(), shape(&step.value)))
        }
        Call { callee, args } => {
            let arg = |arg: &ast::Arg| match &arg.name {
                Some(name) => format!("{}: {}", name.text, shape(&arg.value)),
                None => shape(&arg.value),
            };
            format!("{}({})", shape(callee), args.iter().map(arg).collect::<Vec<_>>().join(", "))
        }
        Field { base, name } => format!("{}.{}", shape(base), name.text),
        Index { base, index } => format!("{}[{}]", shape(base), shape(index)),
        If(value) => {
            let arms = value.arms.iter().map(|(condition, arm)| format!("if {} {{{}}} ", shape(condition), shape(arm)));
            format!("{}else {{{}}}", arms.collect::<String>(), shape(&value.otherwise))
        }
        Node(node) => format!("node {}", node.kind.segments[0].text),
        other => format!("{other:?}"),
    }
}

#[test]
fn precedence() {
    let check = |text: &str, expected: &str| {
        let (value, errors) = parse_value(&Source::new(FileId(0), "value", text));
        assert_eq!(errors, [], "{text}");
        assert_eq!(shape(&value), expected, "{text}");
    };
    check("1 + 2 * 3 - 4", "((1 + (2 * 3)) - 4)");
    check("a..b + 1", "(a .. (b + 1))");
    check("0..floor(n) ", "(0 .. floor(n))");
    check("a || b && c == d + e", "(a || (b && (c == (d + e))))");
    check("-a ^ 2", "(-(a ^ 2))");
    check("-2 ^ 2", "(-(2 ^ 2))");
    check("2 ^ -3 ^ 2", "(2 ^ (-(3 ^ 2)))");
    check("2 ^ 3 ^ 2", "(2 ^ (3 ^ 2))");
    check("2 ^ -1 * 4", "((2 ^ (-1)) * 4)");
    check("!a && --b < 3", "((!a) && ((-(-b)) < 3))");
    check("(a + b) * c", "((a + b) * c)");
    check("f(x, y: 2)[1].z.w", "f(x, y: 2)[1].z.w");
    check("-9.81m/s^2", "-9.81m/s^2");
    check("3m / s", "(3m / s)");
    check("3m/steps", "(3m / steps)");
    check("a < b && c >= d", "((a < b) && (c >= d))");
    check("a - b - c", "((a - b) - c)");
    check("a / b * c", "((a / b) * c)");
    check("if a < 1 { 2 } else if b { (1, 2) } else { red }", "if (a < 1) {2} if b {tuple(1, 2)} else {red}");
    check("metals.gold", "metals.gold");
    check("diffuse { color: red }", "node diffuse");
    check("[1, (2), ()]", "[1, 2, tuple()]");
}

/// A small generator of numbers that are the same in every run (splitmix64).
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((bits ^ (bits >> 31)) % limit.max(1) as u64) as usize
    }

    fn pick<'a>(&mut self, list: &[&'a str]) -> &'a str {
        list[self.below(list.len())]
    }
}

const TOKENS: &[&str] = &[
    "{", "}", "(", ")", "[", "]", ",", ";", ":", "=", "==", "..", ".", "->", "<", ">", "+", "-", "*", "/", "^", "!",
    "&&", "||", "%", "#", "#ff0000", "#12", "\"", "\"text\"", "\\", "//", "/*", "*/", "///", "\n", "\r\n", " ", "\t",
    "0", "1.5", "30deg", "3m/s^2", "1e400", "9px", "_", "a", "sphere", "a.b", "my-ball", "3rd", "let", "fn", "prefab",
    "for", "in", "if", "else", "elseif", "import", "from", "as", "param", "return", "keys", "ease", "after", "like",
    "lang", "true", "é", "“", "😀", "\u{202E}", "\0", "\u{FEFF}", "@", "'",
];

#[test]
fn every_prefix() {
    for text in [HELLO, CORNELL, DOMINOES, BROKEN] {
        for (end, _) in text.char_indices() {
            check(&text[..end]);
        }
    }
}

#[test]
fn mutations() {
    let mut random = Random(1);
    for _ in 0..1000 {
        let mut text = [HELLO, CORNELL, DOMINOES][random.below(3)].to_string();
        for _ in 0..=random.below(4) {
            let start = text.floor_char_boundary(random.below(text.len()));
            let end = text.floor_char_boundary(start + random.below(30));
            let piece = text[start..end.max(start)].to_string();
            match random.below(4) {
                0 => text.replace_range(start..start + piece.len(), ""),
                1 => text.insert_str(start, &piece),
                2 => text.insert_str(start, random.pick(TOKENS)),
                _ => text.replace_range(start..start + piece.len(), random.pick(TOKENS)),
            }
        }
        check(&text);
    }
}

#[test]
fn soups() {
    let mut random = Random(2);
    for _ in 0..3000 {
        let length = 1 + random.below(60);
        let text: String = (0..length).map(|_| [random.pick(TOKENS), random.pick(&["", " "])].concat()).collect();
        check(&text);
        drop(parse_value(&Source::new(FileId(0), "-D", text)));
    }
}

/// What nests or repeats without end, closed and not: no stack overflow, and the time grows with the length only.
#[test]
fn bombs() {
    let open = [
        "(",
        "[",
        "{",
        "a {",
        "a: a {",
        "a: (",
        "a: [",
        "f(x: ",
        "a: f(",
        "(a { ",
        "if ",
        "if a {",
        "let a = if a { ",
        "keys {",
        "a: keys { 0s: { ",
        "let a = [for i in ",
        "fn f(",
        "a: b[",
        "a like ",
        "import {",
        "/*",
        "/* */",
        "\"",
        "\"\\",
        "else if a { } ",
        "if a { } else ",
        "a: - ",
        "- ",
        "!",
        "a: 1 + ",
        "1 + ",
        "2 ^ ",
        "2 ^ -",
        "..",
        "a..",
        "a.",
        ".",
        "a < ",
        "let a: list<",
        "let a: b>",
        "a: b()",
        "()",
        "[0]",
        ".x",
        "x,",
        ",",
        ";",
        ":",
        "=",
        "a = ",
        "\n",
        "} ",
        ") ",
        "@",
        "@\n",
        "<1,",
        "a <1",
        "“",
        "1.",
        "a: #",
        "my-",
        "a\n",
        "{}",
        "a {} ",
        "\"{\n}\n",
        "\"(\n{ ( }\n",
    ];
    let start = ["", "let a = f", "a { b: ("];
    for start in start {
        for open in open {
            check(&format!("{start}{}", open.repeat(20)));
            check(&format!("{start}{}", open.repeat(2000)));
        }
    }
    for (open, close) in [("(", ")"), ("[", "]"), ("a { ", "}"), ("a: a { ", "}"), ("f(", ")"), ("(1 + ", ")")] {
        for depth in [100, 128, 129, 5000] {
            let tree = check(&format!("let x = {}1{}", open.repeat(depth), close.repeat(depth)));
            assert_eq!(tree.errors().iter().any(|error| error.code == "E0122"), depth > 128, "{open} {depth}");
        }
    }
}

#[test]
fn long_chains_are_no_nests() {
    let codes = |text: &str| check(text).errors().iter().map(|error| error.code).collect::<Vec<_>>();
    assert!(codes(&format!("let a = 1{}", " + 1".repeat(100_000))).is_empty());
    assert!(codes(&format!("let a = 1{}", " * 2 + 3".repeat(50_000))).is_empty());
    assert!(codes(&format!("let a = [{}]", "1, ".repeat(100_000))).is_empty());
    assert_eq!(codes(&format!("let a = {}1", "- ".repeat(100_000))), ["E0122"]);
    assert_eq!(codes(&format!("let a = 1{}", " ^ 2".repeat(100_000))), ["E0122"]);
    assert_eq!(codes(&format!("let a = f{}", "()".repeat(100_000))), ["E0122"]);
    assert_eq!(codes(&format!("let a = b{}", "[0]".repeat(100_000))), ["E0122"]);
}

#[test]
fn comments_and_docs() {
    let tree = check("/// one\n///  two\nparam a: float = 1 // not this\n\n// nor this\nparam b: float = 2\n");
    let docs = |item: &ast::Item| match item {
        ast::Item::Param(param) => param.docs.clone(),
        _ => None,
    };
    let file = tree.file();
    assert_eq!(docs(&file.items[0]).as_deref(), Some("one\n two"));
    assert_eq!(docs(&file.items[1]), None);
}

#[test]
fn line_breaks_and_mark_are_kept() {
    for text in ["\u{FEFF}lang 1\r\nsphere a { radius: 1 }\r\n", "lang 1\r", "// a\r\n", "\u{FEFF}"] {
        assert_eq!(check(text).errors(), [], "{text:?}");
    }
}

/// The value of `-D name=value`.
#[test]
fn single_values() {
    let check = |text: &str, expected: &[(&str, &str)]| {
        let (value, errors) = parse_value(&Source::new(FileId(0), "-D", text));
        let found: Vec<(&str, &str)> = errors.iter().map(|error| (error.code, error.message.as_str())).collect();
        assert_eq!(found, expected, "{text}");
        value
    };
    assert_eq!(shape(&check("50%", &[])), "50%");
    assert_eq!(shape(&check(" (1, 2m) ", &[])), "tuple(1, 2m)");
    assert_eq!(shape(&check("mix(a, b)", &[])), "mix(a, b)");
    assert!(check("", &[("E0108", "missing value")]).is_missing());
    check("1 2", &[("E0127", "unexpected `2` after the value")]);
    check("1, 2", &[("E0127", "unexpected `, 2` after the value")]);
    check("1 } a { b: 2 }", &[("E0127", "unexpected `} a { b: 2 }` after the value")]);
    check("30degrees", &[("E0305", "unknown unit `degrees`")]);
    check("a: 3", &[("E0108", "missing value")]);
    check("\"abc", &[("E0109", "unterminated string")]);
}
