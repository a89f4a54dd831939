//! Writes docs/reference.md from the tables that the program reads. `UPDATE_EXPECT=1` writes it anew.

use std::fmt::Write;
use std::path::Path;

use kinora_lang::builtin::{self, BUILTINS, Topic, ease};
use kinora_lang::dimension::{Dimension, UNITS, show};
use kinora_lang::eval::expr::spaced;
use kinora_lang::eval::limits;
use kinora_lang::files::MAX_ASSET_BYTES;
use kinora_lang::schema::{KINDS, Kind, MIX, Place, Property, Since, Sort, TYPES};
use kinora_lang::source::MAX_SOURCE_BYTES;
use kinora_lang::syntax::MAX_NESTING;
use kinora_scene::Spectrum;

#[test]
fn page() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/reference.md");
    let page = reference();
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        std::fs::write(&path, &page).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default().replace("\r\n", "\n");
    let line = page.lines().zip(found.lines()).find(|(new, old)| new != old);
    assert!(page == found, "docs/reference.md is out of step, UPDATE_EXPECT=1 writes it anew: {line:?}");
}

fn reference() -> String {
    let mut page = String::from(HEAD);
    page += "\n## Types\n\nOf `param`, `let`, functions and prefabs.\n\n| type | values |\n|---|---|\n";
    for row in TYPES {
        writeln!(page, "| `{}` | {} |", row.name, row.doc).unwrap();
    }
    page += UNITS_HEAD;
    units(&mut page);
    for (title, about, sorts) in SECTIONS {
        write!(page, "\n## {title}\n\n{about}\n").unwrap();
        let kinds: Vec<&Kind> = KINDS.iter().filter(|kind| sorts.contains(&kind.sort)).collect();
        let shared = shared(&kinds);
        table(&mut page, shared.iter().copied());
        let mixed = sorts.contains(&Sort::Material).then_some(&MIX);
        for kind in kinds.into_iter().chain(mixed) {
            describe(&mut page, kind, &shared);
        }
    }
    functions(&mut page);
    easing(&mut page);
    write!(
        page,
        "\n## Measured metals\n\nFor `spectrum`: {}.\n",
        list(Spectrum::ALL.iter().map(|metal| metal.symbol()))
    )
    .unwrap();
    the_limits(&mut page);
    page
}

const HEAD: &str = "# Reference

Everything that can be said, written by a test from the tables that the program itself reads. How it is said, and why, is in
[language.md](language.md); what it looks like in [materials.md](materials.md), [lights.md](lights.md),
[shapes.md](shapes.md) and [cameras.md](cameras.md).

## Forms

What stands in `[ ]` may be left out. `,` and `;` between items, and at the end of lists, are optional.

| form | what it is |
|---|---|
| `lang 1` | the first line: the version of the language |
| `import \"x.kin\" as x` · `import { a, b as c } from \"x.kin\"` | names of another file; before everything else |
| `kind [name] { .. }` | a node: properties, nodes, `let`, `for`, `if` |
| `kind [name] like other { .. }` | a copy of a node, with some properties changed |
| `name: value` | a property |
| `param name[: type] = value [in low..high]` | a value that `-D name=value` and the viewer can set |
| `let name[: type] = value` | a name for a value |
| `fn name(a[: type] [= value], ..) [-> type] = value` · `{ let .. if .. return value }` | a function |
| `prefab name(a[: type] [= value], ..) { .. }` | a kind of your own |
| `for i in list { .. }` · `for i, item in list { .. }` | once for each item of a list or range |
| `if condition { .. } [else if condition { .. }] [else { .. }]` | a choice of items |
| `if condition { value } else { value }` | a choice of values |
| `keys[(interpolate: .., outside: .., space: ..)] { time: value [ease curve] .. }` | a value over time; `after 1s:` counts from the key before; `interpolate: eased`, `linear`, `step`, `spline`, `hermite` (keys `{ value, in, out }`); `outside: hold`, `loop`, `pingpong`, `extend`, `error`; `space: linear`, `oklch` |
| `[a, b]` · `[for i in list [if condition]: value]` | a list |
| `(a, b)` | a vector, where all are numbers |
| `a..b` | a range of whole numbers, b left out |
| `f(a, name: b)` · `v.xy` · `list[i]` · `module.name` | a call, a field, an item, a name of another file |
| `// ..` · `/* .. */` · `/// ..` | comments; three strokes describe the declaration below |

Literals: `12`, `1_000`, `0.5`, `1e-3`, each with a unit or without; `true`, `false`; `\"text\"` with `\\\"`, `\\\\`, `\\n`, `\\t`,
`\\u{1F30D}`; `#rgb`, `#rrggbb`.

Operators, the tightest first: `.` `[]` `()` · `^` (from the right) · `-` `!` in front · `*` `/` · `+` `-` · `<` `<=` `>` `>=` `==`
`!=` (not chained) · `&&` · `||` · `..`.

Values that are always there: `time`, the seconds since the start of the scene, and `frame`, which is `time` times `fps`. In
materials also the point of the surface: `p`, `p_local`, `uv`, `normal`; see [procedural.md](procedural.md).

Keywords, which cannot be names: `after as ease else false fn for from if import in keys lang let like param prefab return
true`.
";

const UNITS_HEAD: &str = "
## Units

Glued to the number: `50cm`. They combine with `*`, `/` and `^`, glued too: `9.81m/s^2`, `5W/m^2/sr`. `%` is a hundredth.
`f` is a frame, `1 / fps` seconds.

| of | units |
|---|---|
";

fn units(page: &mut String) {
    let mut seen: Vec<Dimension> = Vec::new();
    for &(_, _, of) in UNITS {
        if seen.contains(&of) {
            continue;
        }
        seen.push(of);
        let units = UNITS.iter().filter(|row| row.2 == of).map(|&(name, factor, _)| match (name, of) {
            ("f", _) => "`f`".to_string(),
            _ if factor != 1.0 => format!("`{name}` ({})", show(factor, of)),
            _ => format!("`{name}`"),
        });
        writeln!(page, "| {} | {} |", of.with_article(), units.collect::<Vec<_>>().join(", ")).unwrap();
    }
}

/// Title, what is said first, and the kinds.
const SECTIONS: &[(&str, &str, &[Sort])] = &[
    (
        "Picture and camera",
        "In all tables below *not set* is what a property is where it is not written, and *allowed* what its values are held to.\n\
         What may change over `time` says *time*, what may be a texture or differ from point to point *surface*. A unit in brackets has to be written.",
        &[Sort::Render, Sort::Camera],
    ),
    ("Light", "A surface of the material `emitter` is a light too.", &[Sort::Sky, Sort::Light]),
    ("Materials", "Every material has these:", &[Sort::Material]),
    ("Shapes", "Every shape has these:", &[Sort::Shape]),
    ("Groups", "Nodes that stand in a group move with it.", &[Sort::Group]),
    ("Parts", "Written inside other nodes.", &[Sort::Part]),
    ("Physics", "See [physics.md](physics.md).", &[Sort::Simulation, Sort::Joint]),
];

/// The properties that all of several kinds have.
fn shared(kinds: &[&'static Kind]) -> Vec<&'static Property> {
    let Some((first, rest)) = kinds.split_first() else { return Vec::new() };
    let everywhere = |property: &&Property| rest.iter().all(|kind| kind.all().any(|other| other == *property));
    if rest.len() < 3 { Vec::new() } else { first.all().filter(everywhere).collect() }
}

fn describe(page: &mut String, kind: &'static Kind, shared: &[&'static Property]) {
    let not_yet = if kind.since == Since::Later { " *Not yet.*" } else { "" };
    let name = if kind.name == MIX.name { "mix(a, b, amount: ..)" } else { kind.name };
    let inside = match kind.place {
        Place::Inside([]) => " Inside a shape or a group.".to_string(),
        Place::Inside(kinds) => format!(" Inside a {}.", list(kinds.iter().copied())),
        _ => String::new(),
    };
    write!(page, "\n### `{name}`\n\n{}.{inside}{not_yet}\n", sentence(kind.doc)).unwrap();
    table(page, kind.all().filter(|property| !shared.contains(property)));
}

fn table(page: &mut String, properties: impl Iterator<Item = &'static Property>) {
    let mut properties = properties.peekable();
    if properties.peek().is_none() {
        return;
    }
    *page += "\n| property | type | not set | allowed | changes | meaning |\n|---|---|---|---|---|---|\n";
    for property in properties {
        let changes: Vec<&str> = [(property.animatable, "time"), (property.varies, "surface")]
            .iter()
            .filter(|row| row.0)
            .map(|row| row.1)
            .collect();
        let later = match property.since {
            Since::Now => "",
            Since::Later => " *(not yet)*",
            Since::Default => " *(only this value yet)*",
        };
        writeln!(
            page,
            "| `{}` | {} | {} | {} | {} | {}{later} |",
            property.name,
            property.type_text(),
            property.default_text(),
            property.check.text(),
            changes.join(", "),
            property.doc.replace('|', "\\|"),
        )
        .unwrap();
    }
}

const TOPICS: &[(Topic, &str, &str)] = &[
    (Topic::Number, "Numbers", "A *number* may have any unit, and others beside it need the same; a *float* has none."),
    (Topic::List, "Lists", ""),
    (Topic::Vector, "Vectors", "A *vector* has 2 to 4 components of any one unit."),
    (Topic::Rotation, "Rotations", "`a * b` of two rotations does b first; `a * v` turns a vector."),
    (Topic::Color, "Colours", "All become linear Rec. 709, which `.r .g .b` give back."),
    (Topic::Random, "Chance", "The same arguments give the same number, in every version and on every machine."),
    (Topic::Texture, "Textures", "For properties that change over the *surface*."),
    (Topic::Node, "Nodes", ""),
];

fn functions(page: &mut String) {
    *page += "\n## Functions\n\nArguments go by place or by name: `mix(a, b, amount: 0.3)`; those with `?` may be left out.\n";
    for (topic, title, about) in TOPICS {
        write!(page, "\n### {title}\n").unwrap();
        if !about.is_empty() {
            write!(page, "\n{about}\n").unwrap();
        }
        *page += "\n| function | gives | |\n|---|---|---|\n";
        for function in BUILTINS.iter().filter(|function| function.topic == *topic) {
            let own = function.params.iter().map(|param| {
                let words: Vec<String> = param.words.iter().map(|word| format!("`{}`", word.name)).collect();
                let takes = if words.is_empty() { param.takes.to_string() } else { words.join(" ") };
                format!("{}{}: {takes}", param.name, if param.optional { "?" } else { "" })
            });
            let params: Vec<String> = function.rest.iter().map(|rest| format!("{rest} ..")).chain(own).collect();
            let doc = function.doc.replace('|', "\\|");
            writeln!(page, "| **{}**({}) | {} | {doc} |", function.name, params.join(", "), function.gives).unwrap();
        }
    }
    assert!(builtin::BUILTINS.iter().all(|function| TOPICS.iter().any(|row| row.0 == function.topic)));
}

fn easing(page: &mut String) {
    let jumps: Vec<&str> = ease::JUMPS.iter().map(|row| row.0).collect();
    write!(
        page,
        "\n## Easing\n\nAfter `ease`, the way to a key: {}; `bezier(x1, y1, x2, y2)` with x in 0..1, `steps(n, {})`, \
         `spring(mass, stiffness, damping)` in seconds; the name of a function of one number.\n",
        list(ease::names().iter().map(String::as_str)),
        jumps.join(" | "),
    )
    .unwrap();
}

fn the_limits(page: &mut String) {
    *page += "\n## Limits\n\nA scene cannot raise them.\n\n| at most | |\n|---|---|\n";
    let bytes = |bytes: u64| format!("{} MiB", bytes >> 20);
    let count = |count: usize| spaced(count as f64);
    for (what, limit) in [
        ("files of a scene", count(limits::FILES)),
        ("files that import one another in a row", count(limits::IMPORTS_DEEP)),
        ("a scene file", bytes(MAX_SOURCE_BYTES as u64)),
        ("a picture or model file", bytes(MAX_ASSET_BYTES)),
        ("brackets in brackets", count(MAX_NESTING)),
        ("steps of the evaluation", spaced(limits::FUEL as f64)),
        ("calls of functions and prefabs in one another", spaced(f64::from(limits::CALLS))),
        ("turns of a loop", spaced(limits::LOOP as f64)),
        ("nodes", count(limits::NODES)),
        ("instances", count(limits::INSTANCES)),
        ("items of a list, those of its lists included", count(limits::LIST)),
        ("lists in lists", spaced(f64::from(limits::NESTING))),
        ("bytes of a text", count(limits::TEXT)),
        ("keys of a curve", count(limits::KEYS)),
        ("operations over time", count(limits::OPERATIONS)),
        ("groups in groups", spaced(f64::from(limits::GROUPS))),
        ("materials in a material", count(limits::LAYERS)),
        ("triangles of a mesh", count(limits::TRIANGLES)),
    ] {
        writeln!(page, "| {what} | {limit} |").unwrap();
    }
}

fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.map(|name| format!("`{name}`")).collect::<Vec<_>>().join(" ")
}

/// With a capital letter.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}
